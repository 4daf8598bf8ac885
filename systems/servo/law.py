"""What all servo laws share: their settings, their speed limits, and the sum of correction and feed-forward."""

from dataclasses import dataclass

import numpy as np

from vipr.systems.errors import InputError
from vipr.systems.servo.gain import AdaptiveGain, largest_gain


@dataclass(frozen=True, kw_only=True)
class Law:
    """Settings that every law has."""

    gain: float | AdaptiveGain = 2.0  # 1/s, lambda
    feed_forward: bool = True  # add the goal's own twist
    max_speed: float = 0.25  # m/s, of the hand
    max_turn: float = 1.0  # rad/s

    def __post_init__(self):
        if not 0 < largest_gain(self.gain) < np.inf:
            raise InputError(f"servo: gain must be positive, got {self.gain} 1/s")
        for name in ("max_speed", "max_turn"):
            if not 0 < getattr(self, name) < np.inf:
                raise InputError(f"servo: {name} must be positive, got {getattr(self, name)}")


def limited_sum(correction: np.ndarray, carried: np.ndarray, law: Law) -> np.ndarray:
    """Twist (w, v) of the hand: the correction, and the goal's own twist if the law feeds it forward, within the speed limits.

    The limits shorten the correction and keep its direction; the feed-forward is limited only with the sum.
    """
    V = shortened(correction, law) + (carried if law.feed_forward else 0.0)
    return shortened(V, law)


def shortened(V: np.ndarray, law: Law) -> np.ndarray:
    """The twist, its direction kept, within the law's speeds."""
    return V / max(np.linalg.norm(V[:3]) / law.max_turn, np.linalg.norm(V[3:]) / law.max_speed, 1.0)
