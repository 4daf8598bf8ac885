"""Table II again: 26 Graffiti letters of five writers, drawn in the air, filmed, tracked, recognised (paper, II-A.4)."""

from functools import partial
from itertools import product

import numpy as np

from vipr.scenarios.experiments.evaluation import Evaluation, cross_validate, train_and_test
from vipr.scenarios.experiments.films import HOLD, RATE, Reel, Sitting
from vipr.scenarios.experiments.writers import Writer, draw, graffiti
from vipr.systems.gestures.classifier import GestureClassifier
from vipr.systems.gestures.segmentation import segment
from vipr.systems.gestures.tables import GestureTable
from vipr.systems.gestures.trajectories import Trajectory, smooth
from vipr.systems.gestures.writing_hand import writing_hand

SEQUENCES, WRITERS = 2230, 5  # as in the paper
FACE = 13.0  # px, a face at the camera's distance
SMOOTHING = 3  # passes over the track at 25 Hz: a hand of some kilograms does not tremble with the camera's noise
STATES = 8  # of all models; the paper's have 4
MIXTURES = 2  # Gaussians a state of the paper's models, of which a letter has as many as it has forms
GAPS = 0.3  # share of the letters that this program's models are sharpened on for which the tracker may lose the hand for a while
STILL = 10  # frames that the hand is taken to stay where a film ends: what still moves there is a movement too


def sittings(seed: int, camera: str, rounds: int | None = None) -> list[Sitting]:
    """What the five writers are to draw, a sitting an alphabet: 2230 letters, or ``rounds`` alphabets a writer."""
    from vipr.scenarios.people.motion import HandPaths, plane_path

    letters = graffiti()
    wanted = SEQUENCES // WRITERS if rounds is None else rounds * len(letters)
    planned = []
    for number, w in product(range(-(-wanted // len(letters))), range(WRITERS)):
        writer = Writer.drawn(100 * seed + w)
        rng = np.random.default_rng([seed, w, number])
        names = [str(a) for a in rng.permutation(list(letters))][: wanted - number * len(letters)]
        paths, bounds = [], []
        for name in names:
            drawing = draw(writer, name, letters[name], rng)
            held = np.concatenate([drawing, np.repeat(drawing[-1:], HOLD, 0)])
            paths.append(HandPaths(right=plane_path(held, size=writer.size, centre=(-0.24, -0.2))))
            bounds.append((0, len(drawing) - 1))
        name = f"graffiti-{camera}-{seed}-{w}-{number}"
        planned.append(Sitting(name, f"writer {w + 1}", paths, names, bounds, camera, 1000 * seed + w))
    return planned


def drawings(reels: list[Reel]) -> GestureTable:
    """The letters as the camera saw them: positions of the hand that writes in pixels, y up, smoothed in time; s."""
    trajectories = [_drawing(*film) for r in reels for film in zip(r.positions, r.seen, r.bounds / RATE, strict=True)]
    labels = np.concatenate([r.labels for r in reels])
    writers = np.concatenate([np.repeat(r.person, len(r.labels)) for r in reels])
    return GestureTable(np.arange(len(labels)).astype(str), labels, writers, trajectories)


def _drawing(positions, seen, bounds) -> Trajectory:
    """A film's letter, from the start of the first to the end of the last of its movements, cut at pauses.

    Where none was cut (the hand was lost), what the tracker said between its bounds stands for it.
    """
    hand = FACE * writing_hand(np.where(seen[..., None], positions, np.nan) / FACE)
    times, (first, last) = np.arange(len(hand)) / RATE, bounds
    later = times[-1] + np.arange(1, STILL + 1) / RATE
    stayed = np.concatenate([hand, np.repeat(hand[-1:], STILL, axis=0)])
    movements = segment(np.r_[times, later], stayed / FACE)
    found = [m for m in movements if m.times[0] < last and m.times[-1] > first]
    inside = (times > first - 1e-6) & (times < last + 1e-6)
    if found:
        inside = (times > found[0].times[0] - 1e-6) & (times < found[-1].times[-1] + 1e-6)
    return Trajectory(_smooth(hand[inside] * (1.0, -1.0)), times[inside])


def _smooth(points):
    """Each stretch (T, 2) in which the hand is seen by itself; NaN in between."""
    unseen = np.isnan(points).any(axis=1)
    cuts = np.flatnonzero(np.diff(unseen)) + 1
    return np.concatenate([smooth(run[None], SMOOTHING)[0] for run in np.split(points, cuts)])


def halves(table: GestureTable, seed: int) -> np.ndarray:
    """(N,) bool: half of each writer's examples of each letter, for training; the rest is the test.

    Of an odd number, the one left over goes to training for half of the letters, drawn by chance.
    """
    rng, chosen = np.random.default_rng([seed, 3]), np.zeros(len(table), bool)
    names, group = np.unique(
        [f"{w}|{a}" for w, a in zip(table.writers, table.labels, strict=True)], return_inverse=True
    )
    odd = rng.permutation(len(names)) % 2
    for g in range(len(names)):
        members = rng.permutation(np.flatnonzero(group == g))
        chosen[members[: (len(members) + odd[g]) // 2]] = True
    return chosen


ROWS = {  # of Table II, and this program's own models
    "position": f"{STATES} states, image position",
    "velocity": f"{STATES} states, image velocity",
    "combined": f"{STATES} states, position and velocity",
    "default": "default recogniser",
}


def models(row: str, seed: int) -> GestureClassifier:
    """The untrained models of a row: trained by likelihood alone with full covariances, or this program's own."""
    how = dict(gaps=GAPS) if row == "default" else dict(discriminative=False, covariance="full", mixtures=MIXTURES)
    return GestureClassifier(row, states=STATES, seed=seed, **how)


def table_two(table: GestureTable, seed: int, tick=lambda share: None) -> dict[str, dict[str, Evaluation]]:
    """For each row: ``known`` writers (half against half) and ``unseen`` ones (each of the five held out in turn)."""
    train = halves(table, seed)
    writer = np.unique(table.writers, return_inverse=True)[1]
    results = {}
    part = 0.5 / len(ROWS)
    for n, row in enumerate(ROWS):
        make, first = partial(models, row, seed), _stage(tick, 2 * n * part, part)
        known = train_and_test(make, table.choose(train), table.choose(~train), first)
        unseen = cross_validate(make, table, writer, _stage(tick, (2 * n + 1) * part, part))
        results[row] = {"known": known, "unseen": unseen}
    return results


def by_writer(result: Evaluation, writers: np.ndarray) -> dict[str, float]:
    """Percent right of each writer; ``writers`` (N,) of the sequences tested."""
    return {str(w): result.accuracy(writers == w) for w in np.unique(writers)}


def _stage(tick, start, part):
    return lambda share: tick(start + part * share)
