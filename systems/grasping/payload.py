"""What the arm may carry, by the data sheet of the Puma 560: a mass at the flange, and how far out of the wrist it may hang.

Frames: O object, G the hand when the fingers close.
"""

import numpy as np

from vipr.systems import se3
from vipr.systems.arm import puma560
from vipr.systems.hand.finger import GRASP_HEIGHT

PAYLOAD = 2.5  # kg at the flange
DYNAMIC_LOAD = 0.0403  # kg m^2 about joint 5: 2.5 kg at 127 mm
HAND_MASS, HAND_CENTRE = 1.1, 0.06  # kg; m from the flange
MOST = PAYLOAD - HAND_MASS  # kg beside the hand


def dynamic_load(X_OG: np.ndarray, mass: float, centre: np.ndarray) -> float:
    """Moment of inertia [kg m^2] about joint 5 of the hand and of an object held at X_OG: mass [kg] at centre (3,) in O."""
    p_5O = se3.inverse(X_OG)[:3] @ np.append(centre, 1.0) + [0.0, 0.0, puma560.FLANGE + GRASP_HEIGHT]
    return float(HAND_MASS * (puma560.FLANGE + HAND_CENTRE) ** 2 + mass * p_5O @ p_5O)
