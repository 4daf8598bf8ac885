"""Rigid motions as 4x4 arrays X_AB and twists ordered (w, v), as Drake orders them.

Frames: ``X_AB`` takes coordinates in B to coordinates in A. A twist ``V`` is ``[wx wy wz vx vy vz]`` in rad/s and m/s (or rad
and m for a displacement). Servo papers order (v, w); conversion happens at their formulas only.
"""

import numpy as np


def skew(w: np.ndarray) -> np.ndarray:
    """The matrix ``[w]x`` with ``[w]x p = w x p``; w (3,) gives (3, 3)."""
    return np.array([[0.0, -w[2], w[1]], [w[2], 0.0, -w[0]], [-w[1], w[0], 0.0]])


def pose(R: np.ndarray, p: np.ndarray) -> np.ndarray:
    """4x4 pose of rotation R (3, 3) and translation p (3,) [m]."""
    X = np.eye(4)
    X[:3, :3], X[:3, 3] = R, p
    return X


def inverse(X_AB: np.ndarray) -> np.ndarray:
    """X_BA."""
    R_BA = X_AB[:3, :3].T
    return pose(R_BA, -R_BA @ X_AB[:3, 3])


def exp_so3(w: np.ndarray) -> np.ndarray:
    """Rotation by the rotation vector w [rad] (Rodrigues)."""
    x, y, z = float(w[0]), float(w[1]), float(w[2])
    a2 = x * x + y * y + z * z
    a = np.sqrt(a2)
    s, c = (np.sin(a) / a, (1.0 - np.cos(a)) / a2) if a2 > 1e-12 else (1.0, 0.5)
    xx, yy, zz = c * x * x, c * y * y, c * z * z
    xy, xz, yz = c * x * y, c * x * z, c * y * z
    sx, sy, sz = s * x, s * y, s * z
    return np.array(
        [
            [1.0 - yy - zz, xy - sz, xz + sy],
            [xy + sz, 1.0 - xx - zz, yz - sx],
            [xz - sy, yz + sx, 1.0 - xx - yy],
        ]
    )


def log_so3(R: np.ndarray) -> np.ndarray:
    """Rotation vector [rad], |w| <= pi, of a rotation matrix."""
    x, y, z = 0.5 * (R[2, 1] - R[1, 2]), 0.5 * (R[0, 2] - R[2, 0]), 0.5 * (R[1, 0] - R[0, 1])
    sin, cos = np.sqrt(x * x + y * y + z * z), 0.5 * (R[0, 0] + R[1, 1] + R[2, 2] - 1.0)
    angle = np.arctan2(sin, cos)
    if sin > 1e-6:
        k = angle / sin
        return np.array([k * x, k * y, k * z])
    if cos > 0:
        return np.array([x, y, z])
    # Near pi: (R + R')/2 = cos I + (1 - cos) u u'; what is left without cos I has columns along the axis u.
    S = 0.5 * (R + R.T) - cos * np.eye(3)
    longest = np.argmax(np.array([S[0, 0], S[1, 1], S[2, 2]]))
    u = S[:, longest] / np.sqrt(S[0, longest] ** 2 + S[1, longest] ** 2 + S[2, longest] ** 2)
    return angle * u if u[0] * x + u[1] * y + u[2] * z >= 0.0 else -angle * u


def _left_jacobian(w: np.ndarray) -> np.ndarray:
    a2 = float(w @ w)
    W = skew(w)
    if a2 < 1e-10:
        return np.eye(3) + 0.5 * W + W @ W / 6.0
    a = np.sqrt(a2)
    return np.eye(3) + ((1.0 - np.cos(a)) / a2) * W + ((a - np.sin(a)) / (a2 * a)) * W @ W


def exp(V: np.ndarray) -> np.ndarray:
    """Pose reached in unit time at the constant twist V = (w, v)."""
    V = np.asarray(V, float)
    return pose(exp_so3(V[:3]), _left_jacobian(V[:3]) @ V[3:])


def log(X: np.ndarray) -> np.ndarray:
    """Twist (w, v) that reaches X in unit time: ``exp(log(X)) == X``."""
    w = log_so3(X[:3, :3])
    return np.concatenate([w, np.linalg.solve(_left_jacobian(w), X[:3, 3])])


def adjoint(X_AB: np.ndarray) -> np.ndarray:
    """(6, 6) matrix that takes a twist (w, v) of one body at B, in B, to the same body's twist at A, in A."""
    R = X_AB[:3, :3]
    A = np.zeros((6, 6))
    A[:3, :3] = A[3:, 3:] = R
    A[3:, :3] = skew(X_AB[:3, 3]) @ R
    return A


def shift(V: np.ndarray, p: np.ndarray) -> np.ndarray:
    """Twist (w, v) of the same body at the point p [m] from where V is taken, all in one frame."""
    return np.concatenate([V[:3], V[3:] + np.cross(V[:3], p)])


def rotate(R_AB: np.ndarray, V_B: np.ndarray) -> np.ndarray:
    """Twist (w, v) in A's axes of one given in B's, at the same point."""
    return np.concatenate([R_AB @ V_B[:3], R_AB @ V_B[3:]])


def difference(X_WA: np.ndarray, X_WB: np.ndarray) -> np.ndarray:
    """(6,): rotation vector theta u [rad] and translation [m] that take pose A to pose B, both expressed in W."""
    return np.concatenate([log_so3(X_WB[:3, :3] @ X_WA[:3, :3].T), X_WB[:3, 3] - X_WA[:3, 3]])


def angle_between(R_A: np.ndarray, R_B: np.ndarray) -> float:
    """Angle [rad] of the rotation from R_A to R_B."""
    return float(np.linalg.norm(log_so3(R_A[:3, :3].T @ R_B[:3, :3])))


def is_pose(X: np.ndarray, tolerance: float = 1e-3) -> bool:
    """Whether X is a finite 4x4 rigid motion to the tolerance."""
    X = np.asarray(X)
    return bool(
        X.shape == (4, 4)
        and np.isfinite(X).all()
        and np.allclose(X[3], [0, 0, 0, 1], atol=tolerance)
        and np.allclose(X[:3, :3] @ X[:3, :3].T, np.eye(3), atol=tolerance)
        and np.linalg.det(X[:3, :3]) > 0
    )
