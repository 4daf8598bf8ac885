"""Table I: what each stage of seeing people costs, at growing sizes of the image."""

import tempfile
import time
from importlib.util import find_spec
from pathlib import Path

import cv2
import numpy as np

from vipr.scenarios.bench.people.rooms import film
from vipr.scenarios.bench.tables import Table
from vipr.scenarios.people.scenes import random_scene
from vipr.systems.camera.video_frames import open_video
from vipr.systems.hands import kalman
from vipr.systems.hands.pipeline import PeopleBelief, see_people
from vipr.systems.recording.video import VideoWriter
from vipr.systems.skin.classifier import SkinOptions

SIZES = ((160, 120), (320, 240), (640, 480), (1280, 720))
REDUCED = (1280, 720, "1280x720, reduced")  # as the chain does unless told otherwise
WARM_UP = 10  # frames that are not timed
ROUNDS = 3  # the best of which counts: what else the machine does only adds
PAPER_MS = {"retrieval": 4.3, "segmentation": 0.6, "density": 2.1, "components": 2.1, "Kalman": 0.3}
ROWS = (
    "retrieval", "segmentation", "density", "components", "Kalman", "light", "motion", "description", "learning", "tracking", "reduction",
)  # fmt: skip


def time_table(frames: int, progress) -> Table:
    """Processor time [ms] a frame of each stage, median of frames of a rendered scene, at the full size given and reduced."""
    columns = ("stage [ms a frame]", "paper, 160x120", *(f"{w}x{h}" for w, h in SIZES), REDUCED[2])
    cells: dict[str, list[float]] = {row: [] for row in (*ROWS, "total")}
    small = [image for image, _ in film(random_scene(1, seconds=frames / 25.0))]
    for w, h, area in (*((w, h, w * h) for w, h in SIZES), (*REDUCED[:2], SkinOptions().working_area)):
        progress(f"time at {w}x{h}")
        images = [
            image if (w, h) == (160, 120) else cv2.resize(image, (w, h), interpolation=cv2.INTER_CUBIC)
            for image in small
        ]
        rounds = [_one_round(images, SkinOptions(working_area=float(area))) for _ in range(ROUNDS)]
        for row in ROWS:
            cells[row].append(1e3 * min(spent[row] for spent in rounds))
        cells["total"].append(sum(cells[row][-1] for row in ROWS if row != "Kalman"))
    rows = [(row, PAPER_MS.get(row, 9.4 if row == "total" else float("nan")), *cells[row]) for row in (*ROWS, "total")]
    note = (
        f"Median of the frames, the best of {ROUNDS} rounds. Retrieval decodes H.264; segmentation is chromaticity and table; Kalman is "
        "three predictions and updates and part of tracking (with assignment, merging, births); light, motion, description and learning "
        "are beyond the paper's chain. "
        + ("" if find_spec("mediapipe") else "MediaPipe is not installed: no comparison.")
    )
    return Table("Table I: processor time of each stage", columns, rows, note)


def _one_round(images: list[np.ndarray], options: SkinOptions) -> dict[str, float]:
    """Time [s] of each stage, as usual among the images."""
    watch, belief = _Stopwatch(), PeopleBelief()
    for k, image in enumerate(images):
        watch.start()
        belief = see_people(image, k / 25.0, k, belief, options, watch)
        if k >= WARM_UP:
            watch.end_of_frame()
    watch.spent["retrieval"] = _retrieval(images)
    watch.spent["Kalman"] = [_kalman_time() for _ in range(50)]
    return {row: _usual(watch.spent.get(row, [0.0])) for row in ROWS}


def _usual(spent: list[float]) -> float:
    """Median of the times that were spent, times the share of frames in which any was (learning is done ten times a second)."""
    busy = [t for t in spent if t > 0]
    return float(np.median(busy)) * len(busy) / len(spent) if busy else 0.0


class _Stopwatch:
    """The processor time between marks of every frame, by the name of the mark that ends it [s]."""

    def __init__(self):
        self.spent: dict[str, list[float]] = {}
        self._frame, self._last = {}, 0.0

    def start(self) -> None:
        """A frame begins."""
        self._frame, self._last = {}, time.process_time()

    def __call__(self, name: str) -> None:
        now = time.process_time()
        self._frame[name] = self._frame.get(name, 0.0) + now - self._last
        self._last = time.process_time()

    def end_of_frame(self) -> None:
        """Keep this frame's times; learning is not done in every frame."""
        for name in {*self._frame, "learning"}:
            self.spent.setdefault(name, []).append(self._frame.get(name, 0.0))


def _retrieval(images: list[np.ndarray]) -> list[float]:
    """Times [s] to decode each image from an H.264 file."""

    spent = []
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "clip.mp4"
        with VideoWriter(path, fps=25) as video:
            for image in images:
                video.write(image)
        frames = iter(open_video(path).frames)
        next(frames)
        while True:
            begin = time.process_time()
            if next(frames, None) is None:
                return spent
            spent.append(time.process_time() - begin)


def _kalman_time() -> float:
    tracks = [kalman.start(10.0 * k, 5.0, 0.8, 60.0) for k in range(3)]
    begin = time.process_time()
    for k in tracks:
        kalman.update(kalman.predict(k, 0.04, 2600.0), 12.0, 6.0, 0.8)
    return time.process_time() - begin
