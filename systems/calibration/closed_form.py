"""Starts of the calibration in closed form: homographies, intrinsics of them, poses of planes, camera and board about a robot.

Frames: W world, C camera, E hand, B board (in its plane z = 0).
"""

import numpy as np

from vipr.systems import se3
from vipr.systems.errors import InputError


def homography(plane: np.ndarray, pixels: np.ndarray) -> np.ndarray:
    """H (3, 3), pixels ~ H (x, y, 1), of n >= 4 points (n, 2) in a plane and in the image: normalised direct linear transform."""
    (a, A), (b, B) = _normalised(plane), _normalised(pixels)
    rows = np.zeros((2 * len(a), 9))
    h = np.column_stack([a, np.ones(len(a))])
    rows[0::2, 0:3], rows[0::2, 6:9] = h, -b[:, :1] * h
    rows[1::2, 3:6], rows[1::2, 6:9] = h, -b[:, 1:] * h
    H = np.linalg.svd(rows)[2][-1].reshape(3, 3)
    H = np.linalg.solve(B, H @ A)
    return H / np.linalg.norm(H[:, 0])


def _normalised(points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    middle = points.mean(axis=0)
    scale = np.sqrt(2.0) / max(np.mean(np.linalg.norm(points - middle, axis=1)), 1e-12)
    T = np.array([[scale, 0, -scale * middle[0]], [0, scale, -scale * middle[1]], [0, 0, 1]])
    return (points - middle) * scale, T


def focal_lengths(homographies: list[np.ndarray], centre: tuple[float, float]) -> tuple[float, float]:
    """fx, fy [px] from views of a plane, with the principal point assumed at ``centre`` and no skew (after Zhang 2000).

    The columns of K^-1 H are two axes of the plane: perpendicular and of equal length.
    """
    rows, right = [], []
    shift = np.array([[1, 0, -centre[0]], [0, 1, -centre[1]], [0, 0, 1.0]])
    for H in homographies:
        (a, b), scale = (shift @ H).T[:2], 1e-3  # pixels to thousands: equations of one size
        a, b = a * [scale, scale, 1], b * [scale, scale, 1]
        weight = 1.0 / (np.linalg.norm(a) * np.linalg.norm(b))
        rows += [weight * a[:2] * b[:2], weight * (a[:2] ** 2 - b[:2] ** 2)]
        right += [-weight * a[2] * b[2], -weight * (a[2] ** 2 - b[2] ** 2)]
    inverse_squares = np.linalg.lstsq(np.array(rows), np.array(right), rcond=None)[0]
    if not (inverse_squares > 0).all():
        raise InputError("calibrate: the views are too alike to tell the focal length; turn the board about two axes")
    return tuple(1e3 / np.sqrt(inverse_squares))


def plane_pose(H: np.ndarray, K: np.ndarray) -> np.ndarray:
    """X_CB (4, 4) of a plane in front of the camera from its homography."""
    M = np.linalg.solve(K, H)
    M *= np.sign(M[2, 2]) / np.sqrt(np.linalg.norm(M[:, 0]) * np.linalg.norm(M[:, 1]))
    U, _, Vt = np.linalg.svd(np.column_stack([M[:, 0], M[:, 1], np.cross(M[:, 0], M[:, 1])]))
    R = U @ np.diag([1, 1, np.linalg.det(U @ Vt)]) @ Vt
    return se3.pose(R, M[:, 2])


def camera_and_board(X_CB: np.ndarray, X_WE: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """X_CW and X_EB from poses X_CB, X_WE (n, 4, 4) with X_CB = X_CW X_WE X_EB (robot-world and hand-eye at once; Shah 2013).

    Raises:
        InputError: where the hand does not turn enough about two axes.
    """
    turned = [se3.log_so3(X_WE[0, :3, :3].T @ X[:3, :3]) for X in X_WE[1:]]
    if len(X_WE) < 3 or np.linalg.svd(np.array(turned))[1][1] < np.deg2rad(5.0):
        raise InputError(
            f"calibrate: needs 3 or more views between which the hand turns about two axes by some degrees, got {len(X_WE)} views"
        )
    K = sum(np.kron(B[:3, :3], A[:3, :3]) for A, B in zip(X_CB, X_WE, strict=True))
    U, _, Vt = np.linalg.svd(K)
    # R_CB R_BE = R_CW R_WE: the vectors of R_BE and R_CW that agree best.
    R_CW, R_EB = _rotation(U[:, 0].reshape(3, 3).T), _rotation(Vt[0].reshape(3, 3).T).T
    return _translations(X_CB, X_WE, R_CW, R_EB)


def _rotation(M: np.ndarray) -> np.ndarray:
    """The rotation nearest to a multiple (of either sign) of M."""
    U, _, Vt = np.linalg.svd(M * np.sign(np.linalg.det(M)))
    return U @ Vt


def _translations(X_CB, X_WE, R_CW, R_EB):
    rows = np.concatenate([np.hstack([np.eye(3), R_CW @ X[:3, :3]]) for X in X_WE])
    right = np.concatenate([A[:3, 3] - R_CW @ X[:3, 3] for A, X in zip(X_CB, X_WE, strict=True)])
    p = np.linalg.lstsq(rows, right, rcond=None)[0]
    return se3.pose(R_CW, p[:3]), se3.pose(R_EB, p[3:])
