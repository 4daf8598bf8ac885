"""Follow face and hands through frames and write what was found: ``regions.csv``, ``overlay.mp4``, ``summary.json``.

Files are written under a temporary name and renamed at the end, so that a run that fails leaves an earlier result alone; a run that is
interrupted keeps what it has.
"""

import csv
import json
import os
import time
from collections import deque
from collections.abc import Callable, Mapping
from importlib.metadata import version
from pathlib import Path

import cv2
import numpy as np

from vipr.diagrams.seeing_people import Schedule, SeeingPeople
from vipr.scenarios.playback import Playback
from vipr.scenarios.replacements import load_stages
from vipr.systems.camera.video_frames import FrameSource
from vipr.systems.errors import InputError
from vipr.systems.hands.overlay import draw_people
from vipr.systems.hands.parts import PARTS
from vipr.systems.hands.pipeline import exchanged
from vipr.systems.recording.video import VideoWriter
from vipr.systems.signals import CameraFrame, HandTracks
from vipr.systems.skin.classifier import SkinOptions
from vipr.systems.skin.working_image import as_bgr

COLUMNS = (
    "frame", "time_s", "face_x", "face_y", "face_seen", "left_x", "left_y", "left_seen", "right_x", "right_y", "right_seen", "area_px",
)  # fmt: skip
TRAIL = 25  # frames
PERIOD = Schedule().period  # s, of the playback; frames keep their own times


def follow_video(
    source: FrameSource,
    out: Path,
    *,
    options: SkinOptions = SkinOptions(),
    stages: Mapping[str, str] | None = None,
    video: bool = True,
    mirrored: bool = False,
    progress: Callable[[int], None] = lambda frame: None,
) -> dict:
    """Run the chain over all frames and return the summary that was written.

    ``stages`` names others in the place of ``skin`` and ``hands`` (see ``scenarios.replacements``). Frames may be grey, have four channels
    or 16 bits, and may change their size (everything starts anew then). ``mirrored`` says that the picture shows the person as a mirror
    does; ``progress`` is called after each frame. Raises InputError where nothing could be read; KeyboardInterrupt passes after what there
    is has been put in place.
    """
    names = ["regions.csv", "summary.json"] + ["overlay.mp4"] * video
    temporary = {name: out / f".partial-{name}" for name in names}
    counts = {name: 0 for name in PARTS}
    state = {"frames": 0, "last": 0.0, "sizes": [], "coloured": False}
    spent, trail = [], deque(maxlen=TRAIL)

    def finish(complete: bool) -> dict:
        summary = {
            "source": source.name, "frames": state["frames"], "complete": complete, "duration_s": round(state["last"], 3),
            "sizes": state["sizes"], "mirrored": mirrored, "stages": dict(stages or {}), "seen": {name: counts[name] for name in PARTS},
            "median_ms": round(float(np.median(spent)), 3) if spent else None,
            "notes": [note for note in (source.note, "" if state["coloured"] else "no colour in any frame: skin cannot be told") if note],
            "versions": {name: version(name) for name in ("vipr", "numpy", "opencv-python-headless")},
        }  # fmt: skip
        temporary["summary.json"].write_text(json.dumps(summary, indent=2) + "\n")
        for name, path in temporary.items():
            if path.exists():
                os.replace(path, out / name)
        return summary

    others, eyes = load_stages(stages or {}), None
    try:
        with open(temporary["regions.csv"], "w", newline="") as file:
            writer, film = csv.writer(file), None
            writer.writerow(COLUMNS)
            try:
                for number, (image, at) in enumerate(source.frames):
                    image = as_bgr(image)
                    size = [image.shape[1], image.shape[0]]
                    if not state["sizes"] or state["sizes"][-1] != size:
                        eyes = Playback(SeeingPeople(options, stages=others), ("regions", "hand_tracks"), PERIOD)
                        trail.clear()
                        state["sizes"].append(size)
                    begin = time.perf_counter()
                    seen = eyes.show(CameraFrame(image, at, number))
                    spent.append(1e3 * (time.perf_counter() - begin))
                    tracks = exchanged(seen["hand_tracks"]) if mirrored else seen["hand_tracks"]
                    writer.writerow(row(number, at, tracks))
                    if video:
                        film = film or VideoWriter(temporary["overlay.mp4"], fps=float(np.clip(source.rate, 1, 240)))
                        picture = draw_people(image, seen["regions"], tracks, list(trail))
                        film.write(_fitted(picture, state["sizes"][0]))
                    trail.append(tracks)
                    state.update(frames=number + 1, last=at, coloured=state["coloured"] or _coloured(image))
                    for name in PARTS:
                        counts[name] += bool(getattr(tracks, f"{name}_seen"))
                    progress(number)
            finally:
                if film is not None:
                    film.close()
        if not state["frames"]:
            raise InputError(f"{source.name}: holds no frames")
    except KeyboardInterrupt:
        if state["frames"]:
            finish(False)
        raise
    except BaseException:
        for path in temporary.values():
            path.unlink(missing_ok=True)
        raise
    return finish(True)


def row(number: int, at: float, tracks: HandTracks) -> list:
    """One line of ``regions.csv``: positions in pixels, empty where never seen (a prediction where seen is 0); area of face and hands."""
    values = [number, f"{at:.4f}"]
    for name in PARTS:
        x, y = getattr(tracks, name)
        values += [f"{x:.2f}", f"{y:.2f}"] if np.isfinite(x) else ["", ""]
        values.append(int(getattr(tracks, f"{name}_seen")))
    return [*values, round(float(tracks.areas.sum()))]


def _coloured(image: np.ndarray) -> bool:
    part = image[::8, ::8].astype(int)
    return bool(np.ptp(part, axis=2).max() > 6)


def _fitted(picture: np.ndarray, size: list) -> np.ndarray:
    return picture if list(picture.shape[1::-1]) == size else cv2.resize(picture, tuple(size))
