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
    s = regions.scale
    held = {int(regions.labels[int(t.filter.y + 0.5), int(t.filter.x + 0.5)]) - 1 for t in tracks.values()}
    rows = [i for i in range(len(regions.areas)) if regions.person[i] > 0.25 or i in held]
    evidence = np.clip(2.0 * (regions.person - 0.25), 0.0, 1.0)
    large = regions.areas > 0.05 * max((regions.areas[i] for i in rows), default=0.0)
    largest = max((regions.areas[i] for i in rows if evidence[i] > 0.3), default=1.0)
    found = []
    for i in rows:
        others = [j for j in rows if j != i and large[j]]
        below = sum(evidence[j] for j in others if regions.centres[j, 1] > regions.centres[i, 1])
        topmost = (0.15 + below) / (0.3 + sum(evidence[j] for j in others))
        core = np.array([*((regions.cores[i, :2] + 0.5) / s - 0.5), regions.cores[i, 2] / s])
        area = regions.areas[i] / s**2
        spill = area / (np.pi * max(core[2], 1.0) ** 2)  # 1 for a disc, about 1.4 for a head, 2.5 for an open hand
        head = (
            0.75 * regions.faceness[i] + 0.1 * np.clip((3.2 - spill) / 1.5, 0, 1) + 0.15 * topmost
            + 0.1 * min(1.0, regions.areas[i] / largest)
        )  # fmt: skip
        head -= 0.3 * _enters(regions.labels, i, core)
        centre = (regions.centres[i] + 0.5) / s - 0.5
        moving = float(regions.moving[i])
        found.append(
            Candidate(i, centre, area, regions.boxes[i] / s, core, regions.person[i], float(head), moving=moving)
        )
    return found


def _enters(labels: np.ndarray, row: int, core: np.ndarray) -> bool:
    """Whether a region comes in over the border of the image as wide as an arm is for its hand; a head does not."""
    edges = (labels[-1], labels[:, 0], labels[:, -1])  # heads are cut by the upper border often enough
    contact = max(np.count_nonzero(edge == row + 1) for edge in edges)
    away = min(core[0], labels.shape[1] - 1 - core[0], labels.shape[0] - 1 - core[1])
    return bool(contact > 0.7 * core[2] and away > 1.5 * core[2])
