"""The regions of a frame that may be of the person, and how much each is like a head. Pixels of the labels."""

from dataclasses import dataclass

import numpy as np

from vipr.systems.signals import SkinRegions


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
    largest = max(areas[evidence > 0.3], default=1.0)
    # Heads are above the rest, compact (the ratio is 1 for a disc, about 1.4 for a head, 2.5 for an open hand) and large.
    weight = evidence * (areas > 0.05 * areas.max())
    below = (centres[:, 1] > centres[:, 1][:, None]) @ weight
    topmost = (0.15 + below) / (0.3 + weight.sum() - weight)
    spill = areas / (np.pi * np.maximum(cores[:, 2], 1.0) ** 2)
    compact = np.minimum(np.maximum((3.2 - spill) / 1.5, 0.0), 1.0)
    head = 0.75 * regions.faceness[rows] + 0.1 * compact + 0.15 * topmost + 0.1 * np.minimum(1.0, areas / largest)
    boxes = regions.boxes[rows] / s
    return [
        Candidate(
            i, centres[k], float(areas[k]), boxes[k], cores[k], float(person[k]),
            float(head[k]) - 0.3 * _enters(regions.labels, i, cores[k]), moving=float(regions.moving[i]),
        )
        for k, i in enumerate(rows)
    ]  # fmt: skip


def _enters(labels: np.ndarray, row: int, core: np.ndarray) -> bool:
    """Whether a region comes in over the border of the image as wide as an arm is for its hand; a head does not."""
    edges = (labels[-1], labels[:, 0], labels[:, -1])  # heads are cut by the upper border often enough
    contact = max(np.count_nonzero(edge == row + 1) for edge in edges)
    away = min(core[0], labels.shape[1] - 1 - core[0], labels.shape[0] - 1 - core[1])
    return bool(contact > 0.7 * core[2] and away > 1.5 * core[2])
