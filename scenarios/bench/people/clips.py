"""Hit rates on real clips against another tracker's centres, which are a reference with confidences and not the truth."""

import csv
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from vipr.systems.camera.video_frames import open_video
from vipr.systems.hands.pipeline import PeopleBelief, see_people
from vipr.systems.signals import HandTracks
from vipr.systems.skin.classifier import SkinOptions
from vipr.systems.skin.working_image import as_bgr

FACE_TOLERANCE, HAND_TOLERANCE = 0.35, 0.5  # of the shoulder width
VISIBLE = 0.5  # confidence from which the reference counts
REFERENCE = {"face": "face", "left": "lhand", "right": "rhand"}


@dataclass(frozen=True)
class Hits:
    """Of one clip and part: frames in which the reference is visible, hits, and hits by either hand."""

    clip: str
    part: str
    visible: int
    hits: int
    either: int  # hits when the names of the hands do not count
    median_error: float  # of the shoulder width, over all visible frames in which the part is reported


def follow_clip(path: Path, options: SkinOptions = SkinOptions(), rate: float | None = None) -> list[HandTracks]:
    """The tracks of every frame of a clip."""
    belief, tracks = PeopleBelief(), []
    for number, (image, at) in enumerate(open_video(path, rate).frames):
        belief = see_people(as_bgr(image), at, number, belief, options)
        tracks.append(belief.tracks)
    return tracks


def read_reference(path: Path) -> list[dict]:
    """Rows of a ``*.gt_mediapipe.csv`` as numbers."""
    with open(path, newline="") as file:
        return [{k: float(v) for k, v in line.items()} for line in csv.DictReader(file)]


def score_clip(name: str, tracks: list[HandTracks], reference: list[dict]) -> list[Hits]:
    """Hits of face and each hand.

    A frame counts where the reference's visibility is at least 0.5; it is a hit where the part is seen within 0.35 (face) or 0.5 (hand)
    shoulder widths of the reference.
    """
    result = []
    for part, column in REFERENCE.items():
        tolerance = FACE_TOLERANCE if part == "face" else HAND_TOLERANCE
        visible = hits = either = 0
        errors = []
        for t, r in zip(tracks, reference, strict=False):
            if r[f"{column}_vis"] < VISIBLE:
                continue
            visible += 1
            want, shoulder = np.array([r[f"{column}_x"], r[f"{column}_y"]]), r["shoulder_px"]
            distance = {p: np.hypot(*(getattr(t, p) - want)) / shoulder for p in REFERENCE if getattr(t, f"{p}_seen")}
            if part in distance:
                errors.append(distance[part])
            hits += distance.get(part, np.inf) < tolerance
            names = ("face",) if part == "face" else ("left", "right")
            either += min(distance.get(p, np.inf) for p in names) < tolerance
        if visible:
            result.append(Hits(name, part, visible, hits, either, float(np.median(errors)) if errors else float("nan")))
    return result


def clips_with_reference(data: Path) -> Iterator[tuple[str, Path, list[dict]]]:
    """Name, file and rows of the reference of every clip below ``data``/video that has one beside it."""
    for reference in sorted((data / "video").rglob("*.gt_mediapipe.csv")):
        clip = reference.name.removesuffix(".gt_mediapipe.csv")
        video = next(p for p in sorted(reference.parent.iterdir()) if p.stem == clip and p.suffix != ".csv")
        yield clip, video, read_reference(reference)


def run_clips(data: Path, options: SkinOptions = SkinOptions(), most: int | None = None) -> list[Hits]:
    """Hits of every clip that has a reference, in its first ``most`` frames."""
    result = []
    for clip, video, rows in clips_with_reference(data):
        rows = rows[:most]
        result += score_clip(clip, follow_clip(video, options)[: len(rows)], rows)
    return result


def lone_hands(data: Path) -> tuple[int, int, float, float, float]:
    """Clips and frames below ``data``/video/hand_*, and the shares of frames in which a face, a hand and two hands are reported."""
    clips = sorted(path for path in (data / "video").glob("hand_*/**/*") if path.suffix in (".m4v", ".mp4"))
    seen = [(t.face_seen, t.left_seen, t.right_seen) for clip in clips for t in follow_clip(clip)]
    face, left, right = np.array(seen, bool).reshape(-1, 3).T
    n = max(len(face), 1)
    return len(clips), len(face), face.sum() / n, (left | right).sum() / n, (left & right).sum() / n
