"""Regions that nobody claimed become missing parts: a head by its looks, hands by their side of it."""

from dataclasses import replace
from itertools import permutations

import numpy as np

from vipr.systems.hands.arms import HAND_LENGTH
from vipr.systems.hands.candidates import Candidate
from vipr.systems.hands.measurement import hand_of, head_of
from vipr.systems.hands.parts import (
    HEAD,
    LOST_AFTER,
    SMALLEST_HEAD,
    Track,
    body_of,
    born,
    closeness,
    in_neck,
    smallest_hand,
)

PIECE = 0.2  # of the face, below which a region within a hand's length of a hand is a piece of it
SOME_MARKS = 0.1  # of a face, without which nothing becomes one only by being on top
ON_TRIAL = 25  # frames for which a face has been followed, up to which it may have been a hand
CUT_HEAD = 1.3  # times as large as it looks is a head that the upper border cuts
WAIT = 0.5  # s, in which something better than what just looks a little like a face should show


def give_birth(
    tracks: dict, free: list[Candidate], labels: np.ndarray, motion: np.ndarray, faceless: float, u: float
) -> dict:
    """Give regions that nobody claimed to parts that are missing; ``faceless`` s have passed without a face."""
    tracks = dict(tracks)
    free = [r for r in free if r.area > 8.0 * u * u and r.core[2] > 1.35 * u]
    if _missing(tracks, "face") and ("face" not in tracks or tracks["face"].unseen > 0.2):
        r = _likeliest_head(free, faceless, u)
        if r is not None:
            tracks["face"] = born("face", *head_of(r, labels, None, None), r, u)
            free.remove(r)
        elif "face" not in tracks and faceless < WAIT:
            free = [r for r in free if r.headlike < HEAD - 0.16 or r.moving > 0.3]  # it may yet turn out to be the face
    free = _possible_hands(free, tracks.get("face"), u)
    whole = [r for r in free if not _fragment(r, tracks)]
    missing = [name for name in ("left", "right") if _missing(tracks, name)]
    for name, r in _cheapest_hands(missing, whole[:3], tracks, labels.shape[1], u):
        centre, area = hand_of(r, labels, motion, None, body_of(tracks, name))
        tracks[name] = born(name, centre, area, r, u)
        free.remove(r)
    return _give_up_still_hands(tracks, free, tracks.get("face"), u)


def _missing(tracks: dict, name: str) -> bool:
    return name not in tracks or tracks[name].unseen > 0 or tracks[name].crowded > 0.12


def _likeliest_head(free: list[Candidate], faceless: float, u: float) -> Candidate | None:
    """The region that may become the face; the longer there is none, the less it takes, if it is above other regions and calm."""
    found = [r for r in free if r.person > 0.28 and r.core[2] > SMALLEST_HEAD * u]
    if not found:
        return None
    best = max(found, key=lambda r: r.headlike)
    others = [r for r in found if r is not best and r.person > 0.5]
    topmost = len(others) >= 1 and all(best.core[1] < other.centre[1] for other in others)
    enough = HEAD - (
        0.18 * min(faceless / WAIT, 1.0) if topmost and best.moving < 0.4 and best.marks > SOME_MARKS else 0.0
    )
    return best if best.headlike > enough and (best.person > 0.5 or topmost) else None


def _possible_hands(free: list[Candidate], face: Track | None, u: float) -> list[Candidate]:
    """Regions that can be a hand or an arm, the most evident first."""
    if face is None:
        hands = [r for r in free if r.person > 0.5]
    else:  # a hand is not many times the size of the face, nor a speck beside it, nor out of reach, nor the neck
        radius = face.head_radius * _cut(face)

        def possible(r):
            dx, dy = (r.centre[0] - face.filter.x) / radius, (r.centre[1] - face.filter.y) / radius
            neck = in_neck(r, face, 0.3)
            still = r.person <= 0.5 or r.moving < 0.1
            if neck or r.headlike > HEAD + 0.07 or (r.remnant and r.moving < 0.3) or (still and r.person < 0.28):
                return False
            size = smallest_hand(face, 0.15, u) < r.area < (3.0 if still else 6.0) * face.area
            return size and np.hypot(dx, dy) < 14.5 and (not still or hangs(r, face))

        hands = [r for r in free if possible(r)]
    return sorted(hands, key=lambda r: -r.person * np.sqrt(r.area))


def _fragment(r: Candidate, tracks: dict) -> bool:
    """Whether a region is a piece of the arm or the fingers of a hand that is followed, broken off its region.

    With a face, a piece is near that hand, smaller, and far on that hand's side, or within its length and much smaller than any hand;
    without one, it is nearer and much smaller than that hand.
    """
    face = tracks.get("face")
    for name in ("left", "right"):
        t = tracks.get(name)
        if t is None or t.unseen > 0 or t.hits <= 1:
            continue
        away = np.hypot(r.centre[0] - t.filter.x, r.centre[1] - t.filter.y)
        if face is None:
            piece = away < 4.0 * np.sqrt(t.area / np.pi) and r.area < 0.6 * t.area
        else:
            side = (r.centre[0] - face.filter.x) * (1.0 if name == "left" else -1.0)
            piece = r.area < t.area and away < 1.6 * face.head_height and side > 0.4 * face.head_height
            piece = piece or (away < HAND_LENGTH * face.head_height and r.area < PIECE * face.area)
        other = tracks.get("right" if name == "left" else "left")
        if piece and not (other is not None and other.unseen < LOST_AFTER and _near(other, r, tracks)):
            return True
    return False


def _near(t: Track, r: Candidate, tracks: dict) -> bool:
    """Whether a region is within a head's height of where a part was."""
    head = tracks["face"].head_height if "face" in tracks else 4.0 * np.sqrt(t.area / np.pi)
    return bool(np.hypot(r.centre[0] - t.filter.x, r.centre[1] - t.filter.y) < head)


def _cut(face: Track) -> float:
    """How many times larger than it looks the head is: one that the upper border cuts."""
    return CUT_HEAD if face.filter.y < 0.55 * face.head_height else 1.0


def hangs(r: Candidate, face: Track) -> bool:
    """Whether a still region is where a hanging arm or resting hand would be."""
    head = face.head_height * _cut(face)
    across, down = abs(r.centre[0] - face.filter.x) / head, (r.centre[1] - face.filter.y) / head
    return bool(0.4 < across < 2.0 and 1.5 < down < 5.0)


def _cheapest_hands(missing: list, free: list[Candidate], tracks: dict, width: int, u: float) -> list:
    """(part, region) for missing hands: each as near as it can be to where it was lost, or else to its own side of the face."""
    face = tracks.get("face")
    v = u * closeness(face, u)
    middle, head = (0.5 * width, 0.2 * width) if face is None else (face.filter.x, face.head_height)

    def price(name, r):
        t = tracks.get(name)
        if t is not None and 0 < t.unseen < LOST_AFTER:
            return 0.6 * np.hypot(r.centre[0] - t.filter.x, r.centre[1] - t.filter.y) / ((12.0 + 160.0 * t.unseen) * v)
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


def _give_up_still_hands(tracks: dict, free: list[Candidate], face: Track | None, u: float) -> dict:
    """Without the tracks of things that hardly move, as far as larger regions that do move belong to nobody."""
    size = smallest_hand(face, 0.2, u) if face is not None else 0.0
    waiting = sorted((r.moving * np.sqrt(r.area) for r in free if r.moving > 0.3 and r.area > size), reverse=True)
    held = {
        n: (t.life + 0.1) * np.sqrt(t.area) for n, t in tracks.items() if n != "face" and t.unseen == 0 and not t.shared
    }
    tracks = dict(tracks)
    for claim, name in zip(waiting, sorted(held, key=held.get), strict=False):
        if claim > 2.0 * held[name]:
            del tracks[name]
    return tracks


def look_for_better_face(
    tracks: dict, now: Candidate | None, free: list[Candidate], labels: np.ndarray, u: float
) -> dict:
    """The face moved at once to a region that looks far more like one than where the track has ended.

    That region is near by; or, as long as the face is on trial (a hand looks like one for a moment), anywhere above it.
    """
    face = tracks.get("face")
    if face is None or now is None or now.cut or face.shared:
        return tracks
    reach = 6.0 * np.sqrt(face.area / np.pi)
    near = [
        r
        for r in free
        if r.core[2] > 0.5 * face.head_radius
        and (
            np.hypot(r.centre[0] - face.filter.x, r.centre[1] - face.filter.y) < reach
            or (face.hits < ON_TRIAL and r.centre[1] < face.filter.y)
        )
    ]
    best = max(near, key=lambda r: r.headlike, default=None)
    if best is None or best.headlike < max(HEAD + 0.05, now.headlike + 0.2):
        return tracks
    free.remove(best)
    return {**tracks, "face": replace(born("face", *head_of(best, labels, None, None), best, u), hits=face.hits)}
