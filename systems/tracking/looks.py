"""How small patches look at several scales, whatever the light: samples on a grid that may be warped, mean removed, length one."""

import cv2
import numpy as np

from vipr.systems.compiled import compiled
from vipr.systems.tracking.normal_flow import Patch, bilinear

HALF = 3  # px; a patch is 7 x 7 samples at each level
LEVELS = 4
ABOVE_NOISE = 1.8  # a patch needs an RMS contrast, and gradients both ways, of so many times the noise's
SAMPLES = (2 * HALF + 1) ** 2


def pyramid(patch: Patch) -> list[Patch]:
    """The patch at full, half, quarter ... size; coordinates relative to its origin shrink alike."""
    levels = [patch]
    for _ in range(LEVELS - 1):
        grey = levels[-1].grey
        levels.append(
            Patch(
                cv2.pyrDown(grey) if min(grey.shape) > 8 else np.ascontiguousarray(grey[::2, ::2]),
                patch.origin,
                0.45 * levels[-1].noise,
            )
        )
    return levels


@compiled
def sample_patch(grey, x, y, axes, out):
    """Samples, rows of y, of the image around (x, y) into out (SAMPLES,); axes (2, 2): pixels for a grid step along x and y, as rows."""
    p = 0
    for j in range(-HALF, HALF + 1):
        for i in range(-HALF, HALF + 1):
            out[p] = bilinear(grey, x + i * axes[0, 0] + j * axes[1, 0], y + i * axes[0, 1] + j * axes[1, 1])
            p += 1


@compiled
def normalise(samples, floor):
    """Takes the mean off samples (P,) in place; returns 1 / their length, or 0 where that is no more than the floor."""
    mean = np.float32(0.0)
    for value in samples:
        mean += value
    mean /= len(samples)
    square = np.float32(0.0)
    for p in range(len(samples)):
        samples[p] -= mean
        square += samples[p] * samples[p]
    return np.float32(1.0 / np.sqrt(square)) if square > floor * floor else np.float32(0.0)


def contrast_floor(noise: float) -> float:
    """Length of a patch's samples below which they are no more than noise [grey levels]."""
    return ABOVE_NOISE * max(noise, 0.5) * (2 * HALF + 1)
