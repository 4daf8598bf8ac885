"""Chromaticity: colour without intensity, as indices into small tables.

``r = R / (R + G + B)``, ``g = G / (R + G + B)`` (section II-A.1; the third is redundant). Images are BGR uint8.
"""

from dataclasses import dataclass

import cv2
import numpy as np

R_BINS, G_BINS = 96, 64  # of a table over r and g
R_LOW, G_LOW, STEP = 0.15, 0.10, 1.0 / 160.0  # r from 0.15 to 0.75, g from 0.10 to 0.50
WHITE = np.ones(3)  # gains of B, G, R that leave an image alone
_SUM = np.ones((1, 3), np.float32)
_BRIGHT = np.array([[1, 1, 1, 1e-3]], np.float32)  # never zero
_NUMERATORS = (
    np.array([[-R_LOW, -R_LOW, 1 - R_LOW]], np.float32) / STEP,
    np.array([[-G_LOW, 1 - G_LOW, -G_LOW]], np.float32) / STEP,
)


@dataclass(frozen=True, eq=False)
class Chromaticity:
    """One image in chromaticity coordinates."""

    index: np.ndarray  # (h, w) uint16: 256 * (bin of r) + (bin of g); bins beyond the table are clipped to 0 or 255
    total: np.ndarray  # (h, w) float32, R + G + B of the camera, before the gains
    pixels: np.ndarray  # (h, w, 3) float32 BGR, after the gains


def chromaticity(image: np.ndarray, gains: np.ndarray = WHITE) -> Chromaticity:
    """Table indices of r and g of image (h, w, 3) BGR uint8, after the channels are multiplied by ``gains`` (3,)."""
    raw = image.astype(np.float32)
    total = cv2.transform(raw, _SUM)
    pixels = raw if gains is WHITE else cv2.transform(raw, np.diag(gains).astype(np.float32))
    # (r - R_LOW) / STEP = (R - R_LOW (R + G + B)) / (STEP (R + G + B)): linear numerators, one division each.
    bright = cv2.transform(pixels, _BRIGHT)  # one channel out at a time: that is what OpenCV is fast at
    r, g = (cv2.divide(cv2.transform(pixels, numerator), bright, dtype=cv2.CV_8U) for numerator in _NUMERATORS)
    return Chromaticity(cv2.merge([g, r]).view(np.uint16)[:, :, 0], total, pixels)


def bin_centres() -> tuple[np.ndarray, np.ndarray]:
    """r (R_BINS, 1) and g (1, G_BINS) at the table's bins."""
    return R_LOW + STEP * np.arange(R_BINS)[:, None], G_LOW + STEP * np.arange(G_BINS)[None, :]


def lookup(table: np.ndarray, index: np.ndarray) -> np.ndarray:
    """Values of a table (R_BINS, G_BINS) at the indices (h, w); zero beyond the table."""
    padded = np.zeros((256, 256), table.dtype)
    padded[1 : R_BINS - 1, 1 : G_BINS - 1] = table[1:-1, 1:-1]
    return padded.ravel().take(index)


def histogram(index: np.ndarray, weights: np.ndarray | None = None) -> np.ndarray:
    """(R_BINS, G_BINS) float32 sum of weights (one each if not given) of indices in the table; the outermost bins stay empty."""
    counts = np.bincount(index.ravel(), None if weights is None else weights.ravel(), minlength=65536).reshape(256, 256)
    out = np.zeros((R_BINS, G_BINS), np.float32)
    out[1:-1, 1:-1] = counts[1 : R_BINS - 1, 1 : G_BINS - 1]
    return out


def hue_saturation(image: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Hue [degrees / 2] and saturation [0..255] (h, w) uint8 of the HSI-like space that the paper argues against."""
    hsv = cv2.cvtColor(image, cv2.COLOR_BGR2HSV)
    return hsv[:, :, 0], hsv[:, :, 1]
