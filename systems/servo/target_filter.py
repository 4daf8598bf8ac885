"""Constant-velocity Kalman filter of a target's pose in the world, for feed-forward and for bridging the vision delay.

State: the pose X_WO and its twist V_WO_W = (w, v), expressed in the world. Error state and covariance: (rotation, translation, w, v) in
the world, (12, 12); the motion model is white angular and linear acceleration.
"""

from dataclasses import dataclass, field

import numpy as np

from vipr.systems import se3
from vipr.systems.errors import InputError


@dataclass(frozen=True)
class TargetMotion:
    """How a target is expected to move and how well it is seen at least."""

    acceleration: float = 0.3  # m/s^2, standard deviation of the white acceleration over one period
    angular_acceleration: float = 0.6  # rad/s^2
    least_position_noise: float = 2e-4  # m, floor under the measurement's own covariance
    least_rotation_noise: float = 1e-3  # rad

    def __post_init__(self):
        for name in self.__dataclass_fields__:
            if not getattr(self, name) > 0:
                raise InputError(f"target filter: {name} must be positive, got {getattr(self, name)}")


@dataclass(frozen=True, eq=False)
class TargetBelief:
    """What the filter knows; ``time`` is NaN before the first measurement."""

    X_WO: np.ndarray = field(default_factory=lambda: np.eye(4))
    V_WO: np.ndarray = field(default_factory=lambda: np.zeros(6))
    P: np.ndarray = field(default_factory=lambda: np.eye(12))
    time: float = float("nan")

    @property
    def known(self) -> bool:
        return bool(np.isfinite(self.time))


def predict_pose(belief: TargetBelief, time: float) -> np.ndarray:
    """X_WO at the given time [s] by the believed twist."""
    dt = time - belief.time
    return se3.pose(se3.exp_so3(dt * belief.V_WO[:3]) @ belief.X_WO[:3, :3], belief.X_WO[:3, 3] + dt * belief.V_WO[3:])


def update(
    belief: TargetBelief, X_WO: np.ndarray, covariance: np.ndarray, time: float, motion: TargetMotion
) -> TargetBelief:
    """The belief after one pose measurement with covariance (6, 6) of (rotation, translation) in the world, taken at ``time`` [s]."""
    R = np.array(covariance, float)
    floor = np.repeat([motion.least_rotation_noise, motion.least_position_noise], 3) ** 2
    R[np.diag_indices(6)] = np.maximum(np.diag(R), floor)
    if not belief.known:
        P = np.zeros((12, 12))
        P[:6, :6] = R
        P[6:, 6:] = np.diag(np.repeat([motion.angular_acceleration, motion.acceleration], 3) ** 2) * 0.04
        return TargetBelief(X_WO, np.zeros(6), P, time)
    dt = time - belief.time
    F = np.eye(12)
    F[:6, 6:] = dt * np.eye(6)
    q = np.repeat([motion.angular_acceleration, motion.acceleration], 3) ** 2
    Q = np.block([[np.diag(q * dt**4 / 4), np.diag(q * dt**3 / 2)], [np.diag(q * dt**3 / 2), np.diag(q * dt**2)]])
    P = F @ belief.P @ F.T + Q
    X = predict_pose(belief, time)
    innovation = se3.difference(X, X_WO)
    K = np.linalg.solve(P[:6, :6] + R, P[:6]).T
    change = K @ innovation
    P = P - K @ P[:6]
    X_new = se3.pose(se3.exp_so3(change[:3]) @ X[:3, :3], X[:3, 3] + change[3:6])
    return TargetBelief(X_new, belief.V_WO + change[6:], 0.5 * (P + P.T), time)
