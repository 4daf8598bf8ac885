"""Who is who, in the long run: the face is what looks like one, and hands are mostly on their own sides."""

import numpy as np

from vipr.systems.hands.candidates import Candidate
from vipr.systems.hands.measurement import head_of
from vipr.systems.hands.parts import HEAD, SMALLEST_HEAD, born

MIND_SIDES = 0.6  # s on the wrong sides, beyond those on the right ones, after which hands exchange names
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


def settle_sides(tracks: dict, order: float, dt: float, u: float) -> tuple[dict, float]:
    """Exchange the names of hands that have been on the wrong sides for longer than on their own; a new hand has no history."""
    hands = {n: tracks[n] for n in ("left", "right") if n in tracks and tracks[n].unseen == 0 and not tracks[n].shared}
    if any(t.hits <= 1 for t in hands.values()) or any(
        tracks[n].shared and tracks[n].met for n in ("left", "right") if n in tracks
    ):
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
    crossed = any(t.met for t in hands.values()) and all(t.hits > YOUNG for t in hands.values())
    patience = MIND_SIDES * (3.0 if crossed else 1.0)
    order = float(np.clip(order + dt * np.clip(apart / 10.0, -1.0, 1.0), -patience, 6.0))
    if order > -patience:
        return tracks, order
    exchange = {"left": "right", "right": "left"}
    return {exchange.get(name, name): t for name, t in tracks.items()}, 0.0
