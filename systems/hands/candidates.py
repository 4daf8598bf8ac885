"""The regions of a frame that may be of the person, and how much each is like a head. Pixels of the labels."""

from dataclasses import dataclass

import numpy as np

from vipr.systems.compiled import compiled
from vipr.systems.signals import SkinRegions

SMALL = 0.4  # of the widest region of the person: a head is not so much narrower than a hand


@dataclass(frozen=True, eq=False)
class Candidate:
    """A region as the tracker weighs it."""

    row: int
    centre: np.ndarray
    area: float
    box: np.ndarray
    core: np.ndarray  # x, y, radius of the largest disc inside
    person: float
    headlike: float  # 0 to 1: marks of a face, shape of a head, size and height among the regions of this frame
    cut: bool = False  # the head cut out of a larger region
    remnant: bool = False  # what is left of a region without the head in it: neck, arm, wall
    moving: float = 0.0  # 0 to 1, share of its pixels that move


def candidates(regions: SkinRegions, tracks: dict) -> list[Candidate]:
    """Regions that may be of the person, in pixels of the labels."""
    held = {int(regions.labels[int(t.filter.y + 0.5), int(t.filter.x + 0.5)]) - 1 for t in tracks.values()}
    rows = [i for i, person in enumerate(regions.person.tolist()) if person > 0.25 or i in held]
    if not rows:
        return []
    s, person = regions.scale, regions.person[rows]
    centres, areas = (regions.centres[rows] + 0.5) / s - 0.5, regions.areas[rows] / s**2
    cores = (regions.cores[rows] + (0.5, 0.5, 0.0)) / s - (0.5, 0.5, 0.0)
    evidence = np.minimum(np.maximum(2.0 * (person - 0.25), 0.0), 1.0)
    widest = max(cores[evidence > 0.3, 2], default=1.0)
    # Heads are above the rest, compact (the ratio is 1 for a disc, about 1.4 for a head, 2.5 for an open hand) and wide.
    weight = evidence * (areas > 0.05 * areas.max())
    below = (centres[:, 1] > centres[:, 1][:, None]) @ weight
    topmost = (0.15 + below) / (0.3 + weight.sum() - weight)
    spill = areas / (np.pi * np.maximum(cores[:, 2], 1.0) ** 2)
    compact = np.minimum(np.maximum((3.2 - spill) / 1.5, 0.0), 1.0)
    wide = 2.0 * np.minimum(1.0, cores[:, 2] / widest) - 1.0
    head = 0.75 * regions.faceness[rows] + 0.1 * compact + 0.15 * topmost + 0.1 * wide
    boxes = regions.boxes[rows] / s
    head -= 0.25 * _slender(areas, boxes, cores[:, 2])
    head -= 0.3 * (cores[:, 2] < SMALL * max(cores[person > 0.5, 2], default=0.0))
    # What clearly looks like a face may come in over the border.
    doubt = np.minimum(np.maximum(0.9 - 1.5 * regions.faceness[rows], 0.0), 0.3)
    head -= doubt * _enters(regions.labels, rows, cores)
    return [
        Candidate(
            i, centres[k], float(areas[k]), boxes[k], cores[k], float(person[k]), float(head[k]),
            moving=float(regions.moving[i]),
        )
        for k, i in enumerate(rows)
    ]  # fmt: skip


def _slender(areas: np.ndarray, boxes: np.ndarray, radii: np.ndarray) -> np.ndarray:
    """(n,) 0 to 1: how far regions are long and nowhere wide, as arms are.

    An arm fills about half of its length times its width; a head in one region with a wall or a shelf fills more, or less.
    """
    length, width = np.hypot(boxes[:, 2], boxes[:, 3]), 2.0 * np.maximum(radii, 1.0)
    filled = areas / (length * width)
    slenderness = (length / width - 3.4) / 0.8
    as_arms_fill = np.minimum(12.5 * (filled - 0.4), 2.6 - 1.6 * filled)
    return np.minimum(np.maximum(slenderness, 0.0), 1.0) * np.minimum(np.maximum(as_arms_fill, 0.0), 1.0)


def _enters(labels: np.ndarray, rows: list[int], cores: np.ndarray) -> np.ndarray:
    """(n,) whether regions come in over the border of the image as wide as an arm is for its hand; a head does not."""
    contact = _contacts(labels)[rows]
    h, w = labels.shape
    away = np.minimum(np.minimum(cores[:, 0], w - 1 - cores[:, 0]), h - 1 - cores[:, 1])
    return (contact > 0.7 * cores[:, 2]) & (away > 1.5 * cores[:, 2])


@compiled
def _contacts(labels):
    """(255,) of each region: its pixels on the border of the image where it has most; heads are cut by the upper one often enough."""
    h, w = labels.shape
    n = np.zeros((256, 3), np.int64)
    for x in range(w):
        n[labels[h - 1, x], 0] += 1
    for y in range(h):
        n[labels[y, 0], 1] += 1
        n[labels[y, w - 1], 2] += 1
    return np.maximum(np.maximum(n[1:, 0], n[1:, 1]), n[1:, 2])
