"""Affine or quadratic motion of the image points from displacements along the edge normals, by an M-estimator.

Source: paper III-B, equations 26 to 34; the quadratic model is the option named in III-A. Image coordinates in px. A displacement ``d`` is
measured along the unit normal ``n`` at the point ``p`` only (the aperture problem): ``d = n . W(p) Theta'``.
"""

from dataclasses import dataclass, field

import cv2
import numpy as np

from vipr.systems.errors import InputError

PARAMETERS = {"affine": 6, "quadratic": 12}
ESTIMATORS = ("tukey", "huber", "none")
TIKHONOV = 1e-3  # of the mean square of a basis function: motions seen less than this are taken as none
SCALE_FLOOR = 0.05  # px: displacements are not measured better than this, whatever their agreement says


@dataclass(frozen=True, eq=False)
class MotionModel:
    """Motion of the image points from one frame to the next; of nothing seen, none."""

    model: str = "affine"
    theta: np.ndarray = field(default_factory=lambda: np.zeros((2, 3)))
    """(2, 3) or (2, 6): displacement [px] along x and y by the basis (1, x, y[, x^2, xy, y^2]) of normalised points."""
    centre: np.ndarray = field(default_factory=lambda: np.zeros(2))  # px
    size: float = 1.0  # px; a normalised point is (p - centre)/size
    weights: np.ndarray = field(default_factory=lambda: np.zeros(0))  # (N,) of the M-estimator, 0 to 1
    scale: float = float("nan")  # px, 1.48 MAD of the residuals
    valid: bool = False  # whether enough displacements determined all parameters

    @property
    def Theta(self) -> np.ndarray:
        """(6,) the paper's (a1, a2, a3, a4, Tx, Ty) of equation 26 (of a quadratic model its affine part about the centre)."""
        A = np.eye(2) + self.theta[:, 1:3] / self.size
        T = self.theta[:, 0] + self.centre - A @ self.centre
        return np.array([A[0, 0], A[0, 1], A[1, 0], A[1, 1], T[0], T[1]])


def _basis(points, centre, size, model):
    """(3, N) or (6, N): the monomials of the normalised points."""
    basis = np.ones((PARAMETERS[model] // 2, len(points)))
    x, y = basis[1:3] = (points.T - centre[:, None]) / size
    if model == "quadratic":
        basis[3:] = x * x, x * y, y * y
    return basis


def fit_affine(
    points: np.ndarray,
    normals: np.ndarray,
    displacements: np.ndarray,
    *,
    model: str = "affine",
    estimator: str = "tukey",
    weights: np.ndarray | None = None,
    iterations: int = 8,
    tolerance: float = 0.02,
) -> MotionModel:
    """Motion that explains displacements (N,) [px] along unit normals (N, 2) at points (N, 2) [px] (equation 32).

    Iteratively reweighted least squares with the robust scale 1.48 MAD; the Tukey estimator starts from Huber's solution. NaN
    displacements (edge not found) are left out; ``weights`` (N,) are prior confidences. Motions that the data do not show (few nodes,
    parallel normals) are zero rather than wild. Stops when no parameter moves by more than tolerance [px]. Raises InputError for wrong
    shapes or names.
    """
    points, normals, displacements = (np.asarray(a, float) for a in (points, normals, displacements))
    n = len(displacements)
    if model not in PARAMETERS:
        raise InputError(f"affine fit: unknown model {model!r}, allowed are {', '.join(PARAMETERS)}")
    if estimator not in ESTIMATORS:
        raise InputError(f"affine fit: unknown estimator {estimator!r}, allowed are {', '.join(ESTIMATORS)}")
    if points.shape != (n, 2) or normals.shape != (n, 2) or displacements.shape != (n,):
        raise InputError(
            f"affine fit: needs points (N, 2), normals (N, 2) and displacements (N,), "
            f"got {points.shape}, {normals.shape} and {displacements.shape}"
        )
    prior = np.ones(n) if weights is None else np.asarray(weights, float)
    # One sum is finite where all of its terms are.
    seen = np.isfinite(displacements + points[:, 0] + points[:, 1] + normals[:, 0] + normals[:, 1]) & (prior > 0)
    m = int(seen.sum())
    if m == 0:
        return MotionModel(model=model, theta=np.zeros((2, PARAMETERS[model] // 2)), weights=np.zeros(n))
    if m < n:
        points, normals, displacements, prior = points[seen], normals[seen], displacements[seen], prior[seen]
    centre = points.mean(axis=0)
    size = max(float(np.sqrt(points.var(axis=0).sum())), 1.0)
    basis = _basis(points, centre, size, model)
    rows = np.concatenate([normals[:, 0] * basis, normals[:, 1] * basis])
    theta, w, scale = _reweighted(rows, displacements, prior, estimator, iterations, tolerance)
    values = np.linalg.eigvalsh((rows * w) @ rows.T)
    all_weights = np.zeros(n)
    all_weights[seen] = w / prior
    valid = bool(m > PARAMETERS[model] and values[0] > 3 * TIKHONOV * values.mean())
    return MotionModel(model, theta.reshape(2, -1), centre, size, all_weights, scale, valid)


def _reweighted(rows, displacements, prior, estimator, iterations, tolerance):
    theta = _solve(rows, displacements, prior)
    w, scale = prior, SCALE_FLOOR
    middle = len(displacements) // 2
    for i in range(iterations if estimator != "none" else 0):
        residuals = np.abs(displacements - theta @ rows)
        scale = max(1.48 * float(np.partition(residuals, middle)[middle]), SCALE_FLOOR)
        if estimator == "huber" or i < 2:
            w = prior * np.minimum(1.0, 1.345 * scale / (residuals + 1e-9))
        else:
            t = residuals / (4.685 * scale)
            t *= -t
            t += 1.0
            w = prior * np.maximum(t, 0.0) ** 2
        previous, theta = theta, _solve(rows, displacements, w)
        if i >= 3 and np.abs(theta - previous).max() < tolerance:
            break
    return theta, w, scale


def _solve(rows, displacements, w):
    """Weighted least squares; directions with hardly any information give zero: eigenvalue v counts as v^2/(v^2 + e^2)."""
    weighted = rows * w
    H = weighted @ rows.T
    # (H^2 + e^2)^-1 H g: one small solve instead of an eigendecomposition; OpenCV's has a fifth of numpy's overhead.
    square = H @ H
    square.flat[:: len(H) + 1] += (TIKHONOV * H.trace() / len(H)) ** 2 + 1e-30
    return cv2.solve(square, H @ (weighted @ displacements[:, None]), flags=cv2.DECOMP_CHOLESKY)[1].ravel()


def move_points(motion: MotionModel, points: np.ndarray) -> np.ndarray:
    """Points (..., 2) [px] where the motion takes them (equation 33)."""
    points = np.asarray(points, float)
    flat = points.reshape(-1, 2)
    return (flat + (motion.theta @ _basis(flat, motion.centre, motion.size, motion.model)).T).reshape(points.shape)
