"""The folder that a run leaves behind, written as the run goes.

    with RunFolder("out/demo", scenario="align", seed=1, channels=[...], settings={...}) as run:
        ...  # build a diagram with Recorder(run.channels, run.record), simulate
        run.finish(success=True, reason="held the pose", figures={"final_translation_error_mm": 0.8})

holds ``summary.json``, ``log.mcap``, ``video.mp4``, ``report.html`` and whatever else the scenario adds. A summary and a report that say
"did not finish" stand there from the start and are replaced, whole, at the end: also by an exception, also by Ctrl-C. One thread
encodes and writes; the caller only hands over values (nothing is dropped: where the thread falls behind, the caller waits).
"""

import contextlib
import fcntl
import os
import queue
import threading
import time
from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np

from vipr.systems.errors import InputError
from vipr.systems.recording.channels import Channel, Event, ImageChannel, check_channels
from vipr.systems.recording.diagram_picture import write_diagram
from vipr.systems.recording.files import cannot_be_written, write_whole
from vipr.systems.recording.history import History
from vipr.systems.recording.log import RunLog
from vipr.systems.recording.plots import Plot, PosePlot
from vipr.systems.recording.report import make_report
from vipr.systems.recording.summary import time_figures, write_summary
from vipr.systems.recording.video import VideoWriter
from vipr.systems.timing import LEDGER

FILES = ("log.mcap", "video.mp4", "report.html", "diagram.svg", "summary.json")  # a run's own; the summary goes last
UNFINISHED = "did not finish"
WAITING = 32  # ticks that may wait for the writing thread


class RunFolder:
    """What one run writes. Nothing touches the disk before the ``with`` statement.

    The folder is made if need be. One that holds an earlier run is taken over: the earlier run's files are kept, whole, in its
    folder ``previous`` (of which there is one). One that holds anything else is refused, and so is one that another run is writing.

    Args:
        path: the folder.
        scenario, seed, settings: what the summary says of the run; settings may nest.
        channels: what `record` will be given, in the recorder's order of ports.
        plots: what the report draws.
        frames: poses that never change, ``{(parent, child): X_PC (4, 4)}``.
        rate: ticks a second, of the video.
        video: whether to make video.mp4 of the channel marked for it.
    """

    def __init__(
        self,
        path: str | Path,
        *,
        scenario: str,
        seed: int,
        channels: Sequence[Channel] = (),
        settings: Mapping | None = None,
        plots: Sequence[Plot | PosePlot] = (),
        frames: Mapping[tuple[str, str], np.ndarray] | None = None,
        rate: float = 25.0,
        video: bool = True,
    ):
        self.path = Path(path)
        self.channels = check_channels(channels)
        self._about = {"scenario": scenario, "seed": seed, "settings": dict(settings or {})}
        self._plots, self._frames, self._rate = tuple(plots), dict(frames or {}), rate
        self._filmed = next((c.name for c in self.channels if isinstance(c, ImageChannel) and c.video and video), None)
        self._history = History(self.channels)
        self._queue: queue.Queue = queue.Queue(WAITING)
        self._error: BaseException | None = None
        self._thread: threading.Thread | None = None
        self._lock: int | None = None
        self._log: RunLog | None = None
        self._video: VideoWriter | None = None
        self._film_image: np.ndarray | None = None

    def __enter__(self) -> "RunFolder":
        self._lock = _take(self.path)
        try:
            self._began = time.perf_counter()
            self._conclude(False, UNFINISHED, {}, self._time(0.0, 0.0, {}))
            self._log = RunLog(self.path / "log.mcap", self.channels, self._frames)
            self._video = VideoWriter(self.path / "video.mp4", self._rate, preset="ultrafast")
        except BaseException:
            self._release()
            raise
        self._thread = threading.Thread(target=self._work, name="recording", daemon=True)
        self._thread.start()
        return self

    def __exit__(self, kind, error, traceback) -> None:
        if self._lock is None:
            return  # finished
        if error is None:
            self.finish(success=False, reason=UNFINISHED)
            return
        with contextlib.suppress(Exception):  # the error on its way says more, and may be the folder's own
            self.finish(success=False, reason=_reason(error))

    def record(self, time: float, values: Mapping[str, object]) -> None:
        """Hand over a tick: simulated time [s] and, by channel name, values that nobody will change any more.

        A `CameraFrame` for an image, (4, 4) or `ObjectPose` for a pose, (n,) for numbers and joints, `Status` for a status. What went
        wrong with an earlier tick is raised here.
        """
        self._put(time, dict(values), None)

    def event(self, time: float, source: str, text: str, level: str = "info") -> None:
        """Put an event (info, warning or error) on record that no channel tells of."""
        if level not in ("info", "warning", "error"):
            raise InputError(f"event {source}: level must be info, warning or error, got {level!r}")
        self._put(time, {}, Event(time, source, text, level))

    def history(self) -> History:
        """Everything recorded so far; waits until it is written, and raises what went wrong with it."""
        self._queue.join()
        if self._error is not None:
            raise self._error
        return self._history

    def draw(self, diagram) -> str:
        """Write ``diagram.svg``, a picture of the diagram; returns "" or why there is none, a line to show."""
        return write_diagram(diagram, self.path / "diagram.svg")

    def finish(
        self,
        *,
        success: bool,
        reason: str,
        figures: Mapping[str, object] | None = None,
        limits: Mapping[str, float] | None = None,
        wall_s: float | None = None,
        simulated_s: float | None = None,
        seconds: Mapping[str, float] | None = None,
    ) -> dict:
        """End the run: close its files, write summary and report, return the summary.

        Args:
            success: whether the task was done.
            reason: why it ended as it did, in a few words.
            figures: numbers by name with unit, ``final_translation_error_mm``.
            limits: what figures may reach at most, by the same names, for the report.
            wall_s: wall time that counts; since the folder was opened, if not given.
            simulated_s: simulated time; that of the last tick, if not given.
            seconds: wall time by name; that of the `LEDGER`, if not given.
        """
        timing = self._time(wall_s, simulated_s, LEDGER.seconds if seconds is None else seconds)
        failed = None
        try:
            self._stop()
        except Exception as error:
            failed, success, reason = error, False, _reason(error)
        if simulated_s is None:
            timing["simulated_s"] = self._history.duration
        try:
            summary = self._conclude(success, reason, figures or {}, timing, self._plots, limits or {})
        except InputError as error:
            failed = failed or error
        finally:
            self._release()
        if failed is not None:
            raise failed
        return summary

    def _put(self, time: float, values: dict, event: Event | None) -> None:
        if self._thread is None:
            raise RuntimeError(f"recording {self.path}: only between opening the folder and finishing")
        if self._error is not None:
            raise self._error
        self._queue.put((time, values, event))

    def _work(self) -> None:
        """The writing thread: everything put, in order; after an error, what comes is thrown away so that nobody waits."""
        while (tick := self._queue.get()) is not None:
            if self._error is None:
                try:
                    self._write(*tick)
                except BaseException as error:
                    self._error = error
            self._queue.task_done()

    def _write(self, time: float, values: dict, event: Event | None) -> None:
        if event is not None:
            self._history.events.append(event)
            self._log.write(time, {}, [event])
            return
        events = self._history.add(time, values)
        self._log.write(time, values, events)
        if self._filmed in values:
            frame = values[self._filmed]
            self._film_image = frame.image if frame.arrived else self._film_image
            if self._film_image is not None:  # a dropped frame repeats the last one: video time is simulated time
                self._video.write(self._film_image)

    def _stop(self) -> None:
        """Let the thread write what waits, then close the files; raises what went wrong with them."""
        if self._thread is not None:
            self._queue.put(None)
            self._thread.join()
            self._thread = None
        failed = self._error
        for file in (self._log, self._video):
            try:
                if file is not None:
                    file.close()
            except Exception as error:
                failed = failed or error
        self._log = self._video = None
        if failed is not None:
            raise failed

    def _release(self) -> None:
        with contextlib.suppress(Exception):  # raised before, or by the error on its way
            self._stop()
        if self._lock is not None:
            os.close(self._lock)
            self._lock = None

    def _time(self, wall_s: float | None, simulated_s: float | None, seconds: Mapping[str, float]) -> dict:
        wall = time.perf_counter() - self._began if wall_s is None else wall_s
        return {"wall_s": wall, "simulated_s": simulated_s or 0.0, "seconds": dict(seconds)}

    def _conclude(self, success, reason, figures, timing, plots=(), limits=None) -> dict:
        """Write summary and report in place of those that stand there."""
        entries = {"success": success, "reason": reason, "figures": figures, "time": time_figures(**timing)}
        summary = write_summary(self.path / "summary.json", **self._about, **entries)
        diagram = self.path / "diagram.svg"
        write_whole(
            self.path / "report.html", make_report(summary, self._history, plots=plots, limits=limits, diagram=diagram)
        )
        return summary


def _reason(error: BaseException) -> str:
    """The exception in one line."""
    if isinstance(error, KeyboardInterrupt):
        return "interrupted"
    text = " ".join(str(error).split())
    return text if isinstance(error, InputError) else f"{type(error).__name__}: {text}"


def _take(path: Path) -> int:
    """Make the folder if need be, lock it, put an earlier run's files aside. Returns the lock, a file descriptor."""
    try:
        path.mkdir(parents=True, exist_ok=True)
        lock = os.open(path, os.O_RDONLY | os.O_DIRECTORY)
    except OSError as error:
        raise cannot_be_written(path, error) from None
    try:
        try:
            fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            raise InputError(f"{path}: another run is writing there; give this one a folder of its own") from None
        others = [p for p in path.iterdir() if p.name != "previous" and not p.name.startswith(".")]
        if others and not (path / "summary.json").is_file():
            raise InputError(f"{path}: holds files but no earlier run (summary.json); give an empty or a new folder")
        probe = path / ".writable"
        probe.touch()  # before anything is moved
        probe.unlink()
        _keep_previous(path)
    except OSError as error:
        os.close(lock)
        raise cannot_be_written(path, error) from None
    except BaseException:
        os.close(lock)
        raise
    return lock


def _keep_previous(path: Path) -> None:
    """Move an earlier run's files to ``previous``, over those of the run before it."""
    if not (path / "summary.json").is_file():
        return
    previous = path / "previous"
    previous.mkdir(exist_ok=True)
    for name in FILES:
        (previous / name).unlink(missing_ok=True)
    for name in FILES:
        if (path / name).exists():
            os.replace(path / name, previous / name)
