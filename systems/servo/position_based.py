"""Position-based visual servoing: by the error in pose (paper III-D; Hutchinson, Hager, Corke 1996)."""

from dataclasses import dataclass
from typing import Literal

import numpy as np

from vipr.systems import se3
from vipr.systems.servo.gain import gain_at
from vipr.systems.servo.law import Law
from vipr.systems.servo.situation import Situation


@dataclass(frozen=True, kw_only=True)
class PositionBased(Law):
    """The body's origin goes straight to its goal while it turns about a fixed axis."""

    kind: Literal["position_based"] = "position_based"


def position_based_twist(situation: Situation, law: PositionBased) -> np.ndarray:
    """V_B (w, v) at C's origin in C, by which the pose error decays exponentially, each component alike."""
    error = situation.pose_error
    return se3.shift(gain_at(law.gain, error) * error, -situation.X_CB[:3, 3])
