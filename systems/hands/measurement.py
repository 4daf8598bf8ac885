"""What a region says of the part in it: where the head or the hand is, and the track after that."""

import math
from dataclasses import replace

import numpy as np

from vipr.systems.hands import kalman
from vipr.systems.hands.arms import Body, hand_end
from vipr.systems.hands.assignment import GATE
from vipr.systems.hands.blobs import head_in, pixels_of
from vipr.systems.hands.candidates import Candidate
from vipr.systems.hands.merging import measure_shared
from vipr.systems.hands.parts import SIGMA_N, Track, anew, body_of, hand_before_face

MISSED = 150.0  # px/s at 160 x 120, the highest speed of a part that is missed: faster ones were mostly an error of the measurement before
END_OF_ARM = 1.5  # times the noise of a centre, where only the end of a bare arm says where the hand is
HIDDEN = 3.0  # the same where the hand is before the face, and only its arm is seen apart
LIFE = 2.0  # s, in which the memory of having moved halves


def measure(tracks: dict, choice: dict, found: list[Candidate], labels, motion, dt: float, u: float) -> dict:
    """The tracks after their regions' measurements."""
    out = {}
    for name, t in tracks.items():
        i = choice.get(name)
        if i is None:
            slow = min(1.0, MISSED * u / max(math.hypot(t.filter.vx, t.filter.vy), 1e-6))
            slower = replace(t.filter, vx=slow * t.filter.vx, vy=slow * t.filter.vy)
            out[name] = replace(t, filter=slower, unseen=t.unseen + dt, shared=False)
            continue
        r = found[i]
        sharers = [other for other in tracks if choice.get(other) == i]
        if len(sharers) > 1:
            out[name] = measure_shared(name, t, sharers, tracks, body_of(tracks, name), r, labels, dt, u)
            continue
        expected = t.position
        if name == "face":
            centre, area = head_of(r, labels, expected, t.head_radius)
        elif r.arm is not None:
            centre, area = hand_before_face(r, tracks["face"].head_height), t.area
        else:
            centre, area = hand_of(r, labels, motion, expected, body_of(tracks, name))
        far = math.hypot(*(centre - expected).tolist()) > (GATE[name][0] + GATE[name][1] * dt) * u
        arm_seen = name != "face" and area < 0.7 * r.area and not r.remnant
        doubt = HIDDEN if r.arm is not None else END_OF_ARM if name != "face" and area < 0.7 * r.area else 1.0
        f = anew(name, centre, u) if far else kalman.update(t.filter, *centre, SIGMA_N * u * doubt)
        rate = 0.15
        slow = 2.0 if r.cut else 1.0 if r.area > 1.7 * area else 0.25  # s
        look = t.headlike if r.remnant else t.headlike + (1 - math.exp(-dt / slow)) * (r.headlike - t.headlike)
        elbow = 2.0 * r.centre - centre if arm_seen else None
        bare = t.bare if r.remnant else t.bare + 0.1 * (arm_seen - t.bare)
        out[name] = Track(
            f, t.area + rate * (area - t.area), 0.0, t.hits + 1, look, max(r.moving, t.life * 0.5 ** (dt / LIFE)), met=t.met,
            elbow=None if elbow is None else float(elbow[0]), bare=bare,
        )  # fmt: skip
    return out


def head_of(r: Candidate, labels: np.ndarray, expected, radius: float | None):
    """Centre and area of the head in a region: all of it, or the ellipse about its core or about where it is expected."""
    if r.area < 1.75 * np.pi * r.core[2] ** 2 and (radius is None or r.area < 1.6 * 1.3 * np.pi * radius**2):
        return r.centre, r.area
    near_core = expected is None or np.hypot(*(r.core[:2] - expected)) < max(r.core[2], radius)
    start = r.core[:2] if near_core else expected
    size = r.core[2] if radius is None else (0.5 * (radius + min(r.core[2], 1.5 * radius)) if near_core else radius)
    centre, count = head_in(pixels_of(labels, r.row), start, size)
    return (centre, count) if count else (r.centre, r.area)


def hand_of(r: Candidate, labels: np.ndarray, motion: np.ndarray, expected, body: Body | None):
    """Centre and area of the hand in a region: all of it, or the end of a bare arm."""
    p = pixels_of(labels, r.row)
    if len(p) < 12:
        return r.centre, r.area
    centre, count = hand_end(p, expected, body, motion)
    return (r.centre, r.area) if count >= len(p) else (centre, r.area * count / len(p))
