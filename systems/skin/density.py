"""Density of skin pixels, threshold and connected components (section II-A.1, Fig. 2)."""

import cv2
import numpy as np

from vipr.systems.compiled import compiled


def density(skin: np.ndarray, size: int) -> np.ndarray:
    """Mean of ``skin`` (h, w) uint8 over a square neighbourhood of ``size`` (odd) px."""
    return cv2.blur(skin, (size, size), borderType=cv2.BORDER_REPLICATE)


def components(dense: np.ndarray, threshold: int, smallest: float, most: int):
    """The ``most`` largest connected components of ``dense > threshold`` with at least ``smallest`` pixels.

    Returns labels (h, w) uint8 (row + 1, 0 elsewhere), areas (n,) and boxes (n, 4) x y w h in pixels, by falling area.
    """
    mask = cv2.threshold(dense, threshold, 255, cv2.THRESH_BINARY)[1]
    n, labels = cv2.connectedComponents(mask, connectivity=8)
    areas, boxes = _extents(labels, n)
    order = np.argsort(-areas, kind="stable")[:most]
    order = order[areas[order] >= smallest]
    rename = np.zeros(n + 1, np.uint8)
    rename[order + 1] = np.arange(1, len(order) + 1)
    return _renamed(labels, rename), areas[order].astype(float), boxes[order].astype(float)


@compiled
def _extents(labels, n):
    """Pixels (n - 1,) and boxes (n - 1, 4) x y w h of the components."""
    areas = np.zeros(n - 1, np.int64)
    first, last = np.full((n - 1, 2), 1 << 30), np.full((n - 1, 2), -1)
    for y in range(labels.shape[0]):
        for x in range(labels.shape[1]):
            if labels[y, x]:
                k = labels[y, x] - 1
                areas[k] += 1
                first[k, 0], first[k, 1] = min(first[k, 0], x), min(first[k, 1], y)
                last[k, 0], last[k, 1] = max(last[k, 0], x), max(last[k, 1], y)
    return areas, np.hstack((first, last - first + 1))


@compiled
def _renamed(labels, rename):
    out = np.empty(labels.shape, np.uint8)
    for y in range(labels.shape[0]):
        for x in range(labels.shape[1]):
            out[y, x] = rename[labels[y, x]]
    return out
