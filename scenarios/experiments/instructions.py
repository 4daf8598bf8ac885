"""The robot's own language: twelve gestures for instructing a fetching robot, and what hands do when they instruct nobody.

A stroke is drawn in the plane before the person, x to the image's right (the person's left), y up, in metres, the origin midway between the
shoulders. A hand that a gesture does not need hangs at the side.
"""

from dataclasses import dataclass

import numpy as np

from vipr.scenarios.experiments.writers import along, timed, tremble
from vipr.scenarios.people.motion import HandPaths, rest, smooth_noise

HOME = np.array([0.21, -0.24])  # of the left hand; the right hand's is its mirror image
FORWARD = 0.36  # m before the shoulders
RATE = 25.0
GARBAGE = "none"
PAUSE = 10  # frames that the hands stay where a gesture ended

# Name: strokes of (right, left), each a polyline of (outwards, up) from the origin for that hand, both walked together; whether it points.
# "outwards" grows away from the body's middle.
LANGUAGE = {
    "stop": ([(0.21, -0.24), (0.25, 0.24)], None),
    "come": ([(0.21, -0.24), (0.14, -0.02), (0.21, -0.22), (0.14, -0.02), (0.21, -0.22)], None),
    "go back": ([(0.07, -0.12), (0.38, -0.27), (0.09, -0.13), (0.38, -0.27)],) * 2,
    "left": (None, [(0.2, -0.2), (0.4, -0.13), (0.62, -0.16)]),
    "right": ([(0.2, -0.2), (0.4, -0.13), (0.62, -0.16)], None),
    "faster": ("circles", None),
    "slower": ([(0.2, 0.03), (0.21, -0.36)],) * 2,
    "fetch": ("point", None),
    "put": ("carry", "carry"),
    "yes": ([(0.34, -0.16), (0.26, -0.3), (0.05, 0.04)], None),
    "no": ([(0.36, -0.14), (0.06, -0.13), (0.36, -0.14), (0.06, -0.13), (0.34, -0.14)], None),
    "cancel": ([(0.24, -0.2), (-0.16, -0.14), (0.24, -0.2), (-0.16, -0.14), (0.24, -0.2)],) * 2,
}
POINTING = ("fetch", "put")
STROKES = [stroke for pair in LANGUAGE.values() for stroke in pair if isinstance(stroke, list)]
LEAST_WAY = 0.15  # m from one gesture to the next


@dataclass(frozen=True)
class Person:
    """Habits of one person who gestures."""

    seed: int
    size: float  # of strokes, 1 is as in the table
    pace: float  # m/s on average
    tilt: float  # rad, outwards
    shift: tuple[float, float]  # m, where the gestures are made
    habit: float  # m, lasting distortion of each gesture
    chance: float  # m, change from one time to the next
    tremor: float  # m

    @staticmethod
    def drawn(seed: int) -> "Person":
        """A person by chance."""
        rng = np.random.default_rng([11, seed])
        return Person(
            seed=seed,
            size=rng.uniform(0.82, 1.15),
            pace=rng.uniform(0.55, 0.95),
            tilt=rng.normal(0.0, 0.08),
            shift=(rng.normal(0.0, 0.02), rng.normal(0.0, 0.03)),
            habit=rng.uniform(0.01, 0.025),
            chance=rng.uniform(0.008, 0.018),
            tremor=rng.uniform(0.0005, 0.002),
        )


def perform(person: Person, name: str, rng: np.random.Generator, hold: int = PAUSE) -> tuple[HandPaths, np.ndarray]:
    """One gesture: paths of the hands at 25 Hz, still for ``hold`` frames at the end, and where it points.

    The direction is a unit vector in the image (x right, y up), NaN for gestures that do not point.
    """
    strokes, target = _strokes(name, rng)
    own = np.random.default_rng([person.seed, *name.encode()])
    bends = [(_bend(own, person.habit) + _bend(rng, person.chance)) for _ in range(2)]
    curves = []
    for stroke, bend, sign in zip(strokes, bends, (-1.0, 1.0), strict=True):  # right, left
        if stroke is None:
            curves.append(np.zeros((DENSE, 0)))
            continue
        curve = _round(along(np.array(stroke, float), DENSE)) + bend
        middle = curve.mean(axis=0)
        c, s = np.cos(person.tilt), np.sin(person.tilt)
        curve = middle * (1.0 + 0.5 * (person.size - 1.0)) + person.size * (curve - middle) @ np.array(
            [[c, s], [-s, c]]
        )
        curves.append((curve + person.shift) * (sign, 1.0))
    both = np.concatenate(curves, axis=1)
    pace = person.pace * np.exp(rng.normal(0.0, 0.1)) * {"faster": 1.5, "slower": 0.55}.get(name, 1.0)
    path = timed(both, pace * np.sqrt(both.shape[1] / 2), RATE)
    path = np.concatenate([path, np.repeat(path[-1:], hold, 0)])
    path = path + np.concatenate(
        [tremble(rng, len(path), person.tremor, RATE) for _ in range(path.shape[1] // 2)], axis=1
    )
    right = _place(path[:, :2]) if strokes[0] is not None else None
    left = _place(path[:, -2:]) if strokes[1] is not None else None
    return HandPaths(right=right, left=left), target


DENSE = 240


def _strokes(name, rng):
    """Strokes of (right, left) as (outwards, up), and the direction pointed to."""
    strokes, target = list(LANGUAGE[name]), np.full(2, np.nan)
    if strokes[0] == "circles":
        turn = np.linspace(0.5 * np.pi, 4.5 * np.pi, 80)
        strokes[0] = np.column_stack([0.24 + 0.11 * np.cos(turn), -0.13 + 0.11 * np.sin(turn)])
    elif strokes[0] == "point":
        angle = rng.uniform(-0.9, 0.9)
        reach = np.array([0.1, -0.2]) + 0.46 * np.array([np.cos(angle), np.sin(angle)])
        strokes[0] = [(0.1, -0.2), reach, (0.09, -0.2)]
        target = np.array([-np.cos(angle), np.sin(angle)])
    elif strokes[0] == "carry":
        side, down = rng.choice([-1.0, 1.0]), rng.uniform(0.0, 0.35)
        hop = np.array([[0.0, -0.22], [0.14 * side, -0.06], [0.3 * side, -0.22 - down]])
        apart = np.array([[0.055, 0.0], [0.055, 0.0], [0.055, 0.0], [0.16, 0.0]])
        hop = np.concatenate([hop, hop[-1:]])
        strokes = [hop * (-1.0, 1.0) + apart, hop + apart]
        moved = np.array([0.3 * side, -down])
        target = moved / np.linalg.norm(moved)
    return strokes, target


def _bend(rng, size):
    u = np.linspace(0.0, 1.0, DENSE)[:, None]
    return sum(
        rng.normal(0.0, size, 2) / np.sqrt(1.0 + k) * np.cos(np.pi * k * u + rng.uniform(0.0, 2.0 * np.pi, 2))
        for k in range(4)
    )


def _round(curve, share=0.02):
    reach = int(3 * share * len(curve))
    weight = np.exp(-0.5 * (np.arange(-reach, reach + 1) / (share * len(curve))) ** 2)
    padded = np.pad(curve, ((reach, reach), (0, 0)), mode="edge")
    return np.stack([np.convolve(c, weight / weight.sum(), "valid") for c in padded.T], axis=-1)


def _place(plane):
    return np.column_stack([np.full(len(plane), FORWARD), plane[:, 0], plane[:, 1]])


def idle(person: Person, rng: np.random.Generator, hold: int = PAUSE) -> tuple[HandPaths, str]:
    """Hands that instruct nobody, and what they do: talk, fidget, scratch, reach, fold, go up or down, or from one gesture to the next."""
    from vipr.models.person.generate import BODIES

    kind = str(rng.choice(["talk", "talk", "fidget", "scratch", "raise", "lower", "reach", "fold", "way", "way"]))
    hanging = [rest(BODIES["medium"], side) for side in ("right", "left")]
    home = [_place(np.array([[-HOME[0], HOME[1]]]))[0], _place(HOME[None])[0]]
    mirror = np.array([1.0, -1.0, 1.0])
    if kind in ("talk", "fidget"):
        n = int(rng.integers(40, 90))
        size = (0.10 if kind == "talk" else 0.03) * rng.uniform(0.7, 1.4)
        period = 1.2 if kind == "talk" else 0.8
        ramp = np.sin(np.pi * np.linspace(0.0, 1.0, n))[:, None] ** 0.5
        paths = [
            h + ramp * size * np.column_stack([smooth_noise(rng, n, period) for _ in range(3)]) * (0.5, 1.0, 1.0)
            for h in home
        ]
        if kind == "talk" and rng.random() < 0.4:
            paths[int(rng.integers(2))] = None
    else:
        way = {
            "scratch": lambda h, r: [
                r,
                np.array([0.14, -0.09, 0.22]),
                np.array([0.14, -0.13, 0.17]),
                np.array([0.14, -0.09, 0.22]),
                r,
            ],
            "raise": lambda h, r: [r, h],
            "lower": lambda h, r: [h, r],
            "reach": lambda h, r: [r, np.array([0.45, -rng.uniform(0.1, 0.6), rng.uniform(-0.5, -0.3)]), r],
            "fold": lambda h, r: [r, np.array([0.24, 0.02, -0.2])],
            "way": lambda h, r: _way(r, rng),
        }[kind]
        both = kind == "fold" or (kind in ("raise", "lower") and rng.random() < 0.4)
        side = int(rng.integers(2))
        base = timed(
            along(np.array([p + rng.normal(0, 0.02, 3) for p in way(home[0], hanging[0])]), DENSE),
            rng.uniform(0.5, 1.0),
            RATE,
        )
        base = np.concatenate([base, np.repeat(base[-1:], hold, 0)])
        paths = [base, base * mirror] if both else [base if side == 0 else None, base * mirror if side == 1 else None]
    return HandPaths(*paths), kind


def _way(hanging: np.ndarray, rng: np.random.Generator) -> list[np.ndarray]:
    """From where one gesture of the right hand ends (or from the side) to where another begins (or to the side), not too near."""
    ends, starts = ([hanging, *(_place(np.array([s[k]]) * (-1.0, 1.0))[0] for s in STROKES)] for k in (-1, 0))
    while True:
        a, b = ends[rng.integers(len(ends))], starts[rng.integers(len(starts))]
        if np.linalg.norm(b - a) > LEAST_WAY:
            return [a, b]


def perform_all(
    person: Person, names: list[str], rng: np.random.Generator
) -> tuple[list[HandPaths], list[tuple[int, int]], np.ndarray]:
    """Paths, bounds and directions of a row of gestures (``GARBAGE`` for a non-gesture)."""
    paths, bounds, targets = [], [], []
    for name in names:
        if name == GARBAGE:
            path, target = idle(person, rng)[0], np.full(2, np.nan)
        else:
            path, target = perform(person, name, rng)
        paths.append(path)
        bounds.append((0, len(path) - PAUSE - 1))
        targets.append(target)
    return paths, bounds, np.array(targets)
