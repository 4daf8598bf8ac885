"""A region that holds more than the head in it, divided into head and what is left: neck, arm, a wall of skin's colour."""

from dataclasses import replace

import cv2
import numpy as np

from vipr.systems.hands.arms import arm_at_head
from vipr.systems.hands.candidates import Candidate
from vipr.systems.hands.parts import Track, smallest_hand
from vipr.systems.signals import SkinRegions

BULGE = 0.15  # of the face: what moves beside the head in its region can be a hand from this size
MOVING = 60  # of 255


def cut_out_head(
    face: Track | None,
    found: list[Candidate],
    regions: SkinRegions,
    u: float,
    missing: bool = False,
    bare: bool = False,
):
    """Labels and regions in which a region much larger than the head in it is divided into head and what is left of it.

    While a hand is ``missing``, a region that bulges is divided too: a hand that comes to the chin is in one region with the face at once.
    So is one out of which an arm sticks, if arms have been seen ``bare``: its hand is before the face. (Of a covered arm it is the hand.)
    """
    if face is None or face.unseen > 0.2 or not found:
        return regions.labels, found
    f, radius = face.filter, face.head_radius
    row = int(regions.labels[int(f.y + 0.5), int(f.x + 0.5)]) - 1
    whole = next((r for r in found if r.row == row), None)
    if whole is None or (whole.area < 1.25 * face.area and not missing):
        return regions.labels, found
    mask = regions.labels == row + 1
    y, x = np.nonzero(mask)
    away = ((x - f.x) / (1.25 * radius)) ** 2 + ((y - f.y) / (1.55 * radius)) ** 2 > 1.0
    moving = regions.motion[y, x] >= MOVING
    bulge = np.count_nonzero(away & moving) > 1.5 * smallest_hand(face, BULGE, u) and 2 * np.count_nonzero(
        moving
    ) < len(x)
    beside = np.zeros(mask.shape, np.uint8)
    beside[y[away], x[away]] = 1
    smallest = max(8.0 * u * u, smallest_hand(face, 0.1, u))
    arms = []
    for piece in _pieces(beside, smallest) if bare else ():
        arm = arm_at_head(np.ascontiguousarray(np.argwhere(piece)[:, ::-1], float), face.position, face.head_height)
        if arm is not None:
            arms.append((piece, arm))
    if whole.area < 1.7 * face.area and not (bulge and missing) and not arms:
        return regions.labels, found
    neck = (np.abs(x - f.x) < radius) & (y > f.y) & (y < f.y + 3.2 * radius) & ~moving
    beside[y[neck], x[neck]] = 0
    for piece, _ in arms:
        beside[piece] = 0
    labels = regions.labels.copy()
    labels[y[away], x[away]] = 0
    px = np.column_stack([x, y])[~away]
    head = replace(
        whole, centre=px.mean(0) if len(px) else whole.centre, area=float(len(px)), core=np.array([f.x, f.y, radius]),
        box=np.array([f.x - radius, f.y - 1.3 * radius, 2 * radius, 2.6 * radius]), cut=True,
    )  # fmt: skip
    found = [head if r is whole else r for r in found]
    first = int(regions.labels.max())
    for free, (piece, arm) in enumerate([*arms, *((p, None) for p in _pieces(beside, smallest))], first + 1):
        if free > 250:
            break
        labels[piece] = free
        found.append(_remnant(piece, free - 1, arm, whole.person, regions.motion))
    return labels, found


def _pieces(mask: np.ndarray, smallest: float) -> list[np.ndarray]:
    """The connected pieces (h, w) bool of a mask (h, w) uint8, a little eroded, of ``smallest`` px and more."""
    n, labels, stats, _ = cv2.connectedComponentsWithStats(cv2.erode(mask, np.ones((2, 2), np.uint8)), connectivity=4)
    return [labels == k for k in range(1, n) if stats[k, cv2.CC_STAT_AREA] >= smallest]


def _remnant(piece: np.ndarray, row: int, arm: np.ndarray | None, person: float, motion: np.ndarray) -> Candidate:
    y, x = np.nonzero(piece)
    centre = np.array([x.mean(), y.mean()])
    box = np.array([x.min(), y.min(), np.ptp(x) + 1, np.ptp(y) + 1], float)
    core = np.array([*centre, 0.5 * min(box[2], box[3])])
    moving = float(np.mean(motion[piece])) / 255.0
    return Candidate(row, centre, float(len(x)), box, core, person, 0.1, remnant=True, arm=arm, moving=moving)
