"""Chromaticity: colour without intensity, as indices into small tables.

``r = R / (R + G + B)``, ``g = G / (R + G + B)`` (section II-A.1; the third is redundant). Images are BGR uint8.
"""

from dataclasses import dataclass
from functools import lru_cache

import cv2
import numpy as np

from vipr.systems.compiled import compiled

R_BINS, G_BINS = 96, 64  # of a table over r and g
R_LOW, G_LOW, STEP = 0.15, 0.10, 1.0 / 160.0  # r from 0.15 to 0.75, g from 0.10 to 0.50
LUMA = np.array([[0.25, 0.5, 0.25]], np.float32)
DARKEST = 36.0  # R + G + B below which chromaticity is noise in a well lit picture
LIT = 0.12  # of the level that the brightest tenth of a picture exceeds, below which it is noise in a dim one
DARKEST_OF_ALL = 15.0  # below which it is noise even in a picture made quiet
WHITE = np.ones(3)  # gains of B, G, R that leave an image alone


@dataclass(frozen=True, eq=False)
class Chromaticity:
    """One image in chromaticity coordinates."""

    index: np.ndarray  # (h, w) uint16: 256 * (bin of r) + (bin of g); bins beyond the table are clipped to 0 or 255
    total: np.ndarray  # (h, w) float32, R + G + B of the camera, before the gains
    pixels: np.ndarray  # (h, w, 3) float32 BGR, after the gains
    luma: np.ndarray  # (h, w) float32, brightness after the gains
    darkest: float = DARKEST  # total below which chromaticity is noise

    @property
    def bright(self) -> np.ndarray:
        """(h, w) bool, where chromaticity is more than noise."""
        return self.total >= self.darkest


def darkest(image: np.ndarray) -> float:
    """R + G + B below which chromaticity is noise in image (h, w, 3) BGR uint8: less in a dim one, so that what is skin stays so."""
    some = image[::6, ::6].astype(np.int32).sum(2).ravel()
    brightest = float(np.partition(some, 9 * len(some) // 10)[9 * len(some) // 10])
    return min(max(LIT * brightest, DARKEST_OF_ALL), DARKEST)


def quiet(image: np.ndarray) -> np.ndarray:
    """The image itself; in dim light, where noise is much of its colour, each pixel as the mean of its neighbourhood."""
    return cv2.GaussianBlur(image, (3, 3), 0) if darkest(image) < DARKEST else image


def chromaticity(image: np.ndarray, gains: np.ndarray = WHITE) -> Chromaticity:
    """Table indices of r and g of image (h, w, 3) BGR uint8, after the channels are multiplied by ``gains`` (3,)."""
    index, total, pixels = _convert(np.ascontiguousarray(image), np.asarray(gains, np.float32))
    return Chromaticity(index, total, pixels, cv2.transform(pixels, LUMA), darkest(image))


@compiled
def _convert(image, gains):
    """Row by row, the division apart from the reading, so that the processor does eight pixels at a time."""
    rows, columns, _ = image.shape
    raw = image.reshape(rows * columns * 3)
    index = np.empty(rows * columns, np.uint16)
    total = np.empty(rows * columns, np.float32)
    pixels = np.empty(rows * columns * 3, np.float32)
    blue, green, red = np.empty(columns, np.float32), np.empty(columns, np.float32), np.empty(columns, np.float32)
    zero, last = np.int32(0), np.int32(255)
    for i in range(rows):
        start = i * columns
        for j in range(columns):
            k = 3 * (start + j)
            b, g, r = np.float32(raw[k]), np.float32(raw[k + 1]), np.float32(raw[k + 2])
            total[start + j] = b + g + r
            blue[j], green[j], red[j] = b * gains[0], g * gains[1], r * gains[2]
            pixels[k], pixels[k + 1], pixels[k + 2] = blue[j], green[j], red[j]
        for j in range(columns):
            scale = np.float32(1.0 / STEP) / (blue[j] + green[j] + red[j] + np.float32(1e-3))
            r_bin = np.int32(red[j] * scale - np.float32(R_LOW / STEP - 0.5))
            g_bin = np.int32(green[j] * scale - np.float32(G_LOW / STEP - 0.5))
            index[start + j] = (min(max(r_bin, zero), last) << np.int32(8)) + min(max(g_bin, zero), last)
    return index.reshape(rows, columns), total.reshape(rows, columns), pixels.reshape(rows, columns, 3)


@lru_cache(maxsize=1)
def bin_centres() -> tuple[np.ndarray, np.ndarray]:
    """r (R_BINS, 1) and g (1, G_BINS) at the table's bins."""
    return R_LOW + STEP * np.arange(R_BINS)[:, None], G_LOW + STEP * np.arange(G_BINS)[None, :]


def nearest_index(r: np.ndarray, g: np.ndarray) -> np.ndarray:
    """Table indices uint16 of r and g (arrays), clipped as those of an image."""
    r_bin, g_bin = (np.clip(np.rint((x - low) / STEP), 0, 255).astype(np.uint16) for x, low in ((r, R_LOW), (g, G_LOW)))
    return (r_bin << np.uint16(8)) + g_bin


def by_index(table: np.ndarray) -> np.ndarray:
    """(256, 256) read-only: the values of a table (R_BINS, G_BINS) where indices point; zero beyond the table."""
    padded = np.zeros((256, 256), table.dtype)
    padded[1 : R_BINS - 1, 1 : G_BINS - 1] = table[1:-1, 1:-1]
    padded.setflags(write=False)
    return padded


def lookup(table: np.ndarray, index: np.ndarray) -> np.ndarray:
    """Values of a table, (R_BINS, G_BINS) or :func:`by_index`, at the indices (h, w); zero beyond the table."""
    return _take(table if table.shape == (256, 256) else by_index(table), index)


@compiled
def _take(table, index):
    out = np.empty(index.shape, table.dtype)
    for i in range(index.shape[0]):
        for j in range(index.shape[1]):
            out[i, j] = table[index[i, j] >> 8, index[i, j] & 255]
    return out


def histogram(index: np.ndarray, weights: np.ndarray | None = None) -> np.ndarray:
    """(R_BINS, G_BINS) float32 sum of weights (one each if not given) of indices in the table; the outermost bins stay empty."""
    weights = np.ones(index.size, np.float32) if weights is None else weights.ravel().astype(np.float32)
    return _count(index.ravel(), weights)


@compiled
def _count(index, weights):
    out = np.zeros((R_BINS, G_BINS), np.float32)
    for k in range(len(index)):
        r, g = index[k] >> 8, index[k] & 255
        if 0 < r < R_BINS - 1 and 0 < g < G_BINS - 1:
            out[r, g] += weights[k]
    return out


def hue_saturation(image: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Hue [degrees / 2] and saturation [0..255] (h, w) uint8 of the HSI-like space that the paper argues against."""
    hsv = cv2.cvtColor(image, cv2.COLOR_BGR2HSV)
    return hsv[:, :, 0], hsv[:, :, 1]
