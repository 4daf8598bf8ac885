"""Tracks of a face and two hands through the regions of skin: assignment, merging, birth and loss. Pure.

Each part (face, left, right) has one Kalman track. At a frame, the tracks are predicted and given to regions by the cheapest of all
gated assignments; regions may be shared (merged), and then their pixels are divided between the parts, so that each keeps its identity
until they part. What no track explains can become a missing part, by side. Positions inside are pixels of the region labels.
"""

from dataclasses import dataclass, replace
from itertools import permutations, product

import cv2
import numpy as np

from vipr.systems.hands import kalman
from vipr.systems.hands.blobs import SHOULDER, Body, hand_end, head_in, pixels_of, split
from vipr.systems.hands.kalman import Kalman
from vipr.systems.signals import HandTracks, SkinRegions

PARTS = ("face", "left", "right")
# Lengths in px at a working size of 160 x 120 (they grow with the size), times in s.
SIGMA_N = 0.8  # noise of a region's centre
SIGMA_W = {"face": 500.0, "left": 2600.0, "right": 2600.0}  # acceleration noise, px/s^2
SIGMA_V = {"face": 20.0, "left": 60.0, "right": 60.0}  # velocity of a new track, px/s
GATE2 = 20.0  # squared Mahalanobis distance
GATE = {
    "face": (10.0, 150.0),
    "left": (10.0, 350.0),
    "right": (10.0, 350.0),
}  # px and px/s: no part moves farther in a frame
COST_UNSEEN, COST_SHARED = 14.0, 7.0
LIFE = 2.0  # s, in which the memory of having moved halves
MIND_SIDES = 0.6  # s on the wrong sides, beyond those on the right ones, after which hands exchange names
LOST_AFTER = 0.7  # s unseen, after which a part may come back anywhere
HEAD = 0.48  # headlike from which a region can become the face
CONFIRM = 2  # frames after which a new track is reported


@dataclass(frozen=True)
class Track:
    """One part."""

    filter: Kalman
    area: float  # px^2, smoothed
    unseen: float = 0.0  # s since it was seen
    hits: int = 1
    headlike: float = 0.0  # smoothed
    life: float = 0.0  # 0 to 1: how much it moved in the last seconds
    shared: bool = False
    met: bool = False  # has it shared a region with the other hand
    crowded: float = 0.0  # s for which it has shared a region that is too small for all


@dataclass(frozen=True, eq=False)
class TracksBelief:
    """The three tracks; a part never seen is absent."""

    parts: tuple[tuple[str, Track], ...] = ()
    rival: float = 0.0  # s for which some hand looked more like a face than the face did
    order: float = 0.0  # s for which the hands were on their own sides, less those on the other's
    faceless: float = 0.0  # s without a face
    output: HandTracks = HandTracks()

    def only_face(self) -> "TracksBelief":
        """The same, but no hand is known."""
        return replace(self, parts=tuple((name, t) for name, t in self.parts if name == "face"))

    def __copy__(self):
        return self

    def __deepcopy__(self, memo):
        return self


@dataclass(frozen=True, eq=False)
class _Region:
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


def follow(regions: SkinRegions, belief: TracksBelief) -> TracksBelief:
    """The belief after the regions of one more frame."""
    shape = regions.labels.shape
    if 0 in shape:
        return belief
    if regions.cut:
        belief = TracksBelief()
    u = float(np.sqrt(shape[0] * shape[1] / 19200.0))
    dt = float(np.clip(regions.time - belief.output.time, 1e-3, 0.5)) if belief.output.number >= 0 else 0.04
    tracks = {
        name: replace(t, filter=_within(kalman.predict(t.filter, dt, SIGMA_W[name] * u, _damping(t, dt)), shape))
        for name, t in belief.parts
    }
    found = _candidates(regions, tracks)
    face = tracks.get("face")
    if face is not None:  # nor is a speck a hand
        tracks = {name: t for name, t in tracks.items() if t.area > (0.14 if t.life < 0.15 else 0.07) * face.area}
    labels, found = _cut_out_head(face, found, regions, u)
    choice = _assign(tracks, found, labels, dt, u)
    tracks = _measure(tracks, choice, found, labels, regions.motion, dt, u)
    free = [r for i, r in enumerate(found) if i not in choice.values()]
    tracks = _look_for_better_face(
        tracks, found[choice["face"]] if choice.get("face") is not None else None, free, labels, u
    )
    tracks = _give_birth(tracks, free, labels, regions.motion, belief.faceless, u)
    faceless = 0.0 if "face" in tracks and tracks["face"].unseen == 0 else belief.faceless + min(dt, 0.06)
    tracks, rival = _settle_face(tracks, belief.rival, dt)
    tracks, order = _settle_sides(tracks, belief.order, dt, u)
    return TracksBelief(tuple(tracks.items()), rival, order, faceless, _report(tracks, regions))


def _damping(t: Track, dt: float) -> float:
    """1/s: a seen track keeps its velocity (eq. 6) as long as frames come fast; an unseen one soon stops."""
    return 25.0 if t.unseen > 0 else 8.0 if dt > 0.08 else 0.0


def _within(f: Kalman, shape) -> Kalman:
    """The state, stopped at the border of the image."""
    x, y = min(max(f.x, 0.0), shape[1] - 1.0), min(max(f.y, 0.0), shape[0] - 1.0)
    return f if (x, y) == (f.x, f.y) else replace(f, x=x, y=y, vx=0.0, vy=0.0)


def _candidates(regions: SkinRegions, tracks: dict) -> list[_Region]:
    """Regions that may be of the person, in pixels of the labels."""
    s = regions.scale
    held = {int(regions.labels[int(t.filter.y + 0.5), int(t.filter.x + 0.5)]) - 1 for t in tracks.values()}
    rows = [i for i in range(len(regions.areas)) if regions.person[i] > 0.25 or i in held]
    likely = [i for i in rows if regions.person[i] > 0.5 and regions.areas[i] > 0.05 * regions.areas[rows].max()]
    largest = max((regions.areas[i] for i in likely), default=1.0)
    found = []
    for i in rows:
        below = [regions.centres[j, 1] > regions.centres[i, 1] for j in likely if j != i]
        core = np.array([*((regions.cores[i, :2] + 0.5) / s - 0.5), regions.cores[i, 2] / s])
        area = regions.areas[i] / s**2
        spill = area / (np.pi * max(core[2], 1.0) ** 2)  # 1 for a disc, about 1.4 for a head, 2.5 for an open hand
        head = (
            0.75 * regions.faceness[i] + 0.1 * np.clip((3.2 - spill) / 1.5, 0, 1) + 0.15 * (np.mean(below) if below else 0.5)
            + 0.1 * min(1.0, regions.areas[i] / largest)
        )  # fmt: skip
        head -= 0.3 * _enters(regions.labels, i, core)
        centre = (regions.centres[i] + 0.5) / s - 0.5
        moving = float(regions.moving[i])
        found.append(
            _Region(i, centre, area, regions.boxes[i] / s, core, regions.person[i], float(head), moving=moving)
        )
    return found


def _enters(labels: np.ndarray, row: int, core: np.ndarray) -> bool:
    """Whether a region comes in over the border of the image as wide as an arm is for its hand; a head does not."""
    edges = (labels[-1], labels[:, 0], labels[:, -1])  # heads are cut by the upper border often enough
    contact = max(np.count_nonzero(edge == row + 1) for edge in edges)
    away = min(core[0], labels.shape[1] - 1 - core[0], labels.shape[0] - 1 - core[1])
    return bool(contact > 0.7 * core[2] and away > 1.5 * core[2])


def _cut_out_head(face: Track | None, found: list[_Region], regions: SkinRegions, u: float):
    """Labels and regions in which a region much larger than the head in it is divided into head and what is left of it."""
    if face is None or face.unseen > 0.2 or not found:
        return regions.labels, found
    f, radius = face.filter, np.sqrt(face.area / np.pi / 1.3)
    row = int(regions.labels[int(f.y + 0.5), int(f.x + 0.5)]) - 1
    whole = next((r for r in found if r.row == row), None)
    if whole is None or whole.area < 1.7 * face.area:
        return regions.labels, found
    y, x = np.nonzero(regions.labels == row + 1)
    away = ((x - f.x) / (1.25 * radius)) ** 2 + ((y - f.y) / (1.55 * radius)) ** 2 > 1.0
    neck = (np.abs(x - f.x) < radius) & (y > f.y) & (y < f.y + 3.2 * radius) & (regions.motion[y, x] < 60)
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
        if area < max(8.0 * u * u, 0.1 * face.area) or free >= 250:
            continue
        mask = pieces == k
        free += 1
        labels[mask] = free
        box = stats[k, :4].astype(float)
        core = np.array([*centres[k], 0.5 * min(box[2], box[3])])
        moving = float(np.mean(regions.motion[mask])) / 255.0
        found.append(_Region(free - 1, centres[k], area, box, core, whole.person, 0.1, remnant=True, moving=moving))
    return labels, found


def _gap(r: _Region, labels: np.ndarray, x: float, y: float, most: float) -> float:
    """Distance [px] of a point from a region, 0 inside; that from its box where it is more than ``most``."""
    dx = max(r.box[0] - x, 0.0, x - r.box[0] - r.box[2])
    dy = max(r.box[1] - y, 0.0, y - r.box[1] - r.box[3])
    gap = float(np.hypot(dx, dy))
    if gap > most or labels[int(y + 0.5), int(x + 0.5)] == r.row + 1:
        return gap
    x0, y0, w, h = r.box.astype(int)
    rows, columns = np.nonzero(labels[y0 : y0 + h + 1, x0 : x0 + w + 1] == r.row + 1)
    return float(np.sqrt(((columns + x0 - x) ** 2 + (rows + y0 - y) ** 2).min())) if len(rows) else gap


def _assign(tracks: dict, found: list[_Region], labels: np.ndarray, dt: float, u: float) -> dict:
    """{part: index of its region or None} of least cost; a region may be shared at a price."""
    names = list(tracks)
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
        face_on = dict(zip(names, (i for i, _ in combination), strict=True)).get("face")
        cost += sum(
            10.0 for name, (i, _) in zip(names, combination, strict=True)
            if name != "face" and i is not None and i != face_on and found[i].headlike > HEAD + 0.07 and "face" in tracks
        )  # fmt: skip
        for i in shared:
            together = sum(tracks[name].area for name, (j, _) in zip(names, combination, strict=True) if j == i)
            cost += 4.0 * max(0.0, np.log(together / max(found[i].area, 1.0)) - 0.3)
        if cost < best:
            best, chosen = cost, tuple(i for i, _ in combination)
    return dict(zip(names, chosen, strict=True))


def _measure(tracks: dict, choice: dict, found: list[_Region], labels, motion, dt: float, u: float) -> dict:
    """The tracks after their regions' measurements."""
    out = {}
    for name, t in tracks.items():
        i = choice.get(name)
        if i is None:
            out[name] = replace(t, unseen=t.unseen + dt, shared=False)
            continue
        r = found[i]
        sharers = [other for other in tracks if choice.get(other) == i]
        if len(sharers) > 1:
            out[name] = _measure_shared(name, t, sharers, tracks, r, labels, dt, u)
            continue
        expected = np.array([t.filter.x, t.filter.y])
        if name == "face":
            centre, area = _head_in(r, labels, expected, np.sqrt(t.area / np.pi / 1.3))
        else:
            centre, area = _hand_in(r, labels, motion, expected, _body(tracks, name))
        far = np.hypot(*(centre - expected)) > (GATE[name][0] + GATE[name][1] * dt) * u
        f = _anew(name, centre, u) if far else kalman.update(t.filter, *centre, SIGMA_N * u)
        rate = 0.15
        slow = 1.0 if r.area > 1.7 * area else 0.25  # s
        look = t.headlike if r.remnant or r.cut else t.headlike + (1 - np.exp(-dt / slow)) * (r.headlike - t.headlike)
        out[name] = Track(
            f, t.area + rate * (area - t.area), 0.0, t.hits + 1, look, max(r.moving, t.life * 0.5 ** (dt / LIFE)), met=t.met
        )  # fmt: skip
    return out


def _head_in(r: _Region, labels: np.ndarray, expected, radius: float | None):
    """Centre and area of the head in a region: all of it, or the ellipse about its core or about where it is expected."""
    if r.area < 1.75 * np.pi * r.core[2] ** 2 and (radius is None or r.area < 1.6 * 1.3 * np.pi * radius**2):
        return r.centre, r.area
    near_core = expected is None or np.hypot(*(r.core[:2] - expected)) < max(r.core[2], radius)
    start = r.core[:2] if near_core else expected
    size = r.core[2] if radius is None else (0.5 * (radius + min(r.core[2], 1.5 * radius)) if near_core else radius)
    centre, count = head_in(pixels_of(labels, r.row), start, size)
    return (centre, count) if count else (r.centre, r.area)


def _hand_in(r: _Region, labels: np.ndarray, motion: np.ndarray, expected, body: Body | None):
    """Centre and area of the hand in a region: all of it, or the end of a bare arm."""
    p = pixels_of(labels, r.row)
    if len(p) < 12:
        return r.centre, r.area
    centre, count = hand_end(p, expected, body, motion)
    return (r.centre, r.area) if count >= len(p) else (centre, r.area * count / len(p))


def _measure_shared(name: str, t: Track, sharers: list, tracks: dict, r: _Region, labels, dt: float, u: float) -> Track:
    """A part that shares its region: the region's pixels are divided among the sharers by where each is expected."""
    p = pixels_of(labels, r.row)
    centres = np.array([[tracks[s].filter.x, tracks[s].filter.y] for s in sharers])
    radii = np.array([np.sqrt(max(tracks[s].area, 4.0) / np.pi) for s in sharers])
    shared, count = split(p, centres, radii)
    k = sharers.index(name)
    if count[k] < 0.15 * t.area:
        return replace(t, unseen=t.unseen + dt, shared=False)
    apart = min(np.hypot(*(centres[k] - centres[j])) / (radii[k] + radii[j]) for j in range(len(sharers)) if j != k)
    noise = (
        4.0 if name == "face" else 2.0 + 6.0 * max(0.0, 1.0 - apart)
    )  # where they overlap, motion says more than pixels
    f = kalman.update(t.filter, *shared[k], SIGMA_N * u * noise)
    sizes = [tracks[s].area for s in sharers]
    crowded = r.area < sum(sizes) - 0.65 * min(sizes)
    return replace(t, filter=f, unseen=0.0, hits=t.hits + 1, shared=True, met=t.met or len({"left", "right"} & set(sharers)) == 2,
                   crowded=t.crowded + dt if crowded else 0.0)  # fmt: skip


def _body(tracks: dict, name: str) -> Body | None:
    """What the face says of the arm of a hand; None without a face."""
    face = tracks.get("face")
    if face is None or face.unseen > LOST_AFTER:
        return None
    head = 2.6 * np.sqrt(face.area / np.pi / 1.3)
    side = 1.0 if name == "left" else -1.0
    return Body(
        np.array([face.filter.x + side * SHOULDER[0] * head, face.filter.y + SHOULDER[1] * head]), head, face.area
    )


def _missing(tracks: dict, name: str) -> bool:
    return name not in tracks or tracks[name].unseen > 0 or tracks[name].crowded > 0.12


def _give_birth(
    tracks: dict, free: list[_Region], labels: np.ndarray, motion: np.ndarray, faceless: float, u: float
) -> dict:
    """Give regions that nobody claimed to parts that are missing; ``faceless`` s have passed without a face."""
    tracks = dict(tracks)
    free = [r for r in free if r.area > 8.0 * u * u and r.core[2] > 1.35 * u]
    if _missing(tracks, "face") and ("face" not in tracks or tracks["face"].unseen > 0.2):
        k = _likeliest_head(free, faceless)
        if k is not None:
            r = free.pop(k)
            tracks["face"] = _born("face", *_head_in(r, labels, None, None), r, u)
    free = _possible_hands(free, tracks.get("face"))
    tracks = _give_up_still_hands(tracks, free, tracks.get("face"))
    missing = [name for name in ("left", "right") if _missing(tracks, name)]
    for name, r in _cheapest_hands(missing, free[:3], tracks, labels.shape[1], u):
        centre, area = _hand_in(r, labels, motion, None, _body(tracks, name))
        tracks[name] = _born(name, centre, area, r, u)
    return tracks


def _likeliest_head(free: list[_Region], faceless: float) -> int | None:
    """Index of the region that may become the face; the longer there is none, the less it takes, if it is above other regions."""
    found = [k for k, r in enumerate(free) if r.person > 0.28]
    if not found:
        return None
    k = max(found, key=lambda k: free[k].headlike)
    r = free[k]
    others = [free[j] for j in found if j != k and free[j].person > 0.5]
    topmost = len(others) >= 1 and all(r.core[1] < other.centre[1] for other in others)
    enough = HEAD - (0.16 * min(faceless / 0.4, 1.0) if topmost else 0.0)
    return k if r.headlike > enough and (r.person > 0.5 or topmost) else None


def _possible_hands(free: list[_Region], face: Track | None) -> list[_Region]:
    """Regions that can be a hand or an arm, the most evident first."""
    if face is None:
        hands = [r for r in free if r.person > 0.5]
    else:  # a hand is not many times the size of the face, nor a speck beside it, nor out of reach, nor the neck
        radius = np.sqrt(face.area / np.pi / 1.3)

        def possible(r):
            dx, dy = (r.centre[0] - face.filter.x) / radius, (r.centre[1] - face.filter.y) / radius
            neck = abs(dx) < 1.0 and 0.0 < dy < 3.6 and r.moving < 0.3
            still = r.person <= 0.5
            if neck or r.headlike > HEAD + 0.07 or (r.remnant and r.moving < 0.3) or (still and r.person < 0.28):
                return False
            size = 0.15 * face.area < r.area < (3.0 if still else 6.0) * face.area
            return size and np.hypot(dx, dy) < 12.0 and (not still or _hangs(r, face))

        hands = [r for r in free if possible(r)]
    return sorted(hands, key=lambda r: -r.person * np.sqrt(r.area))


def _cheapest_hands(missing: list, free: list[_Region], tracks: dict, width: int, u: float) -> list:
    """(part, region) for missing hands: each as near as it can be to where it was lost, or else to its own side of the face."""
    face = tracks.get("face")
    middle, head = (
        (0.5 * width, 0.2 * width) if face is None else (face.filter.x, 2.6 * np.sqrt(face.area / np.pi / 1.3))
    )

    def price(name, r):
        t = tracks.get(name)
        if t is not None and 0 < t.unseen < LOST_AFTER:
            return 0.6 * np.hypot(r.centre[0] - t.filter.x, r.centre[1] - t.filter.y) / ((12.0 + 160.0 * t.unseen) * u)
        side = (r.centre[0] - middle) / head * (1.0 if name == "left" else -1.0)
        return 0.1 + 0.6 * min(max(0.0, -side), 2.0)

    best, chosen = np.inf, []
    for regions in permutations([*free, *[None] * len(missing)], len(missing)):
        pairs = [(name, r) for name, r in zip(missing, regions, strict=True) if r is not None]
        prices = [price(name, r) for name, r in pairs]
        if any(p > 0.65 for p in prices):
            continue
        total = sum(prices) + 0.7 * (len(missing) - len(pairs)) + sum(0.05 * free.index(r) for _, r in pairs)
        if total < best:
            best, chosen = total, pairs
    return chosen


def _look_for_better_face(tracks: dict, now: _Region | None, free: list[_Region], labels: np.ndarray, u: float) -> dict:
    """The face moved at once to a region near by that looks far more like one than where the track has ended."""
    face = tracks.get("face")
    if face is None or now is None or now.cut or face.shared:
        return tracks
    reach = 6.0 * np.sqrt(face.area / np.pi)
    near = [r for r in free if np.hypot(r.centre[0] - face.filter.x, r.centre[1] - face.filter.y) < reach]
    best = max(near, key=lambda r: r.headlike, default=None)
    if best is None or best.headlike < max(HEAD + 0.05, now.headlike + 0.2):
        return tracks
    free.remove(best)
    return {**tracks, "face": replace(_born("face", *_head_in(best, labels, None, None), best, u), hits=face.hits)}


def _hangs(r: _Region, face: Track) -> bool:
    """Whether a still region is where a hanging arm or resting hand would be."""
    head = 2.6 * np.sqrt(face.area / np.pi / 1.3)
    across, down = abs(r.centre[0] - face.filter.x) / head, (r.centre[1] - face.filter.y) / head
    return bool(0.4 < across < 2.0 and 1.5 < down < 4.5)


def _give_up_still_hands(tracks: dict, free: list[_Region], face: Track | None) -> dict:
    """Without the tracks of things that hardly move, as far as larger regions that do move belong to nobody."""
    size = 0.2 * face.area if face is not None else 0.0
    waiting = sorted((r.moving * np.sqrt(r.area) for r in free if r.moving > 0.3 and r.area > size), reverse=True)
    waiting = waiting[sum(_missing(tracks, n) for n in ("left", "right")) :]
    held = {
        n: (t.life + 0.1) * np.sqrt(t.area) for n, t in tracks.items() if n != "face" and t.unseen == 0 and not t.shared
    }
    tracks = dict(tracks)
    for claim, name in zip(waiting, sorted(held, key=held.get), strict=False):
        if claim > 2.0 * held[name]:
            del tracks[name]
    return tracks


def _anew(name: str, centre, u: float) -> Kalman:
    """A filter that starts at a place, with no velocity."""
    return kalman.start(*(float(c) for c in centre), SIGMA_N * u, SIGMA_V[name] * u)


def _born(name: str, centre, area: float, r: _Region, u: float) -> Track:
    return Track(
        _anew(name, centre, u),
        max(area, 1.0),
        headlike=r.headlike,
        life=r.moving,
    )


def _settle_face(tracks: dict, rival: float, dt: float) -> tuple[dict, float]:
    """Exchange face and a hand that has looked more like a face for a while."""
    face = tracks.get("face")
    hands = {n: t for n, t in tracks.items() if n != "face" and t.unseen == 0 and not t.shared}
    if not hands or (face is not None and face.shared):
        return tracks, max(0.0, rival - dt)
    name = max(hands, key=lambda n: hands[n].headlike)
    better = hands[name].headlike > (HEAD if face is None else face.headlike + 0.12)
    step = min(dt, 0.06)
    rival = rival + step if better else max(0.0, rival - 2 * step)
    if rival < 0.3:
        return tracks, rival
    tracks = dict(tracks)
    promoted = tracks.pop(name)
    if face is not None and face.unseen == 0:
        tracks[name] = face
    tracks["face"] = promoted
    return tracks, 0.0


def _settle_sides(tracks: dict, order: float, dt: float, u: float) -> tuple[dict, float]:
    """Exchange the names of hands that have been on the wrong sides for longer than on their own; a new hand has no history."""
    hands = {n: tracks[n] for n in ("left", "right") if n in tracks and tracks[n].unseen == 0 and not tracks[n].shared}
    if any(t.hits <= 1 for t in hands.values()):
        order = min(order, 0.0)
    face = tracks.get("face")
    if len(hands) == 2:
        apart = (hands["left"].filter.x - hands["right"].filter.x) / u
    elif len(hands) == 1 and face is not None and face.unseen == 0:
        (name, t), width = next(iter(hands.items())), 2 * np.sqrt(face.area / np.pi)
        apart = (t.filter.x - face.filter.x) * (0.6 if name == "left" else -0.6) / u
        apart = np.sign(apart) * max(0.0, abs(apart) - 0.6 * width / u)
    else:
        return tracks, order
    patience = MIND_SIDES * (4.0 if any(t.met for t in hands.values()) else 1.0)
    order = float(np.clip(order + dt * np.clip(apart / 10.0, -1.0, 1.0), -patience, 6.0))
    if order > -patience:
        return tracks, order
    exchange = {"left": "right", "right": "left"}
    return {exchange.get(name, name): t for name, t in tracks.items()}, 0.0


def _report(tracks: dict, regions: SkinRegions) -> HandTracks:
    s = regions.scale
    values = {"size": regions.size, "time": regions.time, "number": regions.number}
    areas = np.zeros(3)
    for k, name in enumerate(PARTS):
        t = tracks.get(name)
        if t is None or (t.hits < CONFIRM and not regions.cut):
            continue
        values[name] = (np.array([t.filter.x, t.filter.y]) + 0.5) * s - 0.5
        values[f"{name}_velocity"] = np.array([t.filter.vx, t.filter.vy]) * s
        values[f"{name}_seen"] = t.unseen == 0
        areas[k] = t.area * s**2 if t.unseen == 0 else 0.0
    merged = tuple(n for n in PARTS if n in tracks and tracks[n].shared and tracks[n].unseen == 0)
    return HandTracks(**values, areas=areas, merged=merged)
