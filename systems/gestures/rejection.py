"""Is it a gesture at all? A threshold on likelihood beside a garbage model, calibrated on held-out examples (paper, after eq. 14).

The models do not know how long a movement took; where time is known, it speaks for the gestures whose examples took as long, and must be
about what they took.
"""

from dataclasses import dataclass

import numpy as np
from scipy.special import ndtri

from vipr.systems.gestures.hmm import HmmBank, score
from vipr.systems.gestures.training import HmmSpec, train
from vipr.systems.gestures.trajectories import Distortion, Stream, describe, distort, fill_up

STATES, FOLDS, LEAST = 6, 3, 6
SPEC = HmmSpec(STATES, 1, "diag", floor=3e-2, prior=5.0, segmental=4, baum_welch=3)
FALSE_ACCEPTANCE = 0.005  # of held-out non-gestures: the threshold need not be higher than that takes
ENOUGH = 16  # examples of a class; with fewer, distorted copies make up the number
SHOWN = 5  # examples beyond a quantile, with which it is taken as it is
FURTHEST = 6.0  # spreads of the margins below their median, and no threshold is lower
SPREADS, LEAST_SPREAD = 3.0, 0.1  # a duration may be so many spreads off, and none is less than this (log s)
LEAST_KNOWN = 0.25  # share of a movement's points
FAR_OFF = 0.5  # log s; examples that are further off, such as parts of a gesture, widen the spread no more than this


@dataclass(frozen=True, eq=False)
class Gate:
    """Likelihood models of each class and of everything together, and the least margin of a gesture."""

    gestures: HmmBank  # one model a class
    anything: HmmBank  # all gestures together, as a chain and as one cloud; the same of non-gestures if there were any
    threshold: float  # nats a point

    def margin(self, x: np.ndarray, label: np.ndarray) -> np.ndarray:
        """(N,) log likelihood per point of x (N, T, D) under its label's model above the best garbage model's [nats]."""
        own = np.empty(len(x))
        for c in np.unique(label):
            own[label == c] = score(self.gestures[[c]], x[label == c])[:, 0]
        return _per_point(own - score(self.anything, x).max(axis=1), x)

    def best_margin(self, x: np.ndarray, garbage: int) -> np.ndarray:
        """(N,) margin under the best gesture's model, whichever that is."""
        own = np.delete(score(self.gestures, x), garbage, axis=1).max(axis=1)
        return _per_point(own - score(self.anything, x).max(axis=1), x)


def _per_point(margin, x):
    """(N,) margins per point of x (N, T, D) that is not missing; -inf if too few are to tell."""
    known = (~np.isnan(x).any(axis=2)).sum(axis=1)
    return np.where(known < LEAST_KNOWN * x.shape[1], -np.inf, margin / np.maximum(known, 1))


@dataclass(frozen=True, eq=False)
class Pace:
    """How long each class takes: middle and spread of the logarithm of its duration."""

    middle: np.ndarray  # (C,) log s
    spread: np.ndarray  # (C,)

    def log_density(self, seconds: np.ndarray) -> np.ndarray:
        """(N, C) of the logarithms of durations (N,) under each class, but for a constant."""
        off = (np.log(seconds)[:, None] - self.middle) / self.spread
        return -0.5 * off**2 - np.log(self.spread)

    def usual(self, seconds: np.ndarray, label: np.ndarray) -> np.ndarray:
        """(N,) bool: whether movements of these durations (N,) may be of the classes ``label`` (N,)."""
        return np.abs(np.log(seconds) - self.middle[label]) <= SPREADS * self.spread[label]


def fit_pace(seconds: np.ndarray, labels: np.ndarray) -> Pace:
    """Of examples' durations (N,) and labels (N,) in 0..C-1; a class of few examples leans on the spread of all others."""
    log, count = np.log(seconds), np.bincount(labels)
    middle = np.array([np.median(log[labels == c]) for c in range(len(count))])
    off = np.minimum(np.abs(log - middle[labels]), FAR_OFF)
    pooled = np.mean(off**2)
    spread = np.sqrt((np.bincount(labels, off**2) + ENOUGH * pooled) / (count + ENOUGH))
    return Pace(middle, np.maximum(spread, LEAST_SPREAD))


def fit_gate(
    points: np.ndarray, stream: Stream, labels: np.ndarray, garbage: int, false_rejection: float, seed: int
) -> Gate:
    """Models of resampled points (N, T, d); the threshold such that ``false_rejection`` of held-out gestures fall below it.

    ``garbage`` is the class of non-gestures, -1 if there is none. A quantile that the held-out examples are too few to show is taken from
    the spread of their lower half, as if it were normal; none lies further than ``FURTHEST`` such spreads below the median, where there is
    only what was mistaken for the gesture. With examples of non-gestures, the threshold is lowered as far as they permit.
    """
    fold = _folds(labels, seed)
    margins, foreign = [], []
    for k in range(FOLDS):
        held, others = (fold == k) & (labels != garbage), (fold == k) & (labels == garbage)
        if held.any() and len(np.unique(labels[fold != k])) == labels.max() + 1:
            gate = _models(points[fold != k], stream, labels[fold != k], garbage, seed)
            margins.append(gate.margin(describe(points[held], stream), labels[held]))
            if others.any():
                foreign.append(gate.best_margin(describe(points[others], stream), garbage))
    gate = _models(points, stream, labels, garbage, seed)
    if sum(map(len, margins)) < LEAST:  # nothing to hold out
        own = gate.margin(describe(points[labels != garbage], stream), labels[labels != garbage])
        return Gate(gate.gestures, gate.anything, float(own.min() - np.ptp(own) - 1.0))
    held_out = np.concatenate(margins)
    median = np.median(held_out)
    sigma = (median - np.quantile(held_out, 0.16)) / -ndtri(0.16)
    enough = len(held_out) * false_rejection >= SHOWN
    threshold = np.quantile(held_out, false_rejection) if enough else median + ndtri(false_rejection) * sigma
    threshold = max(threshold, median - FURTHEST * sigma)
    if sum(map(len, foreign)) >= 10 * LEAST:
        threshold = min(threshold, np.quantile(np.concatenate(foreign), 1.0 - FALSE_ACCEPTANCE))
    return Gate(gate.gestures, gate.anything, float(threshold))


def _models(points, stream, labels, garbage, seed):
    source = fill_up(labels, ENOUGH)
    if len(source):
        copies = distort(points[source], stream, np.random.default_rng([seed, 2]), Distortion())
        points, labels = np.concatenate([points, copies]), np.concatenate([labels, labels[source]])
    if stream.scale == "none":  # nobody's unit is quite another's
        copies = distort(points, stream, np.random.default_rng([seed, 4]), Distortion(0.0, 0.0, 0.0, 0.0))
        points, labels = np.concatenate([points, copies]), np.tile(labels, 2)
    x = describe(points, stream)
    lengths = np.full(len(x), x.shape[1])
    gestures = train(x, lengths, labels, SPEC)
    kind = np.zeros(len(x), int)
    if garbage >= 0 and (labels != garbage).any():
        kind = (labels == garbage).astype(int)
    kinds = kind.max() + 1
    twice = np.concatenate([kind, kind + kinds])
    states = np.repeat([STATES, 1], kinds)
    return Gate(gestures, train(np.concatenate([x, x]), np.tile(lengths, 2), twice, SPEC, states), 0.0)


def _folds(labels, seed):
    """Fold of each example, each class spread evenly."""
    fold = np.zeros(len(labels), int)
    rng = np.random.default_rng(seed)
    for c in np.unique(labels):
        members = np.flatnonzero(labels == c)
        fold[members] = (rng.permutation(len(members)) + rng.integers(FOLDS)) % FOLDS
    return fold
