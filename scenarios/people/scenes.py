"""Random scenes of the living room: who stands there, what the hands do, how the light changes. A scene is a function of its seed."""

from dataclasses import dataclass

import numpy as np

from vipr.diagrams.living_room import CameraPlace, Look, random_look
from vipr.models.person.generate import BODIES, Body
from vipr.scenarios.people.motion import HandPaths, rest
from vipr.systems.camera.illumination import WHITE_KELVIN

RATE = 25.0  # frames/s
KINDS = ("apart", "cross", "touch", "face", "leave")
LIGHTS = ("constant", "step", "drift")


@dataclass(frozen=True, eq=False)
class Scene:
    """All that is needed to film it."""

    seed: int
    kind: str  # of KINDS: what the hands do beside moving about
    body: str
    look: Look
    place: CameraPlace
    paths: HandPaths
    light: np.ndarray  # (n, 2) intensity, colour temperature [K]


def random_scene(
    seed: int,
    *,
    kind: str | None = None,
    light: str | None = None,
    seconds: float = 6.0,
    decors=("plain", "wallpaper", "beige", "wood"),
) -> Scene:
    """The scene of a seed; kind and light program are drawn where not given (light: constant white)."""
    rng = np.random.default_rng((seed, 77))
    kind = kind or KINDS[seed % len(KINDS)]
    body = str(rng.choice(list(BODIES)))
    look = random_look(rng, decors)
    place = CameraPlace(distance=float(rng.choice([1.9, 2.1, 2.4])), level=float(rng.choice([1.2, 1.3])))
    paths = _paths(rng, BODIES[body], kind, round(seconds * RATE))
    return Scene(seed, kind, body, look, place, paths, light_program(rng, light or "constant", len(paths)))


def light_program(rng: np.random.Generator, program: str, n: int) -> np.ndarray:
    """(n, 2) intensity 0.4 to 1.6 and colour temperature 3000 to 8000 K: constant white, a few steps, or smooth drifts."""
    if program == "constant":
        return np.tile([1.0, WHITE_KELVIN], (n, 1))

    def draw(count):
        return np.column_stack([rng.uniform(0.4, 1.6, count), 1e6 / rng.uniform(1e6 / 8000, 1e6 / 3000, count)])

    if program == "fixed":
        return np.repeat(draw(1), n, 0)
    knots = np.linspace(0, n, 5).astype(int)
    values = draw(5)
    if program == "step":
        return np.repeat(values[:4], np.diff(knots), axis=0)
    t = np.arange(n)
    return np.column_stack([np.interp(t, knots, values[:, k]) for k in range(2)])


def _paths(rng: np.random.Generator, body: Body, kind: str, n: int) -> HandPaths:
    """Both hands through random places before the person, with the event of this kind in the middle."""
    size = body.stature / 1.72
    t = np.arange(n) / RATE
    paths = {}
    for side, sign in (("left", 1.0), ("right", -1.0)):
        paths[side] = _wander(rng, t, sign) * size
    left_handed = rng.random() < 0.3
    active, other = ("left", "right") if left_handed else ("right", "left")
    if kind == "apart" and rng.random() < 0.5:
        paths[other] = np.repeat(rest(body, other)[None], n, 0)
    middle, width = rng.uniform(0.4, 0.6) * n / RATE, rng.uniform(0.45, 0.9)
    w = np.exp(-(((t - middle) / width) ** 4))[:, None]  # 1 during the event
    if kind == "cross":  # each goes to the other's side at nearly one height, and back later
        z = rng.uniform(-0.25, 0.05)
        for side, sign in (("left", 1.0), ("right", -1.0)):
            depth = 0.40 + (0.05 if side == active else -0.03)
            there = np.array([depth, -sign * 0.22, z + sign * rng.uniform(-0.04, 0.04)]) * size
            paths[side] = (1 - w) * paths[side] + w * there
    elif kind == "touch":  # they meet in the middle and part again
        z = rng.uniform(-0.3, 0.0)
        for side, sign in (("left", 1.0), ("right", -1.0)):
            there = np.array([0.42, sign * rng.uniform(0.025, 0.05), z]) * size
            paths[side] = (1 - w) * paths[side] + w * there
    elif kind == "face":
        there = np.array([0.22, rng.uniform(-0.05, 0.05), rng.uniform(0.14, 0.22)]) * size
        paths[active] = (1 - w) * paths[active] + w * there
    elif kind == "leave":  # behind the back, or out of the picture
        sign = 1.0 if active == "left" else -1.0
        there = np.array([-0.22, sign * 0.12, -0.42] if rng.random() < 0.5 else [0.05, sign * 0.25, -0.64]) * size
        paths[active] = (1 - w) * paths[active] + w * there
    return HandPaths(right=paths["right"], left=paths["left"])


def _wander(rng: np.random.Generator, t: np.ndarray, sign: float) -> np.ndarray:
    """A smooth path (n, 3) on the hand's own side of the body, for a person of 1.72 m."""
    path = np.tile([0.36, sign * 0.30, -0.14], (len(t), 1))
    for axis, reach in enumerate((0.05, 0.11, 0.20)):
        for _ in range(3):
            path[:, axis] += reach / 1.7 * np.sin(2 * np.pi * (rng.uniform(0.15, 0.75) * t + rng.uniform()))
    return path
