"""Is it a gesture at all? A threshold on likelihood beside a garbage model, calibrated on held-out examples (paper, after eq. 14)."""

from dataclasses import dataclass

import numpy as np

from vipr.systems.gestures.hmm import HmmBank, score
from vipr.systems.gestures.training import HmmSpec, train

STATES, FOLDS, LEAST = 6, 3, 6
SPEC = HmmSpec(STATES, 1, "diag", floor=2e-2, prior=5.0, baum_welch=3)


@dataclass(frozen=True, eq=False)
class Gate:
    """Likelihood models of each class and of everything together, and the least margin of a gesture."""

    gestures: HmmBank  # (C models)
    anything: HmmBank  # (1 or 2 models): all gestures together, non-gestures if there were any
    threshold: float  # nats a point

    def margin(self, x: np.ndarray, label: np.ndarray) -> np.ndarray:
        """(N,) log likelihood per point of x (N, T, D) under its label's model above the best garbage model's [nats]."""
        own = score(self.gestures, x)[np.arange(len(x)), label]
        return (own - score(self.anything, x).max(axis=1)) / x.shape[1]


def fit_gate(x: np.ndarray, labels: np.ndarray, garbage: int, false_rejection: float, seed: int) -> Gate:
    """Models from all of x (N, T, D); the threshold such that ``false_rejection`` of held-out gestures fall below it.

    ``garbage`` is the class of non-gestures, -1 if there is none. With fewer than a handful of examples held out, nothing can be
    calibrated and the threshold is lowered by the spread seen in training.
    """
    fold = _folds(labels, seed)
    margins = []
    for k in range(FOLDS):
        held = (fold == k) & (labels != garbage)
        if held.any() and len(np.unique(labels[fold != k])) == labels.max() + 1:
            margins.append(_models(x[fold != k], labels[fold != k], garbage).margin(x[held], labels[held]))
    gate = _models(x, labels, garbage)
    if sum(map(len, margins)) >= LEAST:
        held_out = np.concatenate(margins)
        threshold = np.quantile(held_out, false_rejection)
        if len(held_out) * false_rejection < 5:  # too few to see the quantile: extend the spread below the median
            median = np.median(held_out)
            threshold = min(threshold, median - 4.0 * (median - np.quantile(held_out, 0.16)))
    else:
        own = gate.margin(x[labels != garbage], labels[labels != garbage])
        threshold = own.min() - 3.0 * (np.ptp(own) + abs(own.min()) + 1.0)
    return Gate(gate.gestures, gate.anything, float(threshold))


def _models(x, labels, garbage):
    lengths = np.full(len(x), x.shape[1])
    gestures = train(x, lengths, labels, SPEC)
    kind = (labels == garbage).astype(int) if garbage >= 0 and (labels != garbage).any() else np.zeros(len(x), int)
    return Gate(gestures, train(x, lengths, kind, SPEC), 0.0)


def _folds(labels, seed):
    """Fold of each example, each class spread evenly."""
    fold = np.zeros(len(labels), int)
    rng = np.random.default_rng(seed)
    for c in np.unique(labels):
        members = np.flatnonzero(labels == c)
        fold[members] = (rng.permutation(len(members)) + rng.integers(FOLDS)) % FOLDS
    return fold
