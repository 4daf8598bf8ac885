"""Allographs: the different ways in which one gesture is made, found by splitting its examples in two while that pays."""

import numpy as np


def allographs(
    x: np.ndarray, labels: np.ndarray, gain: float, least: int = 5, most: int = 6
) -> tuple[np.ndarray, np.ndarray]:
    """Model number of each sequence (N,) and class of each model (M,), models sorted by class.

    x (N, T, D) are described trajectories, labels (N,) in 0..C-1. Examples of a class are split by 2-means if that explains at least
    ``gain`` of their scatter and leaves ``least`` on either side; halves are split again, up to ``most`` models a class.
    """
    model, classes = np.zeros(len(labels), int), []
    for c in range(labels.max() + 1):
        members = np.flatnonzero(labels == c)
        groups = _split(x[members].reshape(len(members), -1), gain, least, most)
        for number, group in enumerate(groups):
            model[members[group]] = len(classes) + number
        classes += [c] * len(groups)
    return model, np.array(classes)


def _split(z, gain, least, most):
    done, waiting = [], [np.arange(len(z))]
    while waiting:
        group = waiting.pop(0)
        halves = _halves(z[group]) if len(done) + len(waiting) + 1 < most and len(group) >= 2 * least else None
        if halves is not None and min(halves.sum(), (~halves).sum()) >= least and _explained(z[group], halves) >= gain:
            waiting += [group[halves], group[~halves]]
        else:
            done.append(group)
    return done


def _explained(z, half):
    scatter = ((z - z.mean(axis=0)) ** 2).sum()
    within = sum(((z[h] - z[h].mean(axis=0)) ** 2).sum() for h in (half, ~half))
    return 1.0 - within / max(scatter, 1e-12)


def _halves(z, rounds=30):
    """2-means, started at the two sides of the longest principal axis: deterministic."""
    centred = z - z.mean(axis=0)
    rng = np.random.default_rng(0)
    axis = rng.normal(size=z.shape[1])
    for _ in range(8):
        axis = centred.T @ (centred @ axis)
        axis /= max(np.linalg.norm(axis), 1e-300)
    half = centred @ axis > 0
    for _ in range(rounds):
        if half.all() or not half.any():
            return None
        a, b = z[half].mean(axis=0), z[~half].mean(axis=0)
        new = z @ (a - b) > 0.5 * (a @ a - b @ b)
        if np.array_equal(new, half):
            break
        half = new
    return None if half.all() or not half.any() else half
