"""Which region each part is in: the cheapest of all gated assignments; a region may be shared at a price."""

from itertools import product

import numpy as np

from vipr.systems.hands import kalman
from vipr.systems.hands.candidates import Candidate
from vipr.systems.hands.parts import HEAD, SIGMA_N, in_neck

GATE2 = 20.0  # squared Mahalanobis distance
# px and px/s at 160 x 120: no part moves farther in a frame
GATE = {
    "face": (10.0, 150.0),
    "left": (10.0, 350.0),
    "right": (10.0, 350.0),
}
COST_UNSEEN, COST_SHARED = 14.0, 7.0


def assign(tracks: dict, found: list[Candidate], labels: np.ndarray, dt: float, u: float) -> dict:
    """{part: index of its region or None} of least cost; a region may be shared at a price."""
    names, face = list(tracks), tracks.get("face")
    options = []
    for name in names:
        t, costs = tracks[name], {None: (COST_UNSEEN, True)}
        radius, gate = np.sqrt(t.area / np.pi), (GATE[name][0] + GATE[name][1] * dt + 60.0 * min(t.unseen, 0.5)) * u
        for i, r in enumerate(found):
            # A merged or slender region's centre is far from its part: the nearer of centre and box counts, at a price.
            d2 = kalman.distance2(t.filter, *r.centre, SIGMA_N * u)
            gap = _gap(r, labels, t.filter.x, t.filter.y, gate)
            gap = max(0.0, gap - 0.3 * radius)
            deep = gap < 2.5 * u
            inside2 = gap**2 / (t.filter.pp + (SIGMA_N * u) ** 2) + 3.0
            centre_gap = np.hypot(r.centre[0] - t.filter.x, r.centre[1] - t.filter.y)
            size = np.log(max(r.area, 1.0) / max(t.area, 1.0))
            look = 8.0 * max(0.0, (t.headlike - r.headlike if name == "face" else r.headlike - t.headlike) - 0.2)
            cost = min(
                d2 + 1.5 * abs(size) + look, inside2 + 1.5 * max(0.0, -size) + look * (1.0 if name == "face" else 0.3)
            )
            cost += 3.0 * max(0.0, 0.5 - r.person)
            if name != "face":
                cost += 2.5 * max(0.0, 0.5 * t.life - r.moving)
                if (r.core[2] < 1.35 * u or r.area < 0.3 * t.area) and not r.remnant:
                    continue  # a thin line is no hand, nor a speck
                if r.remnant and face is not None and in_neck(r, face, 0.15):
                    continue
            if min(d2, inside2) < GATE2 and min(gap, centre_gap) < gate and cost < COST_UNSEEN + 4.0:
                costs[i] = cost, deep
        options.append(sorted(costs.items(), key=lambda kv: kv[1][0])[:4])
    best, chosen = np.inf, ()
    for combination in product(*options):
        taken = [i for i, _ in combination if i is not None]
        shared = {i for i in taken if taken.count(i) > 1}
        if any(i in shared and not deep for i, (_, deep) in combination):
            continue  # only a part that lies in a region can share it
        cost = sum(c for _, (c, _) in combination) + COST_SHARED * (len(taken) - len(set(taken)))
        if face is not None:  # a hand does not move onto what looks like a face
            cost += 10.0 * sum(
                i not in (None, combination[names.index("face")][0]) and found[i].headlike > HEAD + 0.07
                for name, (i, _) in zip(names, combination, strict=True)
                if not (tracks[name].shared and not face.shared)
            )
        for i in shared:
            together = sum(tracks[name].area for name, (j, _) in zip(names, combination, strict=True) if j == i)
            cost += 4.0 * max(0.0, np.log(together / max(found[i].area, 1.0)) - 0.3)
        if cost < best:
            best, chosen = cost, tuple(i for i, _ in combination)
    return dict(zip(names, chosen, strict=True))


def _gap(r: Candidate, labels: np.ndarray, x: float, y: float, most: float) -> float:
    """Distance [px] of a point from a region, 0 inside; that from its box where it is more than ``most``."""
    dx = max(r.box[0] - x, 0.0, x - r.box[0] - r.box[2])
    dy = max(r.box[1] - y, 0.0, y - r.box[1] - r.box[3])
    gap = float(np.hypot(dx, dy))
    if gap > most or labels[int(y + 0.5), int(x + 0.5)] == r.row + 1:
        return gap
    x0, y0, w, h = r.box.astype(int)
    rows, columns = np.nonzero(labels[y0 : y0 + h + 1, x0 : x0 + w + 1] == r.row + 1)
    return float(np.sqrt(((columns + x0 - x) ** 2 + (rows + y0 - y) ** 2).min())) if len(rows) else gap
