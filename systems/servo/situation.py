"""What a servo law sees: a body B in the camera, where it should be, and how both move.

Frames: C camera (x right, y down, z forward), B the body that is moved, G its goal. A twist is (w, v) at C's origin, expressed in C.
A camera in the hand is the same situation: the body is what it looks at, moving by the opposite of the camera's twist.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from vipr.systems import se3
from vipr.systems.errors import InputError
from vipr.systems.servo.interaction import require_depths


@dataclass(frozen=True, eq=False)
class Situation:
    """Everything a law may use; each takes what it needs."""

    X_CB: np.ndarray  # (4, 4)
    X_CG: np.ndarray  # (4, 4)
    points_B: np.ndarray  # (n, 3) m, the features, fixed to B
    V_B: np.ndarray  # (6,) twist of B now
    V_G: np.ndarray  # (6,) twist of the goal now
    # (n, 2) where the features were shown, normalised; None: where X_CG puts them.
    x_goal_shown: np.ndarray | None = None
    time: float = 0.0  # s

    @cached_property
    def points_C(self) -> np.ndarray:
        """(n, 3) [m]."""
        return self.points_B @ self.X_CB[:3, :3].T + self.X_CB[:3, 3]

    @cached_property
    def goal_points_C(self) -> np.ndarray:
        """(n, 3) [m]."""
        return self.points_B @ self.X_CG[:3, :3].T + self.X_CG[:3, 3]

    @property
    def depths(self) -> np.ndarray:
        """(n,) [m]."""
        return self.points_C[:, 2]

    @property
    def goal_depths(self) -> np.ndarray:
        """(n,) [m]."""
        return self.goal_points_C[:, 2]

    @cached_property
    def x(self) -> np.ndarray:
        """(n, 2) the features, normalised."""
        return projected(self.points_C)

    @cached_property
    def x_goal(self) -> np.ndarray:
        """(n, 2) the features at the goal, normalised."""
        if self.x_goal_shown is not None:
            return self.x_goal_shown
        return projected(self.goal_points_C)

    @cached_property
    def pose_error(self) -> np.ndarray:
        """(6,) theta u [rad] and t [m] that take B to G, in C."""
        return se3.difference(self.X_CB, self.X_CG)


def projected(points_C: np.ndarray) -> np.ndarray:
    """Normalised image points (n, 2) of points (n, 3) [m] in C; InputError where one is not before the camera."""
    require_depths(points_C[:, 2])
    return points_C[:, :2] / points_C[:, 2:]


def require_apart(points: np.ndarray, least: float = 1e-3) -> None:
    """InputError unless at least three of the feature points (n, 3) [m] stand apart and not on one line."""
    points = np.asarray(points, float)
    if points.ndim != 2 or points.shape[1] != 3 or not np.isfinite(points).all():
        raise InputError(f"servo: feature points must be (n, 3) finite numbers [m], got shape {points.shape}")
    if len(points) < 3:
        raise InputError(f"servo: at least 3 feature points are needed, got {len(points)}")
    gaps = np.linalg.norm(points[:, None] - points[None], axis=2)[np.triu_indices(len(points), 1)]
    if gaps.min() < least:
        raise InputError(
            f"servo: feature points must be {1e3 * least:g} mm apart, got two that are {1e3 * gaps.min():.3g} mm apart"
        )
    spread = np.linalg.svd(points - points.mean(0), compute_uv=False)
    if spread[1] < 1e-3 * spread[0]:
        raise InputError(f"servo: feature points must not lie on one line, got {len(points)} that do")
