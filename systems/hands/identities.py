"""Who is who, in the long run: the face is what looks like one, and hands are mostly on their own sides."""

import numpy as np

from vipr.systems.hands.parts import HEAD

MIND_SIDES = 0.6  # s on the wrong sides, beyond those on the right ones, after which hands exchange names


def settle_face(tracks: dict, rival: float, dt: float) -> tuple[dict, float]:
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


def settle_sides(tracks: dict, order: float, dt: float, u: float) -> tuple[dict, float]:
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
