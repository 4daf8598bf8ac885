"""Gaps between convex shapes, many pairs at once, compiled.

A shape (see ``shapes``) is given by its pose, the half lengths of its core, the radius of its disc and the radius that rounds it. The gap
is a *certified lower bound* of the distance: for any unit vector n, the slab between the two support planes across n is free, so the
widest slab found is never wider than the distance. Candidates for n are the directions that alternating projections between the cores run
through (exact in the limit), the shapes' own axes (exact where a face is nearest) and the products of their axes (two edges). Overlapping
shapes have a negative gap.
"""

import numpy as np

from vipr.systems.compiled import compiled

PROJECTIONS = 8  # alternating projections; each yields one direction


@compiled
def _nearest(X, half, disc, p, foot):
    """Writes the core's point nearest to p (3,) to foot (3,)."""
    d0, d1, d2 = p[0] - X[0, 3], p[1] - X[1, 3], p[2] - X[2, 3]
    a = X[0, 0] * d0 + X[1, 0] * d1 + X[2, 0] * d2
    b = X[0, 1] * d0 + X[1, 1] * d1 + X[2, 1] * d2
    c = X[0, 2] * d0 + X[1, 2] * d1 + X[2, 2] * d2
    if disc > 0.0:
        out = np.sqrt(a * a + b * b)
        if out > disc:
            a, b = a * disc / out, b * disc / out
    else:
        a, b = min(max(a, -half[0]), half[0]), min(max(b, -half[1]), half[1])
    c = min(max(c, -half[2]), half[2])
    for i in range(3):
        foot[i] = X[i, 3] + X[i, 0] * a + X[i, 1] * b + X[i, 2] * c


@compiled
def _support(X, half, disc, radius, n0, n1, n2):
    """How far the shape extends from its middle along the unit vector n."""
    a = abs(X[0, 0] * n0 + X[1, 0] * n1 + X[2, 0] * n2)
    b = abs(X[0, 1] * n0 + X[1, 1] * n1 + X[2, 1] * n2)
    c = abs(X[0, 2] * n0 + X[1, 2] * n1 + X[2, 2] * n2)
    return half[0] * a + half[1] * b + half[2] * c + disc * np.sqrt(a * a + b * b) + radius


@compiled
def _slab(Xa, half_a, disc_a, radius_a, Xb, half_b, disc_b, radius_b, n0, n1, n2):
    """Width of the free slab across n, which need not be a unit vector; -infinity for n = 0."""
    size = np.sqrt(n0 * n0 + n1 * n1 + n2 * n2)
    if size < 1e-9:
        return -np.inf
    n0, n1, n2 = n0 / size, n1 / size, n2 / size
    along = abs(n0 * (Xa[0, 3] - Xb[0, 3]) + n1 * (Xa[1, 3] - Xb[1, 3]) + n2 * (Xa[2, 3] - Xb[2, 3]))
    of_a = _support(Xa, half_a, disc_a, radius_a, n0, n1, n2)
    return along - of_a - _support(Xb, half_b, disc_b, radius_b, n0, n1, n2)


@compiled
def _gap(Xa, half_a, disc_a, radius_a, Xb, half_b, disc_b, radius_b, p, foot):
    """The gap of one pair; p and foot (3,) are scratch."""
    best = -np.inf
    for i in range(3):
        p[i] = Xa[i, 3]
    for _ in range(PROJECTIONS):
        _nearest(Xb, half_b, disc_b, p, foot)
        _nearest(Xa, half_a, disc_a, foot, p)
        n0, n1, n2 = p[0] - foot[0], p[1] - foot[1], p[2] - foot[2]
        wide = _slab(Xa, half_a, disc_a, radius_a, Xb, half_b, disc_b, radius_b, n0, n1, n2)
        best = max(best, wide)
        if wide >= np.sqrt(n0 * n0 + n1 * n1 + n2 * n2) - radius_a - radius_b - 1e-9:
            return best  # the slab is as wide as the points are apart: that is the distance
    for i in range(3):
        a0, a1, a2 = Xa[0, i], Xa[1, i], Xa[2, i]
        best = max(best, _slab(Xa, half_a, disc_a, radius_a, Xb, half_b, disc_b, radius_b, a0, a1, a2))
        b0, b1, b2 = Xb[0, i], Xb[1, i], Xb[2, i]
        best = max(best, _slab(Xa, half_a, disc_a, radius_a, Xb, half_b, disc_b, radius_b, b0, b1, b2))
        for j in range(3):
            b0, b1, b2 = Xb[0, j], Xb[1, j], Xb[2, j]
            n0, n1, n2 = a1 * b2 - a2 * b1, a2 * b0 - a0 * b2, a0 * b1 - a1 * b0
            best = max(best, _slab(Xa, half_a, disc_a, radius_a, Xb, half_b, disc_b, radius_b, n0, n1, n2))
    return best


@compiled
def pair_gaps(X, half, disc, radius, first, second):
    """(N, P) gaps [m] of the pairs first (P,), second (P,) of S shapes in N arrangements X (N, S, 4, 4); half (S, 3), disc, radius (S,)."""
    gaps = np.empty((len(X), len(first)))
    p, foot = np.empty(3), np.empty(3)
    for n in range(len(X)):
        for k in range(len(first)):
            i, j = first[k], second[k]
            gaps[n, k] = _gap(X[n, i], half[i], disc[i], radius[i], X[n, j], half[j], disc[j], radius[j], p, foot)
    return gaps


@compiled
def smallest_gaps(X, half, disc, radius, first, second):
    """The smallest gap (N,) [m] of all pairs in each arrangement and which pair (N,) it is; pairs that are surely wider are passed over."""
    gaps, pairs = np.full(len(X), np.inf), np.zeros(len(X), np.int64)
    p, foot = np.empty(3), np.empty(3)
    for n in range(len(X)):
        for k in range(len(first)):
            i, j = first[k], second[k]
            for axis in range(3):
                p[axis] = X[n, i, axis, 3]
            _nearest(X[n, j], half[j], disc[j], p, foot)
            away = np.sqrt((p[0] - foot[0]) ** 2 + (p[1] - foot[1]) ** 2 + (p[2] - foot[2]) ** 2) - radius[j]
            flat = max(np.sqrt(half[i, 0] ** 2 + half[i, 1] ** 2), disc[i])
            if away - np.sqrt(flat * flat + half[i, 2] ** 2) - radius[i] > max(gaps[n], 0.0):
                continue
            wide = _gap(X[n, i], half[i], disc[i], radius[i], X[n, j], half[j], disc[j], radius[j], p, foot)
            if wide < gaps[n]:
                gaps[n], pairs[n] = wide, k
    return gaps, pairs
