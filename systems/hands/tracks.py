"""Tracks of a face and two hands through the regions of skin: assignment, merging, birth and loss. Pure.

Each part (face, left, right) has one Kalman track. At a frame, the tracks are predicted and given to regions by the cheapest of all
gated assignments; regions may be shared (merged), and then their pixels are divided between the parts, so that each keeps its identity
until they part. What no track explains can become a missing part, by side. Positions inside are pixels of the region labels.
"""

from dataclasses import dataclass, replace
from itertools import product

import numpy as np

from vipr.systems.hands import kalman
from vipr.systems.hands.blobs import hand_end, pixels_of, split
from vipr.systems.hands.kalman import Kalman
from vipr.systems.signals import HandTracks, SkinRegions

PARTS = ("face", "left", "right")
# Lengths in px at a working size of 160 x 120 (they grow with the size), times in s.
SIGMA_N = 0.8  # noise of a region's centre
SIGMA_W = {"face": 500.0, "left": 2600.0, "right": 2600.0}  # acceleration noise, px/s^2
SIGMA_V = {"face": 20.0, "left": 60.0, "right": 60.0}  # velocity of a new track, px/s
GATE2 = 20.0  # squared Mahalanobis distance
GATE = {"face": 22.0, "left": 30.0, "right": 30.0}  # px, in any case
COST_UNSEEN, COST_SHARED = 14.0, 7.0
LOST_AFTER = 0.7  # s unseen, after which a part may come back anywhere
DAMPING = 6.0  # 1/s, of the velocity of an unseen track
HEAD = 0.5  # headlike from which a region can become the face
CONFIRM = 2  # frames after which a new track is reported


@dataclass(frozen=True)
class Track:
    """One part."""

    filter: Kalman
    area: float  # px^2, smoothed
    unseen: float = 0.0  # s since it was seen
    hits: int = 1
    headlike: float = 0.0  # smoothed
    person: float = 0.5  # smoothed
    shared: bool = False


@dataclass(frozen=True, eq=False)
class TracksBelief:
    """The three tracks; a part never seen is absent."""

    parts: tuple[tuple[str, Track], ...] = ()
    rival: float = 0.0  # s for which some hand looked more like a face than the face did
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
    person: float
    headlike: float  # 0 to 1: marks of a face, shape of a head, size and height among the regions of this frame


def follow(regions: SkinRegions, belief: TracksBelief) -> TracksBelief:
    """The belief after the regions of one more frame."""
    shape = regions.labels.shape
    if 0 in shape:
        return belief
    u = float(np.sqrt(shape[0] * shape[1] / 19200.0))
    dt = float(np.clip(regions.time - belief.output.time, 1e-3, 0.5)) if belief.output.number >= 0 else 0.04
    found = _candidates(regions)
    tracks = {
        name: replace(t, filter=kalman.predict(t.filter, dt, SIGMA_W[name] * u, DAMPING if t.unseen > 0 else 0.0))
        for name, t in belief.parts
    }
    choice = _assign(tracks, found, u)
    tracks = _measure(tracks, choice, found, regions.labels, dt, u)
    free = [r for i, r in enumerate(found) if i not in choice.values()]
    tracks = _give_birth(tracks, free, regions.labels, u)
    tracks, rival = _settle_face(tracks, belief.rival, dt)
    return TracksBelief(tuple(tracks.items()), rival, _report(tracks, regions))


def _candidates(regions: SkinRegions) -> list[_Region]:
    """Regions that may be of the person, in pixels of the labels."""
    s = regions.scale
    rows = [i for i in range(len(regions.areas)) if regions.person[i] > 0.25]
    likely = [i for i in rows if regions.person[i] > 0.5 and regions.areas[i] > 0.05 * regions.areas[rows].max()]
    largest = max((regions.areas[i] for i in likely), default=1.0)
    found = []
    for i in rows:
        box, below = regions.boxes[i] / s, [regions.centres[j, 1] > regions.centres[i, 1] for j in likely if j != i]
        tall, filled = box[3] / max(box[2], 1.0), regions.areas[i] / s**2 / max(box[2] * box[3], 1.0)
        shape = np.clip((filled - 0.35) / 0.25, 0, 1) * (0.85 <= tall <= 2.2)
        head = (
            0.55 * regions.faceness[i] + 0.15 * shape + 0.2 * (np.mean(below) if below else 0.5)
            + 0.15 * min(1.0, regions.areas[i] / largest)
        )  # fmt: skip
        centre = (regions.centres[i] + 0.5) / s - 0.5
        found.append(_Region(i, centre, regions.areas[i] / s**2, box, regions.person[i], float(head)))
    return found


def _gap(box: np.ndarray, x: float, y: float) -> float:
    """Distance [px] of a point from a box, 0 inside."""
    dx = max(box[0] - x, 0.0, x - box[0] - box[2])
    dy = max(box[1] - y, 0.0, y - box[1] - box[3])
    return float(np.hypot(dx, dy))


def _assign(tracks: dict, found: list[_Region], u: float) -> dict:
    """{part: index of its region or None} of least cost; a region may be shared at a price."""
    names = list(tracks)
    options = []
    for name in names:
        t, costs = tracks[name], {None: COST_UNSEEN}
        radius = np.sqrt(t.area / np.pi)
        for i, r in enumerate(found):
            # A merged or slender region's centre is far from its part: the nearer of centre and box counts, at a price.
            d2 = kalman.distance2(t.filter, *r.centre, SIGMA_N * u)
            gap = max(0.0, _gap(r.box, t.filter.x, t.filter.y) - 0.3 * radius)
            inside2 = gap**2 / (t.filter.pp + (SIGMA_N * u) ** 2) + 3.0
            centre_gap = np.hypot(r.centre[0] - t.filter.x, r.centre[1] - t.filter.y)
            cost = min(d2, inside2) + 1.5 * abs(np.log(max(r.area, 1.0) / max(t.area, 1.0)))
            cost += 3.0 * max(0.0, 0.5 - r.person)
            cost += 5.0 * max(0.0, (t.headlike - r.headlike if name == "face" else r.headlike - t.headlike) - 0.2)
            if min(d2, inside2) < GATE2 and min(gap, centre_gap) < GATE[name] * u and cost < COST_UNSEEN + 4.0:
                costs[i] = cost
        options.append(sorted(costs.items(), key=lambda kv: kv[1])[:4])
    best, chosen = np.inf, ()
    for combination in product(*options):
        taken = [i for i, _ in combination if i is not None]
        cost = sum(c for _, c in combination) + COST_SHARED * (len(taken) - len(set(taken)))
        if cost < best:
            best, chosen = cost, tuple(i for i, _ in combination)
    return dict(zip(names, chosen, strict=True))


def _measure(tracks: dict, choice: dict, found: list[_Region], labels: np.ndarray, dt: float, u: float) -> dict:
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
            out[name] = _measure_shared(name, t, sharers, tracks, r, labels, u)
            continue
        centre, area = r.centre, r.area
        if name != "face":
            expected = np.array([t.filter.x, t.filter.y])
            centre, area = _hand_in(r, labels, expected, _shoulder(tracks, name))
        f = kalman.update(t.filter, *centre, SIGMA_N * u)
        rate = 0.15
        out[name] = Track(
            f, t.area + rate * (area - t.area), 0.0, t.hits + 1, t.headlike + rate * (r.headlike - t.headlike),
            t.person + rate * (r.person - t.person),
        )  # fmt: skip
    return out


def _hand_in(r: _Region, labels: np.ndarray, expected, root):
    """Centre and area of the hand in a region: all of it, or the end of a bare arm."""
    p = pixels_of(labels, r.row)
    if len(p) < 12:
        return r.centre, r.area
    centre, count = hand_end(p, expected, root, labels.shape)
    return (r.centre, r.area) if count >= len(p) else (centre, r.area * count / len(p))


def _measure_shared(
    name: str, t: Track, sharers: list, tracks: dict, r: _Region, labels: np.ndarray, u: float
) -> Track:
    """A part that shares its region: the region's pixels are divided among the sharers by where each is expected."""
    p = pixels_of(labels, r.row)
    centres = np.array([[tracks[s].filter.x, tracks[s].filter.y] for s in sharers])
    radii = np.array([np.sqrt(max(tracks[s].area, 4.0) / np.pi) for s in sharers])
    shared, count = split(p, centres, radii)
    k = sharers.index(name)
    noise = SIGMA_N * u * (4.0 if name == "face" else 2.0)
    f = kalman.update(t.filter, *shared[k], noise) if count[k] else t.filter
    return replace(t, filter=f, unseen=0.0, hits=t.hits + 1, shared=True)


def _shoulder(tracks: dict, name: str):
    """(2,) where the shoulder of a hand is, from the face; None without a face."""
    face = tracks.get("face")
    if face is None or face.unseen > LOST_AFTER:
        return None
    radius = np.sqrt(face.area / np.pi)
    side = 1.0 if name == "left" else -1.0
    return np.array([face.filter.x + side * 2.0 * radius, face.filter.y + 2.6 * radius])


def _missing(tracks: dict, name: str) -> bool:
    return name not in tracks or tracks[name].unseen > 0


def _give_birth(tracks: dict, free: list[_Region], labels: np.ndarray, u: float) -> dict:
    """Give regions that nobody claimed to parts that are missing."""
    tracks = dict(tracks)
    free = [r for r in free if r.person > 0.5 and r.area > 8.0 * u * u]
    if _missing(tracks, "face") and free:
        k = max(range(len(free)), key=lambda k: free[k].headlike)
        if free[k].headlike > HEAD and ("face" not in tracks or tracks["face"].unseen > 0.2):
            r = free.pop(k)
            tracks["face"] = _born("face", r.centre, r.area, r, u)
    face = tracks.get("face")
    if face is not None:  # a hand is not many times the size of the face, nor a speck beside it
        free = [r for r in free if 0.06 * face.area < r.area < 6.0 * face.area]
    free.sort(key=lambda r: -r.person * np.sqrt(r.area))
    middle = face.filter.x if face is not None else 0.5 * labels.shape[1]
    missing = [name for name in ("left", "right") if _missing(tracks, name)]
    for r in free[: len(missing)] if len(missing) < 2 else _by_side(free, missing, tracks, middle, u):
        if isinstance(r, tuple):
            name, r = r
        else:
            name = missing[0]
            if not _plausible(tracks, name, r, u):
                continue
        centre, area = _hand_in(r, labels, None, _shoulder(tracks, name))
        tracks[name] = _born(name, centre, area, r, u)
    return tracks


def _plausible(tracks: dict, name: str, r: _Region, u: float) -> bool:
    """Whether a hand unseen for a short while may be back at the region: only as far as it can have moved."""
    t = tracks.get(name)
    if t is None or t.unseen > LOST_AFTER:
        return True
    away = np.hypot(r.centre[0] - t.filter.x, r.centre[1] - t.filter.y)
    return bool(away < (12.0 + 160.0 * t.unseen) * u)


def _by_side(free: list[_Region], missing: list, tracks: dict, middle: float, u: float) -> list:
    """(part, region) when both hands are missing: two regions by their order, one by where a hand was lost or else by its side."""
    if not free:
        return []
    if len(free) >= 2:
        a, b = sorted(free[:2], key=lambda r: r.centre[0])
        return [("right", a), ("left", b)]
    r = free[0]
    recent = {n: tracks[n] for n in missing if n in tracks and tracks[n].unseen < LOST_AFTER}
    if recent:
        near = {n: np.hypot(r.centre[0] - t.filter.x, r.centre[1] - t.filter.y) for n, t in recent.items()}
        name = min(near, key=near.get)
        if near[name] < (12.0 + 160.0 * recent[name].unseen) * u:
            return [(name, r)]
    return [("left" if r.centre[0] > middle else "right", r)]


def _born(name: str, centre, area: float, r: _Region, u: float) -> Track:
    return Track(
        kalman.start(*(float(c) for c in centre), SIGMA_N * u, SIGMA_V[name] * u),
        max(area, 1.0),
        headlike=r.headlike,
        person=r.person,
    )


def _settle_face(tracks: dict, rival: float, dt: float) -> tuple[dict, float]:
    """Exchange face and a hand that has looked more like a face for a while."""
    face = tracks.get("face")
    hands = {n: t for n, t in tracks.items() if n != "face" and t.unseen == 0 and not t.shared}
    if not hands:
        return tracks, max(0.0, rival - dt)
    name = max(hands, key=lambda n: hands[n].headlike)
    better = hands[name].headlike > (HEAD if face is None else face.headlike + 0.12)
    rival = rival + dt if better else max(0.0, rival - 2 * dt)
    if rival < 0.3:
        return tracks, rival
    tracks = dict(tracks)
    promoted = tracks.pop(name)
    if face is not None and face.unseen == 0:
        tracks[name] = face
    tracks["face"] = promoted
    return tracks, 0.0


def _report(tracks: dict, regions: SkinRegions) -> HandTracks:
    s = regions.scale
    values = {"size": regions.size, "time": regions.time, "number": regions.number}
    areas = np.zeros(3)
    for k, name in enumerate(PARTS):
        t = tracks.get(name)
        if t is None or t.hits < CONFIRM:
            continue
        values[name] = (np.array([t.filter.x, t.filter.y]) + 0.5) * s - 0.5
        values[f"{name}_velocity"] = np.array([t.filter.vx, t.filter.vy]) * s
        values[f"{name}_seen"] = t.unseen == 0
        areas[k] = t.area * s**2 if t.unseen == 0 else 0.0
    merged = tuple(n for n in PARTS if n in tracks and tracks[n].shared and tracks[n].unseen == 0)
    return HandTracks(**values, areas=areas, merged=merged)
