"""Movements and pauses of a real speaker's hands, as cut by the segmenter, beside what a specialist saw in the pictures.

Recordings of UCI Gesture Phase Segmentation: hands, head and spine in three dimensions, about 30 Hz, phases rest, preparation, stroke,
hold and retraction. Hands rest in the phases rest and hold and move in the others.
"""

import csv
from collections.abc import Iterator
from itertools import groupby
from pathlib import Path

import numpy as np

from vipr.scenarios.bench.tables import Table
from vipr.systems.errors import InputError
from vipr.systems.gestures.segmentation import segment
from vipr.systems.gestures.trajectories import Trajectory

RECORDINGS = ("a1", "a2", "a3")
MOVING = ("preparation", "stroke", "retraction")
FACE = 0.27  # of the distance from head to spine: about 0.15 m of 0.55 m


def run(bench) -> Iterator[Table]:
    """One row a recording."""
    rows = []
    for name in RECORDINGS:
        bench.progress(f"phases of {name}")
        times, points, phases = read_recording(bench.data / "gesture_phase" / "raw" / f"{name}_raw.csv")
        rows.append((name, len(times), *judge(times, phases, segment(times, points)).values()))
    columns = (
        "movements",
        "right",
        "moving precision %",
        "recall %",
        "pause precision %",
        "recall %, pauses",
        "strokes",
        "found",
    )
    yield Table(
        "Pauses of a speaker's hands",
        ("recording", "frames", *columns),
        rows,
        "By frames; a movement is right if the hands moved in at least half of it, a stroke found if movements cover half of it. The "
        "segmenter's settings are those for instructions: movements of less than 0.8 faces are none.",
    )


def read_recording(path: Path) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Times (T,) s, points (T, 4) of left and right hand from the head in faces, x and y up, and phases (T,) in small letters."""
    try:
        with path.open(newline="") as file:
            rows = list(csv.DictReader(file))
        columns = ("lhx", "lhy", "rhx", "rhy", "hx", "hy", "sx", "sy", "timestamp")
        left, right, head, spine, times = np.split(
            np.array([[float(r[c]) for c in columns] for r in rows]), (2, 4, 6, 8), 1
        )
        phases = np.array([r["phase"].lower() for r in rows])
    except OSError as error:
        raise InputError(f"{path}: cannot be read ({error.strerror})") from None
    except (KeyError, TypeError, ValueError) as error:
        raise InputError(f"{path}: is not a recording of gesture phases ({type(error).__name__}: {error})") from None
    face = FACE * np.median(np.linalg.norm(head - spine, axis=1))
    points = np.concatenate([left - head, right - head], axis=1) * (1.0, -1.0, 1.0, -1.0) / face
    return (times[:, 0] - times[0, 0]) / 1000.0, points, phases


def judge(times: np.ndarray, phases: np.ndarray, movements: list[Trajectory]) -> dict[str, float]:
    """Counts and percentages of what was cut against what was there."""
    true = np.isin(phases, MOVING)
    inside = [(times >= m.times[0]) & (times <= m.times[-1]) for m in movements]
    found = np.any(inside, axis=0) if inside else np.zeros(len(times), bool)
    strokes, at = [], 0
    for phase, frames in groupby(phases):
        length = len(list(frames))
        if phase == "stroke":
            strokes.append(found[at : at + length].mean() >= 0.5)
        at += length

    def share(hits, of):
        return 100.0 * float((hits & of).sum() / max(of.sum(), 1))

    return {
        "movements": len(movements), "right": int(sum(true[i].mean() >= 0.5 for i in inside)),
        "moving_precision": share(true, found), "moving_recall": share(found, true),
        "pause_precision": share(~true, ~found), "pause_recall": share(~found, ~true),
        "strokes": len(strokes), "found": int(sum(strokes)),
    }  # fmt: skip
