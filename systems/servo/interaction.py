"""Interaction matrices: how image features change when the camera moves, ``sdot = L V_C`` (Chaumette and Hutchinson 2006).

V_C = (w, v) is the twist of the camera at its origin in its own axes [rad/s, m/s]: Drake's order, so the columns are turned round from
the (v, w) of most servo papers and of ViSP. Where the camera stands and a body moves with the twist V_B, taken at C's origin in C,
``sdot = -L V_B``. Frame C: x right, y down, z forward. Image features are in normalised coordinates, x = X / Z.
"""

import numpy as np

from vipr.systems import se3
from vipr.systems.errors import InputError


def point_interaction(x: np.ndarray, Z: np.ndarray) -> np.ndarray:
    """(2 n, 6) of points x (n, 2) at the depths Z (n,) [m], rows x1 y1 x2 y2 ..."""
    x, Z = np.atleast_2d(x), np.atleast_1d(np.asarray(Z, float))
    require_depths(Z)
    L = np.zeros((len(x), 2, 6))
    u, v = x.T
    L[:, 0, :3] = np.column_stack([u * v, -(1.0 + u**2), v])
    L[:, 1, :3] = np.column_stack([1.0 + v**2, -u * v, -u])
    L[:, 0, 3] = L[:, 1, 4] = -1.0 / Z
    L[:, :, 5] = x / Z[:, None]
    return L.reshape(-1, 6)


def log_depth_interaction(x: np.ndarray, Z: float) -> np.ndarray:
    """(6,) of log(Z / Z*) for the point x (2,) at the depth Z [m]."""
    require_depths(Z)
    return np.array([-x[1], x[0], 0.0, 0.0, 0.0, -1.0 / Z])


def line_interaction(rho: float, theta: float, plane: np.ndarray) -> np.ndarray:
    """(2, 6) of (rho, theta) of the line ``x cos theta + y sin theta = rho``.

    plane (4,): A X + B Y + C Z + D = 0 in C [m], any plane through the line in space but not through C's origin.
    """
    A, B, C, D = plane
    if abs(D) < 1e-9 * np.linalg.norm(plane[:3]) or not np.isfinite(plane).all():
        raise InputError(f"line interaction: the plane must not pass through the camera's centre, got D = {D:g} m")
    c, s = np.cos(theta), np.sin(theta)
    along, across = (A * s - B * c) / D, (C + rho * (A * c + B * s)) / D
    return np.array(
        [
            [(1.0 + rho**2) * s, -(1.0 + rho**2) * c, 0.0, across * c, across * s, -across * rho],
            [-rho * c, -rho * s, -1.0, along * c, along * s, -along * rho],
        ]
    )


def theta_u_interaction(theta_u: np.ndarray) -> np.ndarray:
    """(3, 6) of the rotation vector theta u [rad] of R_C*C, from the current camera's axes to the desired one's."""
    return np.hstack([theta_u_rate(theta_u), np.zeros((3, 3))])


def theta_u_rate(theta_u: np.ndarray) -> np.ndarray:
    """(3, 3): d(theta u)/dt of R_C*C for the camera's w in C (Malis, Chaumette and Boudet 1999)."""
    theta = np.linalg.norm(theta_u)
    W = se3.skew(theta_u)
    if theta < 1e-4:
        return np.eye(3) + 0.5 * W + W @ W / 12.0
    return np.eye(3) + 0.5 * W + (1.0 - 0.5 * theta / np.tan(0.5 * theta)) / theta**2 * W @ W


def require_depths(Z: np.ndarray) -> None:
    """InputError unless every depth [m] is positive."""
    Z = np.atleast_1d(Z)
    bad = np.flatnonzero(~(Z > 0))
    if len(bad):
        raise InputError(f"servo: depths must be positive, got {Z[bad[0]]:.3g} m at point {bad[0] + 1} of {len(Z)}")
