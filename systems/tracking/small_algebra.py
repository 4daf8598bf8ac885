"""Compiled linear algebra of a few unknowns, and order statistics: calls of numpy's would cost more than the sums."""

import numpy as np

from vipr.systems.compiled import compiled


@compiled
def solve(H, g):
    """x (n,) of H x = g for a small symmetric positive H (n, n) by Cholesky's method; 0 along what H says nothing of.

    Rows are scaled first: metres and radians stand side by side.
    """
    n = len(g)
    scale = np.empty(n)
    L = np.zeros((n, n))
    x = np.zeros(n)
    for i in range(n):
        scale[i] = 1.0 / np.sqrt(H[i, i]) if H[i, i] > 0.0 else 0.0
    for j in range(n):
        pivot = H[j, j] * scale[j] * scale[j]
        for k in range(j):
            pivot -= L[j, k] * L[j, k]
        if not pivot > 1e-14:
            continue  # L[j, j] stays 0
        L[j, j] = np.sqrt(pivot)
        for i in range(j + 1, n):
            s = H[i, j] * scale[i] * scale[j]
            for k in range(j):
                s -= L[i, k] * L[j, k]
            L[i, j] = s / L[j, j]
    for i in range(n):
        if L[i, i] > 0.0:
            s = g[i] * scale[i]
            for k in range(i):
                s -= L[i, k] * x[k]
            x[i] = s / L[i, i]
    for i in range(n - 1, -1, -1):
        if L[i, i] > 0.0:
            s = x[i]
            for k in range(i + 1, n):
                s -= L[k, i] * x[k]
            x[i] = s / L[i, i]
    return x * scale


@compiled
def invert(H):
    """Inverse (n, n) of a small symmetric positive H."""
    n = len(H)
    inverse = np.empty((n, n))
    unit = np.zeros(n)
    for i in range(n):
        unit[i] = 1.0
        inverse[i] = solve(H, unit)
        unit[i] = 0.0
    return inverse


@compiled
def kth_smallest(values, k):
    """The k-th smallest, from 0, of values (n,): Hoare's selection."""
    a = values.copy()
    low, high = 0, len(a) - 1
    while low < high:
        pivot = a[k]
        i, j = low, high
        while i <= j:
            while a[i] < pivot:
                i += 1
            while a[j] > pivot:
                j -= 1
            if i <= j:
                a[i], a[j] = a[j], a[i]
                i += 1
                j -= 1
        if j < k:
            low = i
        if k < i:
            high = j
    return a[k]


@compiled
def dot6(a, b):
    """Product of two vectors of six."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2] + a[3] * b[3] + a[4] * b[4] + a[5] * b[5]


@compiled
def mirror(H):
    """Copies what is below the diagonal of H (6, 6) to above it."""
    for i in range(6):
        for j in range(i):
            H[j, i] = H[i, j]
