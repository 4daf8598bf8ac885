"""What a person does before the gesture camera: instructions and idle movements in a row, and what each of them was."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from pydrake.trajectories import PiecewisePolynomial

from vipr.models.person.generate import Body
from vipr.scenarios.experiments.instructions import GARBAGE, Person, perform_all
from vipr.scenarios.people.motion import SIDES, HandPaths, greeting, joint_positions, led_in, rest

RATE = 25.0  # frames/s
PAUSE = 12  # frames of rest before each movement


@dataclass(frozen=True, eq=False)
class Performance:
    """Joint positions over time, and the movements that are meant: their names (``GARBAGE``: nothing is meant) and times."""

    q: PiecewisePolynomial  # (15,) positions of the person's joints
    names: tuple[str, ...]
    spans: np.ndarray  # (N, 2) s, first and last moment of each
    targets: np.ndarray  # (N, 2) where it points to in the image, unit vector x right, y up; NaN where it does not


def performance(person: Person, body: Body, names: Sequence[str], rng: np.random.Generator) -> Performance:
    """The person greets and then makes the movements, each after a way to its beginning and a pause."""
    paths, bounds, targets = perform_all(person, list(names), rng)
    hands, at, spans = {side: rest(body, side) for side in SIDES}, 0, []
    rows = {side: [] for side in SIDES}
    for path, bound in zip([greeting(), *paths], [None, *bounds], strict=True):
        whole = led_in(path, hands, body, PAUSE)
        for side in SIDES:
            own = getattr(whole, side)
            rows[side].append(np.repeat(rest(body, side)[None], len(whole), axis=0) if own is None else own)
            hands[side] = rows[side][-1][-1]
        at += len(whole)
        if bound is not None:
            spans.append([at - len(path) + bound[0], at - len(path) + bound[1]])
    both = HandPaths(**{side: np.concatenate(rows[side]) for side in SIDES})
    q = joint_positions(both, body, rng, rate=RATE)
    times = np.arange(len(q)) / RATE
    return Performance(
        PiecewisePolynomial.FirstOrderHold(times, q.T), tuple(names), np.array(spans, float) / RATE, targets
    )


def drawn_names(language: Sequence[str], gestures: int, idle: int, rng: np.random.Generator) -> list[str]:
    """Names for a performance in random order: gestures of the language, as different as there are, and idle movements."""
    rows = [rng.permutation(language) for _ in range(-(-gestures // len(language)))]
    chosen = [str(name) for row in rows for name in row][:gestures]
    return [str(name) for name in rng.permutation([*chosen, *[GARBAGE] * idle])]
