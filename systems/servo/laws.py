"""The servo laws under one roof: settings as a tagged union, and the twist that each asks for."""

import numpy as np

from vipr.systems.servo.depth import DepthBelief, assume, update_depths
from vipr.systems.servo.hybrid import Hybrid, hybrid_twist
from vipr.systems.servo.image_based import ImageBased, image_based_twist
from vipr.systems.servo.position_based import PositionBased, position_based_twist
from vipr.systems.servo.situation import Situation, require_apart

ServoLaw = PositionBased | ImageBased | Hybrid


def correction(situation: Situation, law: ServoLaw, memory: DepthBelief) -> tuple[np.ndarray, DepthBelief]:
    """V_B (w, v) at C's origin in C that takes B towards G, and what the law remembers (estimated depths only).

    Raises:
        InputError: where the law has no answer, such as a feature behind the camera.
    """
    if isinstance(law, PositionBased):
        return position_based_twist(situation, law), memory
    if isinstance(law, Hybrid):
        return hybrid_twist(situation, law), memory
    if law.jacobian != "estimated":
        return image_based_twist(situation, law), memory
    if len(memory.inverse) == len(situation.points_B):
        memory = update_depths(memory, situation.x, -situation.V_B, situation.time)
    else:
        memory = assume(situation.goal_depths, situation.x, situation.time)
    return image_based_twist(situation, law, memory.depths), memory


def check_features(law: ServoLaw, points_B: np.ndarray) -> None:
    """InputError if the law cannot work with these feature points (n, 3) [m]."""
    if not isinstance(law, PositionBased):
        require_apart(points_B)
