"""Forward kinematics and Jacobian of a serial arm given by standard Denavit-Hartenberg parameters.

Link i: ``T_i = Rz(q_i) Tz(d_i) Tx(a_i) Rx(alpha_i)``. Frames: B base (bottom of the pedestal), E the tool, fixed to the last link by
``X_6E``. Twists are ordered (w, v).
"""

from dataclasses import dataclass, field

import numpy as np


@dataclass(frozen=True, eq=False)
class SerialArm:
    """Kinematics of an arm of n revolute joints that carries a tool."""

    d: np.ndarray  # (n,) m
    a: np.ndarray  # (n,) m
    alpha: np.ndarray  # (n,) rad
    X_6E: np.ndarray = field(default_factory=lambda: np.eye(4))  # tool in the last link's frame

    def link_poses(self, q: np.ndarray) -> np.ndarray:
        """(..., n + 1, 4, 4): X_B0 ... X_Bn for joint angles q (..., n) [rad]."""
        cq, sq = np.cos(q), np.sin(q)
        ca, sa = np.cos(self.alpha), np.sin(self.alpha)
        T = np.zeros((*np.shape(q), 4, 4))
        T[..., 0, 0], T[..., 0, 1], T[..., 0, 2], T[..., 0, 3] = cq, -sq * ca, sq * sa, self.a * cq
        T[..., 1, 0], T[..., 1, 1], T[..., 1, 2], T[..., 1, 3] = sq, cq * ca, -cq * sa, self.a * sq
        T[..., 2, 1], T[..., 2, 2], T[..., 2, 3] = sa, ca, self.d
        T[..., 3, 3] = 1.0
        n = T.shape[-3]
        poses = np.empty((*T.shape[:-3], n + 1, 4, 4))
        poses[..., 0, :, :] = np.eye(4)
        for i in range(n):
            poses[..., i + 1, :, :] = poses[..., i, :, :] @ T[..., i, :, :]
        return poses

    def tool_pose(self, q: np.ndarray) -> np.ndarray:
        """X_BE (4, 4)."""
        return self.link_poses(q)[-1] @ self.X_6E

    def tool_pose_and_jacobian(self, q: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """X_BE and J (6, n) with ``V_BE_B = J qdot``: (w, v) of the tool's origin, expressed in B."""
        poses = self.link_poses(q)
        X_BE = poses[-1] @ self.X_6E
        axes, origins = poses[:-1, :3, 2], poses[:-1, :3, 3]
        J = np.empty((6, len(q)))
        J[:3] = axes.T
        J[3:] = np.cross(axes, X_BE[:3, 3] - origins).T
        return X_BE, J
