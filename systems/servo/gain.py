"""Gains: constant, or growing as the error shrinks."""

from dataclasses import dataclass

import numpy as np

from vipr.systems.errors import InputError


@dataclass(frozen=True)
class AdaptiveGain:
    """``lambda(x) = a exp(-b x) + c`` of the error's largest component x: gentle from afar, quick at the end.

    The form and the three parameters are those of ViSP's adaptive gain.
    """

    near: float = 4.0  # 1/s, at no error
    far: float = 1.0  # 1/s, at large errors
    slope: float = 10.0  # 1/s a unit of error, at no error

    def __post_init__(self):
        if not 0 < self.far < self.near:
            raise InputError(
                f"servo: gain.far must be positive and below gain.near, got {self.far} and {self.near} 1/s"
            )
        if not self.slope > 0:
            raise InputError(f"servo: gain.slope must be positive, got {self.slope}")


def gain_at(gain: float | AdaptiveGain, error: np.ndarray) -> float:
    """lambda [1/s] for an error vector in its own units."""
    if not isinstance(gain, AdaptiveGain):
        return gain
    span = gain.near - gain.far
    return float(span * np.exp(-gain.slope / span * np.max(np.abs(error))) + gain.far)


def largest_gain(gain: float | AdaptiveGain) -> float:
    """The largest lambda [1/s] that can occur: what must be stable."""
    return gain.near if isinstance(gain, AdaptiveGain) else gain
