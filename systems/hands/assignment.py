"""Which region each part is in: the cheapest of all gated assignments; a region may be shared at a price."""

import math
from itertools import product

import numpy as np

from vipr.systems.compiled import compiled
from vipr.systems.hands import kalman
from vipr.systems.hands.arms import astray
from vipr.systems.hands.blobs import pixels_of
from vipr.systems.hands.candidates import Candidate
from vipr.systems.hands.parts import BARE, HEAD, SIGMA_N, Track, body_of, hand_before_face, in_neck

GATE2 = 20.0  # squared Mahalanobis distance
# px and px/s at 160 x 120: no part moves farther in a frame
GATE = {
    "face": (10.0, 150.0),
    "left": (10.0, 350.0),
    "right": (10.0, 350.0),
}
COASTS = 0.3  # s unseen, for which a hand's own track looks for its region
COST_UNSEEN, COST_SHARED = 14.0, 7.0
COST_ELBOW = 8.0  # by which the elbow of a bare arm is a height of the head farther from where it can be than if it were the other arm


def assign(tracks: dict, found: list[Candidate], labels: np.ndarray, dt: float, u: float) -> dict:
    """{part: index of its region or None} of least cost; a region may be shared at a price."""
    names, face = list(tracks), tracks.get("face")
    arm = any(r.arm is not None for r in found)
    elbows = _elbows(tracks, found, labels)
    options = []
    for name, t in tracks.items():
        prices = (
            (i, _price(name, t, r, face, labels, dt, u, elbows.get((name, i), 0.0)))
            for i, r in enumerate(found)
            if not (arm and r.cut and name != "face")
        )
        near = sorted(((cost, i, deep) for i, (cost, deep) in prices if cost < COST_UNSEEN + 4.0))
        options.append(sorted([(COST_UNSEEN, None, True), *near], key=lambda option: option[0])[:4])
    best, chosen = math.inf, ()
    for combination in product(*options):
        cost = sum(option[0] for option in combination)
        if cost >= best:
            continue
        regions = [i for _, i, _ in combination]
        cost += _together(regions, [deep for *_, deep in combination], names, tracks, found)
        if face is not None and cost < best:
            cost += _on_faces(regions, names, tracks, found)
        if cost < best:
            best, chosen = cost, regions
    return dict(zip(names, chosen, strict=True))


def _price(
    name: str, t: Track, r: Candidate, face: Track | None, labels: np.ndarray, dt: float, u: float, elbow: float
) -> tuple[float, bool]:
    """What it costs that a part is in a region, infinite where it cannot be; and whether it lies deep in it and was there
    just now, so that it may share it.

    A merged or slender region's centre is far from its part: the nearer of centre and outline counts, at a price.
    """
    if name == "face" and r.arm is not None:
        return math.inf, False
    if name != "face":
        if t.unseen > COASTS:
            return math.inf, False  # it comes back by where it was and by its side of the face (births)
        if (r.core[2] < 1.35 * u or r.area < 0.3 * t.area) and not r.remnant:
            return math.inf, False  # a thin line is no hand, nor a speck
        if r.remnant and face is not None and in_neck(r, face, 0.15):
            return math.inf, False
    x, y = t.filter.x, t.filter.y
    gate = (GATE[name][0] + GATE[name][1] * dt + 60.0 * min(t.unseen, 0.5)) * u
    gap = max(0.0, _gap(r, labels, x, y, gate) - 0.3 * math.sqrt(t.area / math.pi))
    hidden = None if face is None else hand_before_face(r, face.head_height)
    middle = (r.centre if hidden is None else hidden).tolist()
    centre = kalman.distance2(t.filter, *middle, SIGMA_N * u)
    inside = gap**2 / (t.filter.pp + (SIGMA_N * u) ** 2) + 3.0
    if min(centre, inside) >= GATE2 or min(gap, math.hypot(middle[0] - x, middle[1] - y)) >= gate:
        return math.inf, False
    size = math.log(max(r.area, 1.0) / max(t.area, 1.0))
    look = 8.0 * max(0.0, (t.headlike - r.headlike if name == "face" else r.headlike - t.headlike) - 0.2)
    cost = min(
        centre + 1.5 * abs(size) + look, inside + 1.5 * max(0.0, -size) + look * (1.0 if name == "face" else 0.3)
    )
    cost += 3.0 * max(0.0, 0.5 - r.person)
    if name != "face":
        cost += 2.5 * max(0.0, 0.5 * t.life - r.moving) + COST_ELBOW * elbow
    return float(cost), gap < 2.5 * u and t.unseen < 0.1


def _elbows(tracks: dict, found: list[Candidate], labels: np.ndarray) -> dict:
    """{(hand, index of a region): by how much its elbow would be more astray than the other hand's, 0 to 1} of regions that are
    bare arms, once arms have been seen bare."""
    bodies = {name: body_of(tracks, name) for name in ("left", "right") if name in tracks}
    if len(bodies) < 2 or None in bodies.values() or not any(t.bare > BARE for t in tracks.values()):
        return {}
    more = {}
    for i, r in enumerate(found):
        if r.cut or r.remnant or r.area < 8.0 * r.core[2]:
            continue
        difference = astray(pixels_of(labels, r.row), bodies["left"], bodies["right"])
        more |= {("left", i): max(difference, 0.0), ("right", i): max(-difference, 0.0)}
    return more


def _together(regions: list, deep: list[bool], names: list[str], tracks: dict, found: list[Candidate]) -> float:
    """The price of sharing regions: only parts that lie in a region can, and better in one that is large enough for all."""
    cost = 0.0
    for i in {i for i in regions if i is not None and regions.count(i) > 1}:
        sharers = [k for k, j in enumerate(regions) if j == i]
        if not all(deep[k] for k in sharers):
            return math.inf
        area = sum(tracks[names[k]].area for k in sharers)
        cost += COST_SHARED * (len(sharers) - 1) + 4.0 * max(0.0, math.log(area / max(found[i].area, 1.0)) - 0.3)
    return cost


def _on_faces(regions: list, names: list[str], tracks: dict, found: list[Candidate]) -> float:
    """The price of hands on what looks like a face but is not the face's region; hands that already share it may."""
    own, face = regions[names.index("face")], tracks["face"]
    return 10.0 * sum(
        i is not None and i != own and found[i].headlike > HEAD + 0.07 and (face.shared or not tracks[name].shared)
        for name, i in zip(names, regions, strict=True)
    )


def _gap(r: Candidate, labels: np.ndarray, x: float, y: float, most: float) -> float:
    """Distance [px] of a point from a region, 0 inside; that from its box where it is more than ``most``."""
    x0, y0, w, h = r.box.tolist()
    gap = math.hypot(max(x0 - x, 0.0, x - x0 - w), max(y0 - y, 0.0, y - y0 - h))
    if gap > most or labels[int(y + 0.5), int(x + 0.5)] == r.row + 1:
        return gap
    away2 = _nearest2(labels[int(y0) : int(y0 + h) + 1, int(x0) : int(x0 + w) + 1], r.row + 1, x - int(x0), y - int(y0))
    return math.sqrt(away2) if away2 < math.inf else gap


@compiled
def _nearest2(labels, label, x, y):
    """Squared distance of the nearest pixel with a label from x, y; infinite if there is none."""
    nearest = np.inf
    for i in range(labels.shape[0]):
        for j in range(labels.shape[1]):
            if labels[i, j] == label:
                nearest = min(nearest, (j - x) ** 2 + (i - y) ** 2)
    return nearest
