"""2.5D visual servoing: half in the image, half in space (Malis, Chaumette and Boudet 1999).

``e = (x - x*, y - y*, log(Z / Z*), theta u)`` of one reference point and of the rotation R_C*C. The interaction matrix is block
triangular and never singular before the camera; the reference point goes straight in the image, so it stays in view.
"""

from dataclasses import dataclass
from typing import Literal

import numpy as np

from vipr.systems import se3
from vipr.systems.errors import InputError
from vipr.systems.servo.gain import gain_at
from vipr.systems.servo.homography import decompose, depth_ratio, homography
from vipr.systems.servo.interaction import log_depth_interaction, point_interaction, require_depths, theta_u_interaction
from vipr.systems.servo.law import Law
from vipr.systems.servo.situation import Situation

SOURCES = ("pose", "homography")


@dataclass(frozen=True, kw_only=True)
class Hybrid(Law):
    """rotation: R and Z / Z* from the ``pose``, or from the ``homography`` of features that lie in a plane (no model of the object)."""

    kind: Literal["hybrid"] = "hybrid"
    rotation: str = "pose"

    def __post_init__(self):
        super().__post_init__()
        if self.rotation not in SOURCES:
            raise InputError(f"servo: unknown rotation {self.rotation!r}, allowed are {', '.join(SOURCES)}")


def hybrid_twist(situation: Situation, law: Hybrid) -> np.ndarray:
    """V_B (w, v) at C's origin in C: ``lambda L^-1 e``, positive since the body moves and not the camera."""
    x, x_goal, Z, log_ratio, theta_u = features(situation, law)
    error = np.concatenate([x - x_goal, [log_ratio], theta_u])
    L = np.vstack([point_interaction(x, Z), log_depth_interaction(x, Z), theta_u_interaction(theta_u)])
    return gain_at(law.gain, error) * np.linalg.solve(L, error)


def features(situation: Situation, law: Hybrid) -> tuple[np.ndarray, np.ndarray, float, float, np.ndarray]:
    """Reference point x, x* (2,), its depth Z [m], log(Z / Z*) and theta u (3,) of R_C*C."""
    if law.rotation == "pose":
        middle = situation.points_C.mean(0)
        goal = situation.goal_points_C.mean(0)
        require_depths([middle[2], goal[2]])
        theta_u = se3.log_so3(situation.X_CG[:3, :3] @ situation.X_CB[:3, :3].T)
        return middle[:2] / middle[2], goal[:2] / goal[2], middle[2], np.log(middle[2] / goal[2]), theta_u
    x, x_goal = situation.x, situation.x_goal
    readings = decompose(homography(x, x_goal), x)
    if not readings:
        raise InputError("servo: the features' homography has no reading with all of them before the camera")
    expected = situation.X_CG[:3, :3] @ situation.X_CB[:3, :3].T
    motion = min(readings, key=lambda reading: se3.angle_between(reading.R, expected))
    k = int(np.argmin(np.linalg.norm(x - x.mean(0), axis=1)))  # the feature nearest the middle
    ratio = depth_ratio(motion, x[k], x_goal[k])
    Z_goal = situation.goal_depths[k]
    return x[k], x_goal[k], ratio * Z_goal, np.log(ratio), se3.log_so3(motion.R)
