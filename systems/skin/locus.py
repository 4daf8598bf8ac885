"""Where skin lies in the r-g plane: the box of the paper, the shell around the skin locus, and a prior for the bootstrap.

The shell is the pair of parabolas of Soriano et al. (Pattern Recognition 36, 2003) around the locus that Störring et al. (RAS 35, 2001)
derived: Planckian light times skin reflectance times camera. The prior is a Gaussian along the same curve in log (R/G, B/G), where a
change of light is a shift; its figures come from the UCI skin pixels and photographs of several cameras.
"""

from dataclasses import dataclass

import numpy as np

from vipr.systems.errors import InputError
from vipr.systems.skin.chromaticity import bin_centres


@dataclass(frozen=True)
class SkinBox:
    """The box classifier of section II-A.1: limits of r and g."""

    r_low: float = 0.36
    r_high: float = 0.56
    g_low: float = 0.27
    g_high: float = 0.345

    def __post_init__(self):
        if not (0 <= self.r_low < self.r_high <= 1 and 0 <= self.g_low < self.g_high <= 1):
            raise InputError(
                f"skin box: needs 0 <= low < high <= 1, got r {self.r_low} to {self.r_high}, g {self.g_low} to {self.g_high}"
            )

    def contains(self, r, g):
        """Whether chromaticities r, g (arrays) lie in the box."""
        return (r >= self.r_low) & (r <= self.r_high) & (g >= self.g_low) & (g <= self.g_high)


def in_locus(r, g, widen: float = 0.0, white_radius: float = 0.02):
    """Whether r, g (arrays) lie in the shell around the skin locus, ``widen`` outside it at most, and not near white."""
    upper = -1.3767 * r**2 + 1.0743 * r + 0.1452
    lower = -0.776 * r**2 + 0.5601 * r + 0.1766
    white = (r - 0.33) ** 2 + (g - 0.33) ** 2
    return (g > lower - widen) & (g < upper + widen) & (white > white_radius**2)


def box_table(box: SkinBox, locus: bool = True) -> np.ndarray:
    """(R_BINS, G_BINS) uint8 255 inside the box (and the shell, widened by 0.02), 0 outside."""
    r, g = bin_centres()
    inside = box.contains(r, g)
    if locus:
        inside = inside & in_locus(r, g, widen=0.02)
    return np.where(inside, 255, 0).astype(np.uint8)


def skin_prior() -> np.ndarray:
    """(R_BINS, G_BINS) float32 probability of each bin for skin of anybody under everyday light: a core on the locus and a broad tail."""
    r, g = bin_centres()
    b = np.maximum(1 - r - g, 0.01)
    red, blue = np.log(r / g), np.log(b / g)
    core = np.exp(-0.5 * ((red - (0.20 - 0.60 * blue)) / 0.14) ** 2 - 0.5 * ((blue + 0.25) / 0.28) ** 2)
    tail = np.exp(-0.5 * ((red - 0.42) / 0.22) ** 2 - 0.5 * ((blue + 0.05) / 0.42) ** 2)
    possible = (red > 0.07) & (r + g < 0.97)
    core, tail = core * possible, tail * possible
    return (0.85 * core / core.sum() + 0.15 * tail / tail.sum()).astype(np.float32)
