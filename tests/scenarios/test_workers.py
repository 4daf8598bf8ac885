"""Work in other processes comes back in order, errors with it, and a process that dies is replaced."""

import os
import signal
from pathlib import Path

import pytest

from vipr.scenarios import workers
from vipr.scenarios.workers import in_processes


def process(n, _folder):
    return os.getpid()


def half(n, _folder):
    return n / 2


def dies_once_at_three(n, folder):
    seen = Path(folder) / "seen"
    if n == 3 and not seen.exists():
        seen.touch()
        os.kill(os.getpid(), signal.SIGSEGV)
    return 10 * n


def dies(n, _folder):
    os.kill(os.getpid(), signal.SIGKILL)


def fails(n, _folder):
    raise ValueError(f"no {n}")


def test_results_come_in_order_and_errors_come_through(tmp_path):
    assert list(in_processes(half, [(n, tmp_path) for n in range(4)], jobs=2)) == [0, 0.5, 1, 1.5]
    assert list(in_processes(half, [])) == []
    with pytest.raises(ValueError, match="no 7"):
        list(in_processes(fails, [(7, tmp_path)]))


def test_processes_are_renewed_after_some_calls(tmp_path, monkeypatch):
    monkeypatch.setattr(workers, "RENEWED_AFTER", 3)
    pids = list(workers.in_processes(process, [(n, tmp_path) for n in range(7)]))
    assert len(set(pids[:3])) == len(set(pids[3:6])) == 1 and len(set(pids)) == 3


def test_what_a_dead_process_was_doing_is_done_again(tmp_path):
    with pytest.warns(RuntimeWarning, match="a process died at dies_once_at_three; another does its work again"):
        assert list(in_processes(dies_once_at_three, [(n, tmp_path) for n in range(6)])) == [0, 10, 20, 30, 40, 50]


@pytest.mark.filterwarnings("ignore:a process died:RuntimeWarning")
def test_what_always_dies_is_given_up(tmp_path):
    with pytest.raises(RuntimeError, match="dies: its process died 3 times on end"):
        list(in_processes(dies, [(1, tmp_path)]))
