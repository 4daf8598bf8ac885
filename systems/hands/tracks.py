"""Tracks of a face and two hands through the regions of skin. Pure.

Each part (face, left, right) has one Kalman track. At a frame, the tracks are predicted (``kalman``) and given to regions by the cheapest
of all gated assignments (``assignment``), after a head has been cut out of a region that holds more (``head_cut``). Regions may be shared:
their pixels are divided between the parts (``merging``), so that each keeps its identity until they part; of a bare arm the hand is
found (``measurement``). What no track explains can become a missing part, by side (``births``), and names that have been wrong for a
while are exchanged (``identities``). Positions inside are pixels of the region labels.
"""

from dataclasses import dataclass, replace

import numpy as np

from vipr.systems.hands import kalman
from vipr.systems.hands.assignment import assign
from vipr.systems.hands.births import give_birth, look_for_better_face
from vipr.systems.hands.candidates import candidates
from vipr.systems.hands.head_cut import cut_out_head
from vipr.systems.hands.identities import doubt_face, settle_face, settle_sides
from vipr.systems.hands.kalman import Kalman
from vipr.systems.hands.measurement import measure
from vipr.systems.hands.parts import BARE, LOST_AFTER, PARTS, SIGMA_W, Track, closeness, smallest_hand
from vipr.systems.signals import HandTracks, SkinRegions
from vipr.systems.skin.working_image import unit

CONFIRM = 2  # frames after which a new track is reported


@dataclass(frozen=True, eq=False)
class TracksBelief:
    """The three tracks; a part never seen is absent."""

    parts: tuple[tuple[str, Track], ...] = ()
    rival: float = 0.0  # s for which some hand looked more like a face than the face did
    doubt: float = 0.0  # s for which the face has seemed to be none
    order: float = 0.0  # s for which the hands were on their own sides, less those on the other's
    faceless: float = 0.0  # s without a face
    output: HandTracks = HandTracks()

    def __copy__(self):
        return self

    def __deepcopy__(self, memo):
        return self


def follow(regions: SkinRegions, belief: TracksBelief) -> TracksBelief:
    """The belief after the regions of one more frame."""
    shape = regions.labels.shape
    if 0 in shape:
        return belief
    if regions.cut:
        belief = TracksBelief()
    u = unit(shape)
    dt = min(max(regions.time - belief.output.time, 1e-3), 0.5) if belief.output.number >= 0 else 0.04
    v = u * closeness(dict(belief.parts).get("face"), u)
    tracks = {name: _predict(name, t, dt, u if name == "face" else v, shape) for name, t in belief.parts}
    found = candidates(regions, tracks)
    face = tracks.get("face")
    if face is not None:  # nor is a speck a hand
        tracks = {n: t for n, t in tracks.items() if t.area > smallest_hand(face, 0.14 if t.life < 0.15 else 0.07, u)}
    missing = any(name not in tracks or tracks[name].unseen > LOST_AFTER for name in ("left", "right"))
    labels, found = cut_out_head(face, found, regions, u, missing, any(t.bare > BARE for t in tracks.values()))
    choice = assign(tracks, found, labels, dt, v)
    tracks = measure(tracks, choice, found, labels, regions.motion, dt, v)
    free = [r for i, r in enumerate(found) if i not in choice.values()]
    tracks = look_for_better_face(
        tracks, found[choice["face"]] if choice.get("face") is not None else None, free, labels, u
    )
    tracks = give_birth(tracks, free, labels, regions.motion, belief.faceless, u)
    faceless = 0.0 if "face" in tracks and tracks["face"].unseen == 0 else belief.faceless + min(dt, 0.06)
    tracks, rival, another = settle_face(tracks, free, labels, belief.rival, dt, u)
    tracks, doubt = doubt_face(tracks, free, 0.0 if another else belief.doubt, dt)
    tracks, order = settle_sides(tracks, 0.0 if another else belief.order, dt, u)  # sides are about the face
    return TracksBelief(tuple(tracks.items()), rival, doubt, order, faceless, _report(tracks, regions))


def _predict(name: str, t: Track, dt: float, u: float, shape) -> Track:
    """The track ``dt`` s later; merged parts keep their motion, which is what tells them apart when they part."""
    sigma = SIGMA_W[name] * (0.4 if t.shared else 1.0) * u
    return replace(t, filter=_within(kalman.predict(t.filter, dt, sigma, _damping(name, t, dt)), shape))


def _damping(name: str, t: Track, dt: float) -> float:
    """1/s: a seen track keeps its velocity (eq. 6) as long as frames come fast; an unseen one soon stops, and a face that a hand covers."""
    return 25.0 if t.unseen > 0 else 8.0 if dt > 0.08 or (name == "face" and t.shared) else 0.0


def _within(f: Kalman, shape) -> Kalman:
    """The state, stopped at the border of the image."""
    x, y = min(max(f.x, 0.0), shape[1] - 1.0), min(max(f.y, 0.0), shape[0] - 1.0)
    return f if (x, y) == (f.x, f.y) else replace(f, x=x, y=y, vx=0.0, vy=0.0)


def _report(tracks: dict, regions: SkinRegions) -> HandTracks:
    s = regions.scale
    values = {"size": regions.size, "time": regions.time, "number": regions.number}
    areas = np.zeros(3)
    for k, name in enumerate(PARTS):
        t = tracks.get(name)
        if t is None or (t.hits < CONFIRM and not regions.cut):
            continue
        values[name] = (t.position + 0.5) * s - 0.5
        values[f"{name}_velocity"] = np.array([t.filter.vx, t.filter.vy]) * s
        values[f"{name}_seen"] = t.unseen == 0
        areas[k] = t.area * s**2 if t.unseen == 0 else 0.0
    merged = tuple(n for n in PARTS if n in tracks and tracks[n].shared and tracks[n].unseen == 0)
    return HandTracks(**values, areas=areas, merged=merged)
