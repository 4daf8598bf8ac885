"""Who is who, in the long run: the face is what looks like one, and hands are mostly on their own sides."""

import numpy as np

from vipr.systems.hands.candidates import Candidate
from vipr.systems.hands.measurement import head_of
from vipr.systems.hands.parts import HEAD, SMALLEST_HEAD, born

MIND_SIDES = 0.6  # s on the wrong sides, beyond those on the right ones, after which hands exchange names
DOUBT = 0.6  # s for which a face has been where hands are and looked like none, beyond those it did, after which it is given up
UNLIKELY = 0.36  # headlike below which a face may be a hand
ON_TOP = 0.25  # headlike that a region gains where a head would be, above all parts and wider than the face below
WIDER = 1.1  # times as wide
RESTLESS = 6.0  # half-widths of a head a second: hands are often faster, heads seldom
ELBOWS = 0.25  # s of the same where both arms are bare: elbows hardly ever cross
YOUNG = 25  # frames for which a hand has been followed, up to which only its side says which it is


def settle_face(
    tracks: dict, free: list[Candidate], labels, rival: float, dt: float, u: float
) -> tuple[dict, float, bool]:
    """The face where something else has looked more like one for a while: exchanged with a hand, or moved to a region that is nobody's.

    Also for how long [s] something has, and whether it is another face now.
    """
    face = tracks.get("face")
    if face is not None and face.shared:
        return tracks, max(0.0, rival - dt), False
    looks = {n: t.headlike for n, t in tracks.items() if n != "face" and t.unseen == 0 and not t.shared}
    smallest = max(SMALLEST_HEAD * u, 0.0 if face is None else 0.5 * face.head_radius)
    looks |= {k: r.headlike for k, r in enumerate(free) if r.person > 0.25 and not r.remnant and r.core[2] > smallest}
    if face is not None:
        looks |= {k: looks[k] + ON_TOP for k in looks if k not in tracks and _heads_all(free[k], tracks)}
    best = max(looks, key=looks.get, default=None)
    enough = HEAD if face is None or face.unseen > 0 else max(face.headlike + 0.12, 0.8 * HEAD)
    step = min(dt, 0.06)
    rival = rival + step if best is not None and looks[best] > enough else max(0.0, rival - 2 * step)
    if rival < 0.3:
        return tracks, rival, False
    tracks = dict(tracks)
    if best in tracks:
        promoted = tracks.pop(best)
        if face is not None and face.unseen == 0:
            tracks[best] = face
    else:
        r = free[best]
        tracks = {n: t for n, t in tracks.items() if labels[int(t.filter.y + 0.5), int(t.filter.x + 0.5)] != r.row + 1}
        promoted = born("face", *head_of(r, labels, None, None), r, u)
    return {**tracks, "face": promoted}, 0.0, True


def _heads_all(r: Candidate, tracks: dict) -> bool:
    """Whether a region is where a head would be rather than where the face is: above all parts, calm, and wider than the face below."""
    face, seen = tracks["face"], [t for t in tracks.values() if t.unseen == 0]
    above = all(r.core[1] + r.core[2] < t.filter.y for t in seen)
    return above and r.moving < 0.3 and r.core[2] > WIDER * face.head_radius


def doubt_face(tracks: dict, free: list[Candidate], doubt: float, dt: float) -> tuple[dict, float]:
    """Without the face where for a while it has looked little like one and moved as hands do or been below another part.

    Also for how long [s] it has been so.
    """
    face = tracks.get("face")
    if face is None or face.unseen > 0 or face.shared:
        return tracks, doubt if face is not None else 0.0
    top = face.filter.y - 0.5 * face.head_height
    hands = [t.filter.y for n, t in tracks.items() if n != "face" and t.unseen == 0]
    others = [r.centre[1] for r in free if r.person > 0.5 and not r.remnant and r.area > 0.3 * face.area]
    below = any(y < top for y in (*hands, *others))
    fast = np.hypot(face.filter.vx, face.filter.vy) > RESTLESS * face.head_radius
    step = min(dt, 0.06)
    doubt = doubt + step if face.headlike < UNLIKELY and (below or fast) else max(0.0, doubt - step)
    if doubt < DOUBT:
        return tracks, doubt
    return {n: t for n, t in tracks.items() if n != "face"}, 0.0


def settle_sides(tracks: dict, order: float, dt: float, u: float) -> tuple[dict, float]:
    """Exchange the names of hands that have been on the wrong sides for longer than on their own; a new hand has no history."""
    hands = {n: tracks[n] for n in ("left", "right") if n in tracks and tracks[n].unseen == 0 and not tracks[n].shared}
    if any(t.hits <= 1 for t in hands.values()) or any(
        tracks[n].shared and tracks[n].met for n in ("left", "right") if n in tracks
    ):
        order = min(order, 0.0)
    face = tracks.get("face")
    elbows = [hands[n].elbow for n in ("left", "right") if n in hands]
    bare = len(elbows) == 2 and None not in elbows
    if bare:
        apart = (elbows[0] - elbows[1]) / u
        order = min(order, 0.0) if apart < 0.0 else order
    elif len(hands) == 2:
        apart = (hands["left"].filter.x - hands["right"].filter.x) / u
    elif len(hands) == 1 and face is not None and face.unseen == 0:
        (name, t), width = next(iter(hands.items())), 2 * np.sqrt(face.area / np.pi)
        apart = (t.filter.x - face.filter.x) * (0.6 if name == "left" else -0.6) / u
        apart = np.sign(apart) * max(0.0, abs(apart) - 0.6 * width / u)
    else:
        return tracks, order
    crossed = any(t.met for t in hands.values()) and all(t.hits > YOUNG for t in hands.values())
    patience = ELBOWS if bare else MIND_SIDES * (3.0 if crossed else 1.0)
    order = float(min(max(order + dt * min(max(apart / 10.0, -1.0), 1.0), -patience), 6.0))
    if order > -patience:
        return tracks, order
    exchange = {"left": "right", "right": "left"}
    return {exchange.get(name, name): t for name, t in tracks.items()}, 0.0
