"""Euclidean homography of a plane between two views, and its decomposition: rotation and relative depth with no model of the object.

``x* ~ H x`` takes normalised image points of the current view C to the desired one C*, ``H = R_C*C + t n^T / d`` with the plane
``n . p = d`` in C and t = p_C*C [m] (Faugeras and Lustman 1988; Malis and Vargas 2007).
"""

from typing import NamedTuple

import numpy as np

from vipr.systems.errors import InputError


class PlaneMotion(NamedTuple):
    """One reading of a homography."""

    R: np.ndarray  # (3, 3) R_C*C
    t_over_d: np.ndarray  # (3,) p_C*C by the plane's distance d from C
    normal: np.ndarray  # (3,) unit, in C, away from the camera


def homography(x: np.ndarray, x_goal: np.ndarray) -> np.ndarray:
    """H (3, 3), middle singular value 1 and positive depths, of points in a plane x (n, 2) and x_goal (n, 2), n >= 4 (normalised DLT)."""
    if len(x) < 4 or len(x) != len(x_goal):
        raise InputError(f"homography: 4 or more pairs of points are needed, got {len(x)} and {len(x_goal)}")
    A, B = _normaliser(x), _normaliser(x_goal)
    p, q = _lift(x) @ A.T, _lift(x_goal) @ B.T
    rows = np.zeros((2 * len(p), 9))
    rows[0::2, 0:3], rows[0::2, 6:9] = p, -q[:, :1] * p
    rows[1::2, 3:6], rows[1::2, 6:9] = p, -q[:, 1:2] * p
    _, s, Vt = np.linalg.svd(rows)
    if s[7] < 1e-9 * s[0]:
        raise InputError("homography: the points determine none (three of four on a line, or coincident)")
    H = np.linalg.inv(B) @ Vt[8].reshape(3, 3) @ A
    H /= np.linalg.svd(H, compute_uv=False)[1]
    return H if np.sum(_lift(x_goal) * (_lift(x) @ H.T)) > 0 else -H


def decompose(H: np.ndarray, x: np.ndarray) -> list[PlaneMotion]:
    """The readings of H (one or two; one if nothing moved but by a rotation) in which all points x (n, 2) lie before the camera."""
    _, s, Vt = np.linalg.svd(H.T @ H)
    s1, s3 = s[0], s[2]
    if s1 - s3 < 1e-12:
        return [PlaneMotion(_rotation(H), np.zeros(3), np.array([0.0, 0.0, 1.0]))]
    V = Vt.T * np.sign(np.linalg.det(Vt))
    v1, v2, v3 = V.T
    a, b = np.sqrt(max(1.0 - s3, 0.0)), np.sqrt(max(s1 - 1.0, 0.0))
    readings = []
    for sign in (1.0, -1.0):
        u = (a * v1 + sign * b * v3) / np.sqrt(s1 - s3)
        n = np.cross(v2, u)
        frame, image = np.column_stack([v2, u, n]), H @ np.column_stack([v2, u])
        R = _rotation(np.column_stack([image, np.cross(image[:, 0], image[:, 1])]) @ frame.T)
        n = n if np.mean(_lift(x) @ n) > 0 else -n
        if (_lift(x) @ n > 0).all():
            readings.append(PlaneMotion(R, (H - R) @ n, n))
    return readings


def depth_ratio(motion: PlaneMotion, x: np.ndarray, x_goal: np.ndarray) -> float:
    """Z / Z* of one point of the plane seen at x (2,) and x_goal (2,)."""
    h = motion.R @ np.append(x, 1.0) + motion.t_over_d * (motion.normal @ np.append(x, 1.0))
    return float(1.0 / h[2])


def _lift(x: np.ndarray) -> np.ndarray:
    return np.column_stack([x, np.ones(len(x))])


def _normaliser(x: np.ndarray) -> np.ndarray:
    """(3, 3): middle to 0, mean distance to sqrt 2 (Hartley 1997)."""
    middle = x.mean(0)
    size = np.mean(np.linalg.norm(x - middle, axis=1))
    if size < 1e-9:
        raise InputError("homography: all points are in one place")
    k = np.sqrt(2.0) / size
    return np.array([[k, 0, -k * middle[0]], [0, k, -k * middle[1]], [0, 0, 1.0]])


def _rotation(M: np.ndarray) -> np.ndarray:
    """The rotation nearest to M."""
    U, _, Vt = np.linalg.svd(M)
    return U @ np.diag([1.0, 1.0, np.linalg.det(U @ Vt)]) @ Vt
