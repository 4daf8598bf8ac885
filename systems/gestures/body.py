"""Where the hands are as seen from the face: the coordinates in which instructions are trained and recognised.

A point is (left x, left y, right x, right y) from the middle of the face, x to the image's right, y up, in faces (the square root of the
face's area in the image, about 0.15 m), so that neither the place of the person in the image nor the distance matters.
"""

from dataclasses import dataclass

import numpy as np

from vipr.systems.hands.parts import PARTS
from vipr.systems.signals import HandTracks

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


def direction(points: np.ndarray) -> np.ndarray:
    """(2,) unit vector in the image (x right, y up) from where a movement (T, 4) began to where it went furthest, of the hand that went
    further; zero if nothing moved."""
    away = points.reshape(len(points), -1, 2) - points[0].reshape(-1, 2)
    far = np.linalg.norm(away, axis=2)
    t, hand = np.unravel_index(far.argmax(), far.shape)
    return away[t, hand] / far[t, hand] if far[t, hand] > 0 else np.zeros(2)
