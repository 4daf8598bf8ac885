"""People who draw: from the skeleton of a symbol to the path of a hand, with the habits of a writer and the chance of the moment.

A writer has a slant, a tilt, proportions, a size, a pace, rounded corners, favourite forms of each symbol and lasting distortions of
each; every drawing adds a bend, tremor and a change of pace. The hand moves by the two-thirds power law: tangential speed is
proportional to curvature to the power -1/3 (Lacquaniti, Terzuolo, Viviani 1983), from rest to rest.
"""

import json
from dataclasses import dataclass
from importlib.resources import files

import numpy as np

DENSE = 240  # points of a drawing before it is timed


@dataclass(frozen=True)
class Writer:
    """Habits of one writer."""

    seed: int
    slant: float  # shear, x per y
    tilt: float  # rad
    stretch: float  # log of width over height beyond the skeleton's
    size: float  # m, height of a symbol
    pace: float  # symbol heights per second, on average
    roundness: float  # share of the length over which a corner is rounded
    habit: float  # size of the lasting distortion of each symbol, in symbol heights
    chance: float  # size of the bend of each drawing
    tremor: float  # m, RMS, 8 to 12 Hz
    loyalty: float  # probability of drawing the favourite form

    @staticmethod
    def drawn(seed: int) -> "Writer":
        """A writer by chance."""
        rng = np.random.default_rng([7, seed])
        return Writer(
            seed=seed,
            slant=rng.normal(0.0, 0.15),
            tilt=rng.normal(0.0, 0.06),
            stretch=rng.normal(0.0, 0.12),
            size=rng.uniform(0.26, 0.38),
            pace=rng.uniform(1.6, 2.6),
            roundness=rng.uniform(0.008, 0.022),
            habit=rng.uniform(0.02, 0.04),
            chance=rng.uniform(0.015, 0.03),
            tremor=rng.uniform(0.0005, 0.002),
            loyalty=rng.uniform(0.85, 1.0),
        )


def graffiti() -> dict[str, list[np.ndarray]]:
    """The forms of each of the 26 letters, the usual one first: (n, 2) in a unit box, x right, y up."""
    table = json.loads((files("vipr.models") / "gestures" / "graffiti1.json").read_text())["symbols"]
    return {
        letter: [np.array(form["points"], float) for form in (table[letter], *table[letter]["alternates"])]
        for letter in "ABCDEFGHIJKLMNOPQRSTUVWXYZ"
    }


def draw(
    writer: Writer, symbol: str, forms: list[np.ndarray], rng: np.random.Generator, rate: float = 25.0
) -> np.ndarray:
    """One drawing (n, 2) at ``rate`` Hz, centred on the symbol's box, in symbol heights, x right and y up."""
    own = np.random.default_rng([writer.seed, *symbol.encode()])
    favourite = int(own.random() ** 2 * len(forms))
    form = favourite if len(forms) == 1 or rng.random() < writer.loyalty else int(rng.integers(len(forms)))
    points = along(forms[form] - 0.5, DENSE)
    points = points + _bend(own, writer.habit) + _bend(rng, writer.chance)
    points = _rounded(points, writer.roundness)
    c, s = np.cos(writer.tilt), np.sin(writer.tilt)
    shape = (
        np.array([[c, -s], [s, c]])
        @ np.array([[1.0, writer.slant], [0.0, 1.0]])
        @ np.diag([np.exp(writer.stretch), 1.0])
    )
    points = points @ shape.T
    points = timed(points, writer.pace * np.exp(rng.normal(0.0, 0.12)), rate)
    return points + tremble(rng, len(points), writer.tremor / writer.size, rate)


def along(points: np.ndarray, count: int) -> np.ndarray:
    """``count`` points at equal distances along a polyline (n, d)."""
    length = np.r_[0.0, np.cumsum(np.linalg.norm(np.diff(points, axis=0), axis=1))]
    wanted = np.linspace(0.0, length[-1], count)
    return np.stack([np.interp(wanted, length, c) for c in points.T], axis=-1)


def _bend(rng, size):
    u = np.linspace(0.0, 1.0, DENSE)[:, None]
    return sum(
        rng.normal(0.0, size, 2) / np.sqrt(1.0 + k) * np.cos(np.pi * k * u + rng.uniform(0.0, 2.0 * np.pi, 2))
        for k in range(5)
    )


def _rounded(points, share):
    """Gaussian average over ``share`` of the length; the ends stay."""
    reach = max(1, int(3 * share * len(points)))
    weight = np.exp(-0.5 * (np.arange(-reach, reach + 1) / max(share * len(points), 1e-6)) ** 2)
    weight /= weight.sum()
    before, after = 2 * points[0] - points[reach:0:-1], 2 * points[-1] - points[-2 : -reach - 2 : -1]
    padded = np.concatenate([before, points, after])
    return np.stack([np.convolve(c, weight, "valid") for c in padded.T], axis=-1)


def timed(points: np.ndarray, pace: float, rate: float, least: float = 0.4) -> np.ndarray:
    """The curve (n, d) walked by the two-thirds power law at ``pace`` units/s on average, from rest to rest, at ``rate`` Hz.

    It takes at least ``least`` s.
    """
    points = along(points, len(points))
    step = np.linalg.norm(points[1] - points[0])
    turn = np.linalg.norm(np.diff(points, n=2, axis=0), axis=1) / max(step, 1e-12) ** 2
    length = step * (len(points) - 1)
    curvature = np.r_[turn[:1], turn, turn[-1:]] + 0.6 / max(length, 1e-12)  # a straight stroke is not infinitely fast
    speed = np.minimum(curvature, 60.0 / max(length, 1e-12)) ** (-1.0 / 3.0)
    u = np.linspace(0.0, 1.0, len(points))
    speed = speed * np.maximum(np.sqrt(np.minimum(1.0, np.minimum(u, 1.0 - u) / 0.12)), 0.12)
    time = np.r_[0.0, np.cumsum(2.0 / (speed[1:] + speed[:-1]))]
    duration = max(length / pace, least)
    time *= duration / time[-1]
    at = np.linspace(0.0, duration, max(round(duration * rate) + 1, 4))
    return np.stack([np.interp(at, time, c) for c in points.T], axis=-1)


def tremble(rng: np.random.Generator, count: int, size: float, rate: float) -> np.ndarray:
    """(count, 2) tremor of RMS ``size``: a few waves between 8 and 12 Hz."""
    t = np.arange(count) / rate
    frequency, phase = rng.uniform(8.0, 12.0, (3, 1)), rng.uniform(0.0, 2.0 * np.pi, (3, 2))
    waves = np.sin(2.0 * np.pi * frequency[:, :, None] * t + phase[:, :, None])
    return size * np.sqrt(2.0 / 3.0) * waves.sum(axis=0).T
