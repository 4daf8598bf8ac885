"""Recognition rates of a classifier on a table of trajectories: splits by writer or at random, or a second table."""

import time
from dataclasses import dataclass, field

import numpy as np

from vipr.systems.errors import InputError
from vipr.systems.gestures.classifier import GestureClassifier
from vipr.systems.gestures.tables import GestureTable

PAPER = ("position", "velocity", "combined")


def classifier(
    models: str = "default", states: int | str | None = None, garbage: str | None = None, seed: int = 0
) -> GestureClassifier:
    """Untrained. position, velocity, combined: the models of the paper's Table II, 4 states, full covariance, one a gesture."""
    if models in PAPER:
        plain = dict(discriminative=False, allograph_gain=None, covariance="full")
        return GestureClassifier(models, states=states or 4, garbage=garbage, seed=seed, **plain)
    return GestureClassifier(models, states=states or 8, garbage=garbage, seed=seed)


@dataclass
class Evaluation:
    """What a classifier reached; accuracies in percent."""

    truth: np.ndarray  # (N,) str, of all tested sequences
    answer: np.ndarray  # (N,) str
    probability: np.ndarray  # (N,)
    rejected: np.ndarray  # (N,) bool: would be refused by the recogniser; counts as answered here
    fold: np.ndarray  # (N,) int
    train_seconds: list[float] = field(default_factory=list)
    test_seconds: list[float] = field(default_factory=list)
    trained_on: list[int] = field(default_factory=list)

    def accuracy(self, chosen=slice(None)) -> float:
        """Percent right of the chosen sequences."""
        right = self.truth[chosen] == self.answer[chosen]
        return 100.0 * float(right.mean()) if len(right) else float("nan")

    def summary(self) -> dict:
        """Plain values for JSON."""
        folds = range(len(self.trained_on))
        n = len(self.truth)
        return {
            "accuracy_percent": round(self.accuracy(), 3),
            "sequences": n,
            "classes": len(np.unique(self.truth)),
            "rejected_percent": round(100.0 * float(self.rejected.mean()), 3),
            "folds": [
                {
                    "accuracy_percent": round(self.accuracy(self.fold == k), 3),
                    "trained_on": self.trained_on[k],
                    "tested_on": int((self.fold == k).sum()),
                    "train_s": round(self.train_seconds[k], 2),
                }
                for k in folds
            ],
            "per_class": {
                str(c): {
                    "accuracy_percent": round(self.accuracy(self.truth == c), 3),
                    "sequences": int((self.truth == c).sum()),
                }
                for c in np.unique(self.truth)
            },
            "ms_per_sequence": round(1000.0 * sum(self.test_seconds) / n, 3),
            "train_ms_per_sequence": round(1000.0 * sum(self.train_seconds) / max(sum(self.trained_on), 1), 3),
        }


def confusion(truth: np.ndarray, answer: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """(C, C) counts, row the truth, column the answer, and the labels (C,)."""
    labels = np.unique(np.concatenate([truth, answer]))
    counts = np.zeros((len(labels), len(labels)), int)
    np.add.at(counts, (np.searchsorted(labels, truth), np.searchsorted(labels, answer)), 1)
    return counts, labels


def select(
    table: GestureTable, min_per_class: int = 0, max_per_writer_class: int = 0, classes: list[str] | None = None
) -> GestureTable:
    """Labelled rows of the classes with enough sequences, the first few of each writer and class in the table's order; 0: no limit."""
    keep = table.labels != ""
    if classes:
        missing = sorted(set(classes) - set(table.labels))
        if missing:
            raise InputError(
                f"--classes: the table has no {', '.join(missing)}; it has {', '.join(np.unique(table.labels[keep]))}"
            )
        keep &= np.isin(table.labels, classes)
    names, counts = np.unique(table.labels[keep], return_counts=True)
    keep &= np.isin(table.labels, names[counts >= min_per_class])
    if max_per_writer_class:
        seen: dict[tuple, int] = {}
        for i in np.flatnonzero(keep):
            key = (table.labels[i], table.writers[i])
            seen[key] = seen.get(key, 0) + 1
            keep[i] = seen[key] <= max_per_writer_class
    if not keep.any():
        raise InputError("the table has no labelled sequence that meets the conditions")
    return table.choose(keep)


def split(table: GestureTable, how: str, seed: int) -> np.ndarray:
    """(N,) fold of each sequence for ``writer:K``, ``writer:all`` (each writer a fold) or ``random:K``."""
    kind, _, count = how.partition(":")
    if kind not in ("writer", "random") or not (count.isdigit() or (kind == "writer" and count == "all")):
        raise InputError(f"--split is writer:K, writer:all or random:K, got {how!r}")
    rng = np.random.default_rng(seed)
    if kind == "random":
        folds = int(count)
        fold = np.zeros(len(table), int)
        for c in np.unique(table.labels):
            members = np.flatnonzero(table.labels == c)
            fold[members] = (rng.permutation(len(members)) + rng.integers(folds if folds else 1)) % max(folds, 1)
        available = len(table)
    else:
        writers, number = np.unique(table.writers, return_inverse=True)
        available = len(writers)
        folds = available if count == "all" else int(count)
        place = rng.permutation(available) % max(folds, 1)
        fold = place[number]
    if not 2 <= folds <= available:
        raise InputError(f"--split {how}: needs from 2 to {available} folds ({kind}s to hold out)")
    return fold


def cross_validate(make, table: GestureTable, fold: np.ndarray, tick=lambda share: None) -> Evaluation:
    """Train ``make()`` on all folds but one and test on that, for each; a label never trained on counts as wrong."""
    numbers = np.unique(fold)
    result = _empty(len(table))
    for n, k in enumerate(numbers):
        held = fold == k
        _run(
            make(),
            table.choose(~held),
            table.choose(held),
            result,
            np.flatnonzero(held),
            n,
            lambda s, n=n: tick((n + s) / len(numbers)),
        )
    return result


def train_and_test(make, train: GestureTable, test: GestureTable, tick=lambda share: None) -> Evaluation:
    """Train on one table, test on another."""
    result = _empty(len(test))
    _run(make(), train, test, result, np.arange(len(test)), 0, tick)
    return result


def _empty(n):
    return Evaluation(np.full(n, "", object), np.full(n, "", object), np.zeros(n), np.zeros(n, bool), np.zeros(n, int))


def _run(model: GestureClassifier, train, test, result, rows, number, tick):
    start = time.perf_counter()
    model.fit(train.trajectories, train.labels, tick=tick)
    trained = time.perf_counter()
    label, probability, rejected = model.recognise(test.trajectories)
    result.test_seconds.append(time.perf_counter() - trained)
    result.train_seconds.append(trained - start)
    result.trained_on.append(len(train))
    result.truth[rows], result.answer[rows] = test.labels, label
    result.probability[rows], result.rejected[rows], result.fold[rows] = probability, rejected, number
