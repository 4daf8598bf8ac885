"""Run folders are read back with other people's readers: after a good end, an exception, Ctrl-C, kill -9 and a full disk."""

import json
import os
import re
import signal
import subprocess
import sys
import time
from pathlib import Path

import av
import numpy as np
import pytest
from logs_read_back import messages, messages_of_a_cut_log
from recording_ticks import fill, finished_folder, folder, tick

from vipr.systems.errors import InputError
from vipr.systems.recording.channels import ImageChannel, PoseChannel, VectorChannel
from vipr.systems.recording.folder import WAITING
from vipr.systems.recording.log import RunLog
from vipr.systems.recording.summary import without_time

TICKS = 20


def summary(path):
    return json.loads((path / "summary.json").read_text())


def frames(path):
    with av.open(str(path)) as container:
        return [frame.to_ndarray(format="bgr24") for frame in container.decode(video=0)]


@pytest.fixture(scope="module")
def finished(tmp_path_factory):
    return finished_folder(tmp_path_factory.mktemp("runs") / "good")


def test_a_finished_run_leaves_its_files_and_nothing_else(finished):
    assert sorted(p.name for p in finished.iterdir()) == ["log.mcap", "report.html", "summary.json", "video.mp4"]
    assert (summary(finished)["success"], summary(finished)["reason"]) == (True, "held the pose")
    assert summary(finished)["time"]["simulated_s"] == pytest.approx(0.76)


def test_the_video_has_a_frame_a_tick_and_repeats_the_last_for_a_dropped_one(tmp_path):
    frame = tick(9)["camera"]
    with folder(tmp_path, channels=[ImageChannel("camera", video=True)]) as run:
        for k in range(6):
            run.record(0.04 * k, {"camera": type(frame)(number=k) if k in (0, 3) else frame})
    images = frames(tmp_path / "video.mp4")
    assert len(images) == 5  # nothing before the first image
    assert np.abs(images[2].astype(int) - frame.image).max() <= 3


def test_no_video_is_made_if_none_is_wanted(tmp_path):
    with folder(tmp_path, video=False) as run:
        fill(run)
    assert not (tmp_path / "video.mp4").exists()
    assert len(messages(tmp_path / "log.mcap")["/camera"]) == TICKS // 2


def test_the_same_run_twice_gives_the_same_summary(finished, tmp_path):
    with folder(tmp_path) as run:
        fill(run)
        run.finish(success=True, reason="held the pose", figures={"final_translation_error_mm": 0.8})
    assert without_time(tmp_path / "summary.json") == without_time(finished / "summary.json")


@pytest.mark.parametrize(
    "error, reason",
    [
        (KeyboardInterrupt(), "interrupted"),
        (InputError("camera: no light"), "camera: no light"),
        (ZeroDivisionError("by\nnought"), "ZeroDivisionError: by nought"),
    ],
)
def test_an_exception_ends_the_run_with_whole_files_and_its_reason(tmp_path, error, reason):
    with pytest.raises(type(error)), folder(tmp_path) as run:
        fill(run)
        raise error
    assert (summary(tmp_path)["success"], summary(tmp_path)["reason"]) == (False, reason)
    assert len(messages(tmp_path / "log.mcap")["/q"]) == TICKS
    assert len(frames(tmp_path / "video.mp4")) == TICKS
    assert reason in (tmp_path / "report.html").read_text()


def test_leaving_without_an_end_says_so(tmp_path):
    with folder(tmp_path) as run:
        fill(run, 3)
    assert (summary(tmp_path)["success"], summary(tmp_path)["reason"]) == (False, "did not finish")


PROGRAM = """
import os, resource, signal, sys, time
sys.path[:0] = [{tests!r}]
from recording_ticks import PLOTS, fill, folder
from vipr.systems.errors import InputError
signal.signal(signal.SIGINT, signal.default_int_handler)  # a parent in the background leaves it ignored
{before}
try:
    with folder(sys.argv[1]) as run:
        fill(run, 40)
        {inside}
except InputError as error:
    print(error, file=sys.stderr)
    sys.exit(2)
except KeyboardInterrupt:
    sys.exit(130)
"""


def run_program(path, inside, before=""):
    code = PROGRAM.format(tests=str(Path(__file__).parents[2]), inside=inside, before=before)
    return subprocess.run([sys.executable, "-c", code, str(path)], capture_output=True, text=True, check=False)


def test_kill_9_leaves_a_readable_log_and_video_and_an_honest_summary(tmp_path):
    caught_up = "[time.sleep(0.01) for _ in iter(run._queue.empty, True)]; time.sleep(0.5)"  # for the tick taken last
    done = run_program(tmp_path, f"{caught_up}; os.kill(os.getpid(), signal.SIGKILL)")
    assert done.returncode == -signal.SIGKILL, done.stderr
    found = messages_of_a_cut_log(tmp_path / "log.mcap")
    assert [len(found[topic]) for topic in ("/q", "/X_CO_true", "/camera")] == [40, 40, 20]
    assert len(frames(tmp_path / "video.mp4")) >= 39
    assert (summary(tmp_path)["success"], summary(tmp_path)["reason"]) == (False, "did not finish")
    assert "did not finish" in (tmp_path / "report.html").read_text()


def test_ctrl_c_leaves_everything_closed(tmp_path):
    done = run_program(tmp_path, "os.kill(os.getpid(), signal.SIGINT); time.sleep(5)")
    assert done.returncode == 130, done.stderr
    assert summary(tmp_path)["reason"] == "interrupted"
    assert len(messages(tmp_path / "log.mcap")["/q"]) == 40
    assert len(frames(tmp_path / "video.mp4")) == 40


def test_a_full_disk_ends_the_run_with_one_line_that_names_the_file(tmp_path):
    limit = "resource.setrlimit(resource.RLIMIT_FSIZE, (20_000, 20_000))"
    done = run_program(tmp_path, "[fill(run, 40) for _ in range(200)]", before=limit)
    assert done.returncode == 2
    assert re.fullmatch(r"\S+/log\.mcap: cannot be written \(File too large\)\n", done.stderr), done.stderr
    assert "log.mcap: cannot be written" in summary(tmp_path)["reason"]
    found = messages_of_a_cut_log(tmp_path / "log.mcap")
    assert len(found["/q"]) > 5


@pytest.mark.skipif(not os.path.exists("/dev/full"), reason="no /dev/full here")
def test_a_video_that_finds_the_disk_full_stops_the_run(tmp_path):
    (tmp_path / "video.mp4").symlink_to("/dev/full")
    (tmp_path / "summary.json").write_text("{}")
    with pytest.raises(InputError, match=r"video\.mp4: cannot be written \(No space left"), folder(tmp_path) as run:
        (tmp_path / "video.mp4").symlink_to("/dev/full")
        for _ in range(100):
            fill(run)
    assert "video.mp4: cannot be written" in summary(tmp_path)["reason"]


@pytest.mark.parametrize("place", ["file/run", "file"])
def test_a_place_that_cannot_hold_a_folder_is_one_line(tmp_path, place):
    (tmp_path / "file").write_text("precious")
    with pytest.raises(InputError, match=rf"{place}: cannot be written"), folder(tmp_path / place):
        pass
    assert (tmp_path / "file").read_text() == "precious"


@pytest.mark.skipif(os.geteuid() == 0, reason="root may write anywhere")
def test_a_folder_without_permission_is_one_line_and_stays_as_it_is(tmp_path):
    (tmp_path / "summary.json").write_text("{}")
    tmp_path.chmod(0o500)
    with pytest.raises(InputError, match=rf"{tmp_path.name}: cannot be written \(Perm"), folder(tmp_path):
        pass
    assert [p.name for p in tmp_path.iterdir()] == ["summary.json"]


def test_an_earlier_run_is_kept_whole_and_only_one_of_them(tmp_path):
    for seed in (1, 2, 3):
        with folder(tmp_path, seed=seed) as run:
            fill(run, 3)
    assert (summary(tmp_path)["seed"], summary(tmp_path / "previous")["seed"]) == (3, 2)
    assert len(messages(tmp_path / "previous" / "log.mcap")["/q"]) == 3
    assert not (tmp_path / "previous" / "previous").exists()


def test_a_folder_of_other_things_is_refused_and_untouched(tmp_path):
    (tmp_path / "thesis.tex").write_text("precious")
    with pytest.raises(InputError, match="holds files but no earlier run"), folder(tmp_path):
        pass
    assert [p.name for p in tmp_path.iterdir()] == ["thesis.tex"]


def test_a_folder_in_which_a_run_is_writing_is_refused(tmp_path):
    with folder(tmp_path) as run:
        fill(run, 2)
        with pytest.raises(InputError, match="another run is writing there"), folder(tmp_path):
            pass
    assert len(messages(tmp_path / "log.mcap")["/q"]) == 2


def test_what_goes_wrong_in_the_thread_comes_out_at_the_next_tick(tmp_path):
    with pytest.raises(InputError, match="32x48"), folder(tmp_path) as run:
        fill(run, 1)
        image = np.zeros((48, 32, 3), np.uint8)
        for _ in range(10_000):
            run.record(0.04, tick(1) | {"camera": type(tick(1)["camera"])(image=image, number=1)})


def test_no_tick_is_dropped_when_writing_is_slower_than_the_run(tmp_path, monkeypatch):
    write = RunLog.write
    monkeypatch.setattr(RunLog, "write", lambda *arguments: (time.sleep(0.002), write(*arguments)))
    with folder(tmp_path, video=False) as run:
        fill(run, 3 * WAITING)
    assert len(messages(tmp_path / "log.mcap")["/q"]) == 3 * WAITING


def test_after_the_end_nothing_can_be_recorded(tmp_path):
    with folder(tmp_path) as run:
        run.finish(success=True, reason="done")
        with pytest.raises(RuntimeError, match="only between opening the folder and finishing"):
            run.record(0.0, tick(0))


@pytest.mark.parametrize(
    "channels, message",
    [
        ([PoseChannel("a"), PoseChannel("a")], "name of its own"),
        ([VectorChannel("a", ("x", "y"), ("m",))], "as many units as names"),
        ([ImageChannel("a", every=0)], "at least 1 frame, got 0"),
        ([ImageChannel("a", video=True), ImageChannel("b", video=True)], "one channel can be the video, got a, b"),
    ],
)
def test_impossible_channels_are_refused(tmp_path, channels, message):
    with pytest.raises(InputError, match=message):
        folder(tmp_path, channels=channels)
