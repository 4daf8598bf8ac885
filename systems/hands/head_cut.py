"""A region that holds more than the head in it, divided into head and what is left: neck, arm, a wall of skin's colour."""

from dataclasses import replace

import cv2
import numpy as np

from vipr.systems.hands.candidates import Candidate
from vipr.systems.hands.parts import Track, smallest_hand
from vipr.systems.signals import SkinRegions

BULGE = 0.15  # of the face: what moves beside the head in its region can be a hand from this size
MOVING = 60  # of 255


def cut_out_head(face: Track | None, found: list[Candidate], regions: SkinRegions, u: float, missing: bool = False):
    """Labels and regions in which a region much larger than the head in it is divided into head and what is left of it.

    While a hand is ``missing``, a region that bulges is divided too: a hand that comes to the chin is in one region with the face at once.
    """
    if face is None or face.unseen > 0.2 or not found:
        return regions.labels, found
    f, radius = face.filter, face.head_radius
    row = int(regions.labels[int(f.y + 0.5), int(f.x + 0.5)]) - 1
    whole = next((r for r in found if r.row == row), None)
    if whole is None or (whole.area < 1.7 * face.area and not missing):
        return regions.labels, found
    y, x = np.nonzero(regions.labels == row + 1)
    away = ((x - f.x) / (1.25 * radius)) ** 2 + ((y - f.y) / (1.55 * radius)) ** 2 > 1.0
    moving = regions.motion[y, x] >= MOVING
    bulge = np.count_nonzero(away & moving) > 1.5 * smallest_hand(face, BULGE, u) and 2 * np.count_nonzero(
        moving
    ) < len(x)
    if whole.area < 1.7 * face.area and not bulge:
        return regions.labels, found
    neck = (np.abs(x - f.x) < radius) & (y > f.y) & (y < f.y + 3.2 * radius) & ~moving
    labels = regions.labels.copy()
    labels[y[away], x[away]] = 0
    parts = np.zeros(labels.shape, np.uint8)
    parts[y[away & ~neck], x[away & ~neck]] = 1
    n, pieces, stats, centres = cv2.connectedComponentsWithStats(
        cv2.erode(parts, np.ones((2, 2), np.uint8)), connectivity=4
    )
    px = np.column_stack([x, y])[~away]
    head = replace(
        whole, centre=px.mean(0) if len(px) else whole.centre, area=float(len(px)), core=np.array([f.x, f.y, radius]),
        box=np.array([f.x - radius, f.y - 1.3 * radius, 2 * radius, 2.6 * radius]), cut=True,
    )  # fmt: skip
    found = [head if r is whole else r for r in found]
    free = int(regions.labels.max())
    for k in range(1, n):
        area = float(stats[k, cv2.CC_STAT_AREA])
        if area < max(8.0 * u * u, smallest_hand(face, 0.1, u)) or free >= 250:
            continue
        mask = pieces == k
        free += 1
        labels[mask] = free
        box = stats[k, :4].astype(float)
        core = np.array([*centres[k], 0.5 * min(box[2], box[3])])
        moving = float(np.mean(regions.motion[mask])) / 255.0
        found.append(Candidate(free - 1, centres[k], area, box, core, whole.person, 0.1, remnant=True, moving=moving))
    return labels, found
