"""Parts in one region: its pixels are divided between them, so that each keeps its identity until they part."""

from dataclasses import replace

import numpy as np

from vipr.systems.hands import kalman
from vipr.systems.hands.arms import Body, far_end
from vipr.systems.hands.blobs import pixels_of, split
from vipr.systems.hands.candidates import Candidate
from vipr.systems.hands.parts import HEAD, SIGMA_N, Track

STILL = 0.05  # share of the pixels of a face's region that move, below which a hand in it may as well be the neck
COVERED = 30.0  # times the noise of a centre, of a face that shares its region, at 25 frames a second (less at fewer)


def measure_shared(
    name: str, t: Track, sharers: list, tracks: dict, body: Body | None, r: Candidate, labels, dt: float, u: float
) -> Track:
    """A part that shares its region: the region's pixels are divided among the sharers by where each is expected.

    Of crossed bare arms, the hand is the end of the region that is too far from its shoulder (of ``body``) to be an elbow.
    """
    p = pixels_of(labels, r.row)
    centres = np.array([[tracks[s].filter.x, tracks[s].filter.y] for s in sharers])
    radii = np.array([np.sqrt(max(tracks[s].area, 4.0) / np.pi) for s in sharers])
    shared, count = split(p, centres, radii)
    k = sharers.index(name)
    if count[k] < 0.15 * t.area:
        return replace(t, unseen=t.unseen + dt, shared=False)
    apart = min(np.hypot(*(centres[k] - centres[j])) / (radii[k] + radii[j]) for j in range(len(sharers)) if j != k)
    # Where parts overlap, motion says more than pixels; and a head hardly moves while a hand is before it.
    noise = COVERED * min(1.0, 0.04 / dt) if name == "face" else 2.0 + 6.0 * max(0.0, 1.0 - apart)
    if name != "face" and body is not None and "face" not in sharers and not r.remnant:
        tip = far_end(p, t.position, body)
        if tip is not None:
            shared[k], noise = tip, 3.0
    f = kalman.update(t.filter, *shared[k], SIGMA_N * u * noise)
    sizes = [tracks[s].area for s in sharers]
    crowded = r.area < sum(sizes) - 0.65 * min(sizes) or ("face" in sharers and r.moving < STILL and r.headlike > HEAD)
    met = t.met or len({"left", "right"} & set(sharers)) == 2
    return replace(t, filter=f, unseen=0.0, elbow=None, hits=t.hits + 1, shared=True, met=met,
                   crowded=t.crowded + dt if crowded else 0.0)  # fmt: skip
