"""Work in other processes: some at a time, results in order, and a process that dies is replaced."""

import warnings
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import Future, ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from multiprocessing import get_context
from typing import Any

IN_VAIN = 3  # deaths on end, without a result between them, after which it is given up
RENEWED_AFTER = 10  # calls: what a renderer never gives back goes with its process


def in_processes(function: Callable, calls: Sequence[tuple], jobs: int = 1) -> Iterator[Any]:
    """``function(*call)`` of each call, in their order, ``jobs`` at a time, in processes that import everything anew now and then.

    A renderer is a library of others, and may take its process with it: what that process was doing is done again by a new one, with a
    warning. An error of the function comes through. ``function`` is found by its name in its module, as all that goes to another process.
    """
    kept: dict[int, Any] = {}  # results that came before their turn
    given = in_vain = 0
    while given < len(calls):
        before = given + len(kept)
        end = min(len(calls), given + RENEWED_AFTER * jobs)
        missing = [k for k in range(given, end) if k not in kept]
        with ProcessPoolExecutor(min(jobs, max(1, len(missing))), get_context("spawn")) as pool:
            futures = {k: pool.submit(function, *calls[k]) for k in missing}
            try:
                while given < end:
                    result = kept.pop(given) if given in kept else futures[given].result()
                    given += 1
                    yield result
                in_vain = 0
                continue
            except BrokenProcessPool:
                kept |= {k: future.result() for k, future in futures.items() if k >= given and _is_there(future)}
            finally:
                pool.shutdown(wait=False, cancel_futures=True)
        in_vain = 0 if given + len(kept) > before else in_vain + 1
        if in_vain == IN_VAIN:
            raise RuntimeError(f"{function.__name__}: its process died {IN_VAIN} times on end")
        warnings.warn(
            f"a process died at {function.__name__}; another does its work again", RuntimeWarning, stacklevel=2
        )


def _is_there(future: Future) -> bool:
    return future.done() and not future.cancelled() and future.exception() is None
