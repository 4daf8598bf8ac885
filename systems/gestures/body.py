"""Where the hands are as seen from the face: the coordinates in which instructions are trained and recognised.

A point is (left x, left y, right x, right y) from the middle of the face, x to the image's right, y up, in faces (the square root of the
face's area in the image, about 0.15 m), so that neither the place of the person in the image nor the distance matters.
"""

from dataclasses import dataclass

import numpy as np

from vipr.systems.gestures.trajectories import Trajectory
from vipr.systems.hands.parts import PARTS
from vipr.systems.signals import HandTracks

EXCHANGED = 2.0  # faces that both hands together travel less if their names were exchanged between two frames
CROSSED = 0.5  # faces by which, on average of beginning and end, the left hand is on the right of the right one: names were exchanged
HANGING = np.array([2.2, -5.2, -2.2, -5.2])  # a hand that was never seen is taken to hang at the side
MEMORY = 75  # frames over which the size of the face is the median


@dataclass(frozen=True, eq=False)
class BodyBelief:
    """Face and hands as last seen."""

    face: tuple[float, float] | None = None  # px, smoothed
    sizes: tuple[float, ...] = ()  # px, of the face in the last frames
    hands: tuple[float, ...] = tuple(HANGING)  # last seen point


def seen_from_face(belief: BodyBelief, tracks: HandTracks) -> tuple[BodyBelief, np.ndarray | None]:
    """The belief after these tracks and the point (4,); None until a face has been seen."""
    face, sizes = belief.face, belief.sizes
    if tracks.face_seen and np.isfinite(tracks.face).all():
        now = (float(tracks.face[0]), float(tracks.face[1]))
        face = now if face is None else (0.8 * face[0] + 0.2 * now[0], 0.8 * face[1] + 0.2 * now[1])
        area = tracks.areas[PARTS.index("face")]
        if "face" not in tracks.merged and area > 0:
            sizes = (*sizes[-MEMORY + 1 :], float(np.sqrt(area)))
    if face is None or not sizes:
        return BodyBelief(face, sizes, belief.hands), None
    size, hands = float(np.median(sizes)), list(belief.hands)
    for k, side in enumerate(("left", "right")):
        p = getattr(tracks, side)
        if getattr(tracks, f"{side}_seen") and np.isfinite(p).all():
            hands[2 * k : 2 * k + 2] = [(p[0] - face[0]) / size, (face[1] - p[1]) / size]
    return BodyBelief(face, sizes, tuple(hands)), np.array(hands)


def told_apart(movement: Trajectory) -> Trajectory:
    """The movement (T, 4) of two hands with their names mended, where a tracker exchanged them in its course or before it.

    Hands do not jump to each other's places, and wherever they go between, they seldom are crossed where a movement begins and ends.
    """
    hands = movement.points.reshape(-1, 2, 2)
    kept, exchanged = (
        np.linalg.norm(hands[1:] - before, axis=2).sum(axis=1) for before in (hands[:-1], hands[:-1, ::-1])
    )
    wrong = np.r_[False, np.cumsum(exchanged + EXCHANGED < kept) % 2 == 1]
    mended = np.where(wrong[:, None, None], hands[:, ::-1], hands)
    if np.mean(mended[[0, -1], 0, 0] - mended[[0, -1], 1, 0]) < -CROSSED:
        mended = mended[:, ::-1]
    return Trajectory(mended.reshape(-1, 4), movement.times)


def direction(points: np.ndarray) -> np.ndarray:
    """(2,) unit vector in the image (x right, y up) from where a movement (T, 4) began to where it went furthest, of the hand that went
    further; zero if nothing moved."""
    away = points.reshape(len(points), -1, 2) - points[0].reshape(-1, 2)
    far = np.linalg.norm(away, axis=2)
    t, hand = np.unravel_index(far.argmax(), far.shape)
    return away[t, hand] / far[t, hand] if far[t, hand] > 0 else np.zeros(2)
