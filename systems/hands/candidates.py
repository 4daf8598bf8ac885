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
    marks: float = 0.0  # 0 to 1: of a face, by themselves
    cut: bool = False  # the head cut out of a larger region
    remnant: bool = False  # what is left of a region without the head in it: neck, arm, wall
    arm: np.ndarray | None = None  # (2, 2) tip and other end, where it is an arm that reaches the head
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
    boxes = regions.boxes[rows] / s
    head = _headlike(
        centres,
        areas,
        boxes,
        cores,
        person,
        regions.faceness[rows],
        _contacts(regions.labels)[rows],
        regions.labels.shape,
    )
    return [
        Candidate(
            i, centres[k], float(areas[k]), boxes[k], cores[k], float(person[k]), float(head[k]),
            marks=float(regions.faceness[i]), moving=float(regions.moving[i]),
        )
        for k, i in enumerate(rows)
    ]  # fmt: skip


@compiled
def _headlike(centres, areas, boxes, cores, person, faceness, contacts, shape):
    """(n,) how much each region is like a head: marks of a face; above the rest, compact (the ratio is 1 for a disc, about 1.4 for a head,
    2.5 for an open hand) and wide. Arms are not, nor what comes in over the border without clearly looking like a face."""
    n = len(areas)
    evidence = np.minimum(np.maximum(2.0 * (person - 0.25), 0.0), 1.0)
    weight = evidence * (areas > 0.05 * areas.max())
    widest = widest_person = 0.0
    for k in range(n):
        widest = max(widest, cores[k, 2] if evidence[k] > 0.3 else 0.0)
        widest_person = max(widest_person, cores[k, 2] if person[k] > 0.5 else 0.0)
    widest = widest if widest > 0.0 else 1.0
    head = np.empty(n)
    for k in range(n):
        radius = cores[k, 2]
        below = (weight * (centres[:, 1] > centres[k, 1])).sum()
        topmost = (0.15 + below) / (0.3 + weight.sum() - weight[k])
        compact = _limited((3.2 - areas[k] / (np.pi * max(radius, 1.0) ** 2)) / 1.5)
        wide = 2.0 * min(1.0, radius / widest) - 1.0
        head[k] = 0.75 * faceness[k] + 0.1 * compact + 0.15 * topmost + 0.1 * wide
        head[k] -= 0.25 * _slender(areas[k], boxes[k], radius)
        if radius < SMALL * widest_person:
            head[k] -= 0.3
        if _enters(cores[k], contacts[k], shape):
            head[k] -= min(max(0.9 - 1.5 * faceness[k], 0.0), 0.3)
    return head


@compiled
def _limited(x):
    return min(max(x, 0.0), 1.0)


@compiled
def _slender(area, box, radius):
    """0 to 1: how far a region is long and nowhere wide, as arms are.

    An arm fills about half of its length times its width; a head in one region with a wall or a shelf fills more, or less.
    """
    length, width = np.hypot(box[2], box[3]), 2.0 * max(radius, 1.0)
    filled = area / (length * width)
    return _limited((length / width - 3.4) / 0.8) * _limited(min(12.5 * (filled - 0.4), 2.6 - 1.6 * filled))


@compiled
def _enters(core, contact, shape):
    """Whether a region comes in over the border of the image as wide as an arm is for its hand; a head does not."""
    away = min(core[0], shape[1] - 1 - core[0], shape[0] - 1 - core[1])
    return contact > 0.7 * core[2] and away > 1.5 * core[2]


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
