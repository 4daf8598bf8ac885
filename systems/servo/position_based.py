"""Position-based visual servoing: the hand to a reference pose relative to an object (paper III-D; Hutchinson, Hager, Corke 1996).

Frames: W world, E the hand, O the object, G the goal of E. Twists are (w, v) of E's origin, expressed in W.
"""

from dataclasses import dataclass

import numpy as np

from vipr.systems.errors import InputError


@dataclass(frozen=True)
class PositionBased:
    """The law's parameters."""

    gain: float = 2.0  # 1/s, lambda
    feed_forward: bool = True  # add the goal's own twist
    max_speed: float = 0.25  # m/s
    max_turn: float = 1.0  # rad/s

    def __post_init__(self):
        for name in ("gain", "max_speed", "max_turn"):
            if not getattr(self, name) > 0:
                raise InputError(f"servo: {name} must be positive, got {getattr(self, name)}")


def carried_twist(V_WO: np.ndarray, p_OG_W: np.ndarray) -> np.ndarray:
    """Twist (w, v) of a goal that the object carries at p_OG_W [m] from its origin."""
    return np.concatenate([V_WO[:3], V_WO[3:] + np.cross(V_WO[:3], p_OG_W)])


def servo_twist(error: np.ndarray, V_WG: np.ndarray, law: PositionBased) -> np.ndarray:
    """V_WE = lambda error + V_WG for the error ``se3.difference(X_WE, X_WG)``, within the speed limits.

    Translation goes on a straight line, rotation about a fixed axis. The limits shorten the correction and keep its direction;
    the feed-forward is limited only with the sum.
    """
    correction = law.gain * error
    over = max(np.linalg.norm(correction[:3]) / law.max_turn, np.linalg.norm(correction[3:]) / law.max_speed, 1.0)
    V = correction / over + (V_WG if law.feed_forward else 0.0)
    over = max(np.linalg.norm(V[:3]) / law.max_turn, np.linalg.norm(V[3:]) / law.max_speed, 1.0)
    return V / over
