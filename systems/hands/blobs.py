"""Geometry of the pixels of a region: its ends, the head in it, its shares. Pixels of the labels."""

import numpy as np

from vipr.systems.compiled import compiled


def pixels_of(labels: np.ndarray, row: int) -> np.ndarray:
    """(n, 2) float x, y of the pixels of region ``row``."""
    return _pixels(labels, row + 1)


@compiled
def _pixels(labels, label):
    n, first, last = 0, 0, -1
    for y in range(labels.shape[0]):
        here = 0
        for x in range(labels.shape[1]):
            here += labels[y, x] == label
        if here:
            first, last = (first if n else y), y
            n += here
    out = np.empty((n, 2))
    n = 0
    for y in range(first, last + 1):
        for x in range(labels.shape[1]):
            if labels[y, x] == label:
                out[n, 0], out[n, 1] = x, y
                n += 1
    return out


@compiled
def ends(p):
    """The two ends (2,) of a blob p (n, 2), its length and its mean width [px]."""
    a = p[_farthest(p, p[:, 0].sum() / len(p), p[:, 1].sum() / len(p))]
    b = p[_farthest(p, a[0], a[1])]
    length = np.hypot(a[0] - b[0], a[1] - b[1]) + 1.0
    return a, b, length, len(p) / length


@compiled
def _farthest(p, x, y):
    """Index of the first of the points p (n, 2) that are farthest from x, y."""
    best, most = 0, -1.0
    for k in range(len(p)):
        away = (p[k, 0] - x) ** 2 + (p[k, 1] - y) ** 2
        if away > most:
            best, most = k, away
    return best


@compiled
def middle_about(p, x, y, reach):
    """Centre (2,) of the points p (n, 2) within reach of x, y, and their number."""
    across, down, n = 0.0, 0.0, 0
    for k in range(len(p)):
        if (p[k, 0] - x) ** 2 + (p[k, 1] - y) ** 2 < reach**2:
            across, down, n = across + p[k, 0], down + p[k, 1], n + 1
    return np.array([across / n, down / n]), float(n)


def head_in(p: np.ndarray, centre: np.ndarray, radius: float, rounds: int = 3) -> tuple[np.ndarray, float]:
    """Centre (2,) and pixels of the head in a blob p (n, 2) that holds more (neck, arms, wall): an ellipse that climbs to where it is full.

    ``radius`` is half the width of the head; it is 1.3 times as high.
    """
    c, n = np.asarray(centre, float), 0
    for _ in range(rounds):
        inside = p[(((p - c) / (1.15 * radius, 1.5 * radius)) ** 2).sum(1) < 1.0]
        n = len(inside)
        if n == 0:
            break
        c = inside.mean(0)
    return c, float(n)


def split(p: np.ndarray, centres: np.ndarray, radii: np.ndarray, rounds: int = 3) -> tuple[np.ndarray, np.ndarray]:
    """Share the pixels p (n, 2) of a merged region between parts expected at centres (k, 2) with radii (k,).

    Returns the parts' centres (k, 2) and pixel counts (k,); a part without pixels keeps its expected centre. Pixels far from every part
    (a bare arm) belong to none.
    """
    c = centres.astype(float).copy()
    count = np.zeros(len(c))
    for _ in range(rounds):
        d = np.sqrt(((p[:, None] - c[None]) ** 2).sum(2)) / radii
        nearest = d.argmin(1)
        near = d[np.arange(len(p)), nearest] < 1.6
        for k in range(len(c)):
            mine = p[near & (nearest == k)]
            count[k] = len(mine)
            if len(mine):
                c[k] = 0.5 * c[k] + 0.5 * mine.mean(0)
    return c, count
