"""Density of skin pixels, threshold and connected components (section II-A.1, Fig. 2)."""

import cv2
import numpy as np

from vipr.systems.compiled import compiled
from vipr.systems.skin.working_image import odd, unit

NEIGHBOURHOOD = 3.4  # px at 160 x 120: side of the neighbourhood
DENSE = 120  # of 255: density above which a pixel is of a region


def density(skin: np.ndarray, size: int) -> np.ndarray:
    """Mean of ``skin`` (h, w) uint8 over a square neighbourhood of ``size`` (odd) px."""
    return cv2.blur(skin, (size, size), borderType=cv2.BORDER_REPLICATE)


def components(dense: np.ndarray, threshold: int, smallest: float, most: int):
    """The ``most`` largest 8-connected components of ``dense > threshold`` with at least ``smallest`` pixels.

    Returns labels (h, w) uint8 (row + 1, 0 elsewhere), areas (n,) and boxes (n, 4) x y w h in pixels, by falling area.
    """
    runs, n = _runs(dense, threshold)
    areas, boxes = _extents(runs, n)
    order = np.argsort(-areas, kind="stable")[:most]
    order = order[areas[order] >= smallest]
    rename = np.zeros(n, np.uint8)
    rename[order] = np.arange(1, len(order) + 1)
    return _labels(runs, rename, dense.shape), areas[order].astype(float), boxes[order].astype(float)


def large_patches(skin: np.ndarray):
    """``components`` of a skin map (h, w) uint8 that could be heads: the six largest of at least 40 px at 160 x 120."""
    u = unit(skin.shape)
    return components(density(skin, odd(NEIGHBOURHOOD * u)), DENSE, 40.0 * u * u, 6)


@compiled
def _runs(dense, threshold):
    """(m, 4) row, first column, column after the last, component of the stretches of rows above the threshold; number of components.

    A stretch is joined to those that it touches in the row above; components are counted in the order of their first pixels.
    """
    rows, columns = dense.shape
    runs = np.empty((rows * ((columns + 1) // 2), 4), np.int32)
    m = above = 0
    for y in range(rows):
        first, inside = m, False
        for x in range(columns):
            if (dense[y, x] > threshold) != inside:
                inside = not inside
                if inside:
                    runs[m, 0], runs[m, 1], runs[m, 3] = y, x, m
                else:
                    runs[m, 2], m = x, m + 1
        if inside:
            runs[m, 2], m = columns, m + 1
        i, j = above, first
        while i < first and j < m:
            if runs[i, 1] <= runs[j, 2] and runs[j, 1] <= runs[i, 2]:
                a, b = _root(runs, i), _root(runs, j)
                runs[max(a, b), 3] = min(a, b)
            if runs[i, 2] < runs[j, 2]:
                i += 1
            else:
                j += 1
        above = first
    n = 0
    for k in range(m):  # a root is its component's first stretch: it has its number before the others ask for it
        if runs[k, 3] == k:
            runs[k, 3], n = n, n + 1
        else:
            runs[k, 3] = runs[runs[k, 3], 3]
    return runs[:m], n


@compiled
def _root(runs, k):
    while runs[k, 3] != k:
        runs[k, 3] = runs[runs[k, 3], 3]
        k = runs[k, 3]
    return k


@compiled
def _extents(runs, n):
    """Pixels (n,) and boxes (n, 4) x y w h of the components."""
    areas = np.zeros(n, np.int64)
    first, last = np.full((n, 2), 1 << 30), np.full((n, 2), -1)
    for m in range(len(runs)):
        y, x0, x1, k = runs[m]
        areas[k] += x1 - x0
        first[k, 0], first[k, 1] = min(first[k, 0], x0), min(first[k, 1], y)
        last[k, 0], last[k, 1] = max(last[k, 0], x1 - 1), max(last[k, 1], y)
    return areas, np.hstack((first, last - first + 1))


@compiled
def _labels(runs, rename, shape):
    out = np.zeros(shape, np.uint8)
    for m in range(len(runs)):
        y, x0, x1, k = runs[m]
        if rename[k]:
            out[y, x0:x1] = rename[k]
    return out
