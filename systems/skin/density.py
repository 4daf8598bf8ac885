"""Density of skin pixels, threshold and connected components (section II-A.1, Fig. 2)."""

import cv2
import numpy as np


def density(skin: np.ndarray, size: int) -> np.ndarray:
    """Mean of ``skin`` (h, w) uint8 over a square neighbourhood of ``size`` (odd) px."""
    return cv2.blur(skin, (size, size), borderType=cv2.BORDER_REPLICATE)


def components(dense: np.ndarray, threshold: int, smallest: float, most: int):
    """The ``most`` largest connected components of ``dense > threshold`` with at least ``smallest`` pixels.

    Returns labels (h, w) uint8 (row + 1, 0 elsewhere), areas (n,) and boxes (n, 4) x y w h in pixels, by falling area.
    """
    mask = cv2.threshold(dense, threshold, 255, cv2.THRESH_BINARY)[1]
    n, labels, stats, _ = cv2.connectedComponentsWithStats(mask, connectivity=8, ltype=cv2.CV_16U)
    areas = stats[1:, cv2.CC_STAT_AREA]
    order = np.argsort(-areas, kind="stable")[:most]
    order = order[areas[order] >= smallest]
    rename = np.zeros(n, np.uint8)
    rename[order + 1] = np.arange(1, len(order) + 1)
    return rename.take(labels), areas[order].astype(float), stats[1:][order, :4].astype(float)
