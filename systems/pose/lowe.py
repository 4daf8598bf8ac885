"""Refinement of a pose on image points: Lowe's parametrisation, and the fully projective one of Araujo, Carceroni and Brown.

Sources: Lowe 1991; Araujo, Carceroni, Brown, CVIU 70(2) 1998 (the "extension of Lowe's nonlinear approach" of paper III-A). Frames: O
object, C camera (x right, y down, z forward). Both rotate by left increments, ``R <- exp(w) R`` (rotation vector in C about the origin of
O), so the six parameters are ordered (w, translation) as everywhere in this package.

* ``projective``: ``u = fx (x + Dx)/(z + Dz) + cx`` with ``(x, y, z) = R p`` and D the position of O in C [m]. Unbiased.
* ``lowe``: ``u = fx x/(z + Dz) + Dx + cx``: the translation across the image is added *in* the image (Dx, Dy in pixels). That decouples
  the parameters but is wrong off the optical axis: the rotation is then biased by the angle of the line of sight.
"""

from dataclasses import dataclass

import numpy as np

from vipr.systems import se3
from vipr.systems.camera.lens import Lens
from vipr.systems.errors import InputError

METHODS = ("projective", "lowe")
LOSSES = ("none", "huber", "tukey")
NEAR = 1e-6  # m: points closer than this to the camera's plane cannot be projected


@dataclass(frozen=True)
class Refinement:
    """Where the refinement ended."""

    X_CO: np.ndarray  # (4, 4)
    residuals: np.ndarray  # (N, 2) px, seen minus projected by the method's own camera model
    jacobian: np.ndarray  # (N, 2, 6) of the projected pixels by (w, D); D in m for projective, (px, px, m) for lowe
    weights: np.ndarray  # (N,) of the M-estimator, 0 to 1
    scale: float  # px, robust standard deviation of one coordinate
    iterations: int
    converged: bool


def project(points_O: np.ndarray, R: np.ndarray, D: np.ndarray, lens: Lens, method: str = "projective"):
    """Pixels (N, 2) and depths (N,) [m] of points (N, 3); D is (m, m, m) for projective, (px, px, m) for lowe."""
    x, y, z = (points_O @ R.T).T
    depth = z + D[2]
    c = 1.0 / np.where(depth > NEAR, depth, np.nan)
    if method == "lowe":
        return np.column_stack([lens.fx * x * c + D[0] + lens.cx, lens.fy * y * c + D[1] + lens.cy]), depth
    return np.column_stack([lens.fx * (x + D[0]) * c + lens.cx, lens.fy * (y + D[1]) * c + lens.cy]), depth


def jacobian(points_O: np.ndarray, R: np.ndarray, D: np.ndarray, lens: Lens, method: str = "projective") -> np.ndarray:
    """(N, 2, 6) derivatives of `project` by (w, D)."""
    x, y, z = (points_O @ R.T).T
    c = 1.0 / (z + D[2])
    U, V = (x, y) if method == "lowe" else (x + D[0], y + D[1])
    J = np.zeros((len(points_O), 2, 6))
    a, b = lens.fx * c, lens.fy * c
    J[:, 0, 0], J[:, 0, 1], J[:, 0, 2] = -a * c * U * y, a * (z + c * U * x), -a * y
    J[:, 1, 0], J[:, 1, 1], J[:, 1, 2] = -b * (z + c * V * y), b * c * V * x, b * x
    J[:, 0, 3], J[:, 1, 4] = (1.0, 1.0) if method == "lowe" else (a, b)
    J[:, 0, 5], J[:, 1, 5] = -a * c * U, -b * c * V
    return J


def to_lowe(p_CO: np.ndarray, lens: Lens) -> np.ndarray:
    """Lowe's (px, px, m) of a position (3,) [m]."""
    return np.array([lens.fx * p_CO[0] / p_CO[2], lens.fy * p_CO[1] / p_CO[2], p_CO[2]])


def from_lowe(D: np.ndarray, lens: Lens) -> np.ndarray:
    """Position (3,) [m] of Lowe's (px, px, m)."""
    return np.array([D[0] * D[2] / lens.fx, D[1] * D[2] / lens.fy, D[2]])


def robust_weights(distances: np.ndarray, scale: float, loss: str) -> np.ndarray:
    """Weights (N,) of the M-estimator for distances (N,) at 95 % efficiency for normal errors."""
    if loss == "none":
        return np.ones_like(distances)
    t = distances / max(scale, 1e-12)
    if loss == "huber":
        return np.minimum(1.0, 1.345 / np.maximum(t, 1e-12))
    return np.square(np.maximum(0.0, 1.0 - np.square(t / 4.685)))


def refine(
    points_O: np.ndarray,
    pixels: np.ndarray,
    lens: Lens,
    X_CO: np.ndarray,
    *,
    method: str = "projective",
    loss: str = "none",
    iterations: int = 30,
    tolerance: float = 1e-10,
) -> Refinement:
    """Levenberg-Marquardt on the pixels from the pose X_CO, with M-estimator weights renewed at every step.

    points_O (N, 3) [m], pixels (N, 2) of the undistorted image. Stops when a step is below tolerance (rad, and that share of the depth).
    The damping is Lowe's: steps of pi/4 rad and of one object size are a priori normal. Raises InputError for an unknown method or loss.
    """
    if method not in METHODS:
        raise InputError(f"pose refinement: unknown method {method!r}, allowed are {', '.join(METHODS)}")
    if loss not in LOSSES:
        raise InputError(f"pose refinement: unknown loss {loss!r}, allowed are {', '.join(LOSSES)}")
    R, D = X_CO[:3, :3].copy(), X_CO[:3, 3].copy()
    size = max(float(np.abs(points_O - points_O.mean(axis=0)).max()), 1e-9)
    usual = np.array([np.pi / 4] * 3 + [size] * 3)
    if method == "lowe":
        D = to_lowe(D, lens)
        usual[3:5] *= (lens.fx / D[2], lens.fy / D[2])
    unit = np.concatenate([np.ones(3), usual[3:]])
    residuals, ok = _residuals(points_O, pixels, R, D, lens, method)
    if not ok:
        return Refinement(X_CO, residuals, np.zeros((len(points_O), 2, 6)), np.zeros(len(points_O)), np.inf, 0, False)
    damping, converged, n = 1.0, False, 0
    scale = _scale(residuals) if loss != "none" else 1.0
    weights = robust_weights(np.linalg.norm(residuals, axis=1), scale, loss)
    J = jacobian(points_O, R, D, lens, method)
    for n in range(1, iterations + 1):
        Jw = (J * weights[:, None, None]).reshape(-1, 6)
        H, g = Jw.T @ J.reshape(-1, 6), Jw.T @ residuals.ravel()
        cost = _cost(residuals, weights)
        for _ in range(8):
            step = _solve(H + np.diag(damping / usual**2), g)
            R_new, D_new = se3.exp_so3(step[:3]) @ R, D + step[3:]
            residuals_new, ok = _residuals(points_O, pixels, R_new, D_new, lens, method)
            if ok and _cost(residuals_new, weights) <= cost * (1 + 1e-12):
                break
            damping *= 10.0
        else:
            converged = cost < 1e-12 * len(points_O)
            break
        R, D, residuals, damping = R_new, D_new, residuals_new, damping * 0.1
        J = jacobian(points_O, R, D, lens, method)
        if loss != "none":
            if n <= 5:  # then held, or weights and scale chase each other for ever
                scale = _scale(residuals)
            weights = robust_weights(np.linalg.norm(residuals, axis=1), scale, loss)
        if np.max(np.abs(step / unit)) < tolerance:
            converged = True
            break
    if loss == "none":
        scale = float(np.sqrt(np.sum(residuals**2) / max(2 * len(points_O) - 6, 1)))
    X_CO = se3.pose(_orthonormal(R), from_lowe(D, lens) if method == "lowe" else D)
    return Refinement(X_CO, residuals, J, weights, scale, n, converged)


def _residuals(points_O, pixels, R, D, lens, method):
    projected, depth = project(points_O, R, D, lens, method)
    residuals = pixels - projected
    return residuals, bool((depth > NEAR).all() and np.isfinite(residuals).all())


def _cost(residuals, weights):
    return float(np.sum(weights[:, None] * residuals**2))


def _scale(residuals):
    """Standard deviation of one coordinate from the median distance (median of a Rayleigh distribution: 1.177 sigma)."""
    n = len(residuals)
    return float(np.median(np.linalg.norm(residuals, axis=1)) / 1.1774 * np.sqrt(2 * n / max(2 * n - 6, 2))) + 1e-9


def _solve(H, g):
    try:
        return np.linalg.solve(H, g)
    except np.linalg.LinAlgError:
        return np.linalg.lstsq(H, g, rcond=1e-9)[0]


def _orthonormal(R):
    U, _, Vt = np.linalg.svd(R)
    return U @ Vt
