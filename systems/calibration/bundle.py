"""Bundle adjustment: intrinsics, camera in the world, board in the hand and small errors of the arm, from all corners at once.

The corner p_B of view i is seen at ``project(X_CW X_WE_i exp(e_i) X_EB p_B)``; e_i (w, v) in E is the error of the arm's own pose of that
view, expected as small as the arm is accurate. Levenberg-Marquardt on the weighted squares of pixel residuals and e_i / sigma; corners far
from the fit are left out; the covariance is that of the last linearisation, at the noise that the residuals show.
"""

from dataclasses import dataclass

import numpy as np

from vipr.systems import se3
from vipr.systems.errors import InputError

INTRINSICS = ("fx", "fy", "cx", "cy", "k1", "k2")
OUTLIER = 4.0  # standard deviations of a corner that is left out
ROUNDS = 3  # of estimating noise and outliers anew
# px, and share of corners left out: above, the views and poses do not belong together.
WORST_NOISE, WORST_SHARE = 3.0, 0.5
DISAGREE = (
    "the images and the poses of the hand do not agree; are the poses those of the hand in the world, in metres, taken with these images, "
    "and is the board's square_mm right?"
)


@dataclass(frozen=True)
class ArmAccuracy:
    """How well the arm knows where its hand is (1 sigma)."""

    position_mm: float = 0.1
    rotation_deg: float = 0.01

    def __post_init__(self):
        for name in self.__dataclass_fields__:
            if not 1e-6 <= getattr(self, name) <= 1e3:
                raise InputError(f"calibrate: the arm's {name} must be 1e-6 to 1000, got {getattr(self, name):g}")

    @property
    def sigma(self) -> np.ndarray:
        return np.repeat([np.deg2rad(self.rotation_deg), 1e-3 * self.position_mm], 3)


@dataclass(frozen=True, eq=False)
class Observations:
    """N corners of n views: which view, where on the board, where in the image; and the arm's pose of each view."""

    view: np.ndarray  # (N,)
    points_B: np.ndarray  # (N, 3) m
    pixels: np.ndarray  # (N, 2)
    X_WE: np.ndarray  # (n, 4, 4)


@dataclass(frozen=True, eq=False)
class Model:
    """What is estimated; ``intrinsics`` are fx, fy, cx, cy [px], k1, k2."""

    intrinsics: np.ndarray  # (6,)
    X_CW: np.ndarray
    X_EB: np.ndarray
    arm_errors: np.ndarray  # (n, 6)


@dataclass(frozen=True, eq=False)
class Fit:
    """A model with what is known of its errors.

    ``covariance`` is of (the intrinsics that were free, X_CW, X_EB): perturbations exp(x) X_CW and X_EB exp(x), x = (w, v).
    """

    model: Model
    free: tuple[int, ...]  # of INTRINSICS
    covariance: np.ndarray
    used: np.ndarray  # (N,) corners that were not left out
    residuals: np.ndarray  # (N, 2) px, of all corners
    noise: float  # px, of a corner's coordinate


def adjust(
    observations: Observations, start: Model, *, radial: int = 0, arm: ArmAccuracy = ArmAccuracy(), noise: float = 0.1
) -> Fit:
    """The model that fits best.

    Args:
        observations: corners and arm poses.
        start: near the solution.
        radial: how many coefficients of radial distortion are estimated, 0 to 2; the others stay as they are.
        arm: accuracy of X_WE.
        noise: of a corner's coordinate [px], first guess.

    Raises:
        InputError: when the views do not determine all parameters.
    """
    free = tuple(range(4 + radial))
    used, model = np.ones(len(observations.pixels), bool), start
    for _ in range(ROUNDS):
        model, _, fitted = _levenberg_marquardt(observations, model, free, used, arm, noise)
        residuals, *_ = _linearise(observations, model, free)
        size = np.linalg.norm(residuals, axis=1)
        freedom = max(2 * int(used.sum()) - fitted, 1.0)
        noise = max(float(np.sqrt(np.sum(residuals[used] ** 2) / freedom)), 1e-3)
        robust = 1.4826 * np.median(np.abs(residuals[used]))
        used = size < OUTLIER * max(robust, 1e-3) * np.sqrt(2.0)
    model, normal, _ = _levenberg_marquardt(observations, model, free, used, arm, noise)
    residuals, *_ = _linearise(observations, model, free)
    _require_determined(normal, free)
    if noise > WORST_NOISE or np.mean(used) < 1.0 - WORST_SHARE:
        raise InputError(f"calibrate: {noise:.1f} px a corner, {np.mean(~used):.0%} left out: {DISAGREE}")
    k = len(free) + 12
    return Fit(model, free, np.linalg.inv(normal)[:k, :k], used, residuals, noise)


def _require_determined(normal: np.ndarray, free: tuple[int, ...]) -> None:
    scale = 1.0 / np.sqrt(np.maximum(np.diag(normal), 1e-300))
    values, vectors = np.linalg.eigh(normal * np.outer(scale, scale))
    if values[0] < 1e-10:
        names = [*(INTRINSICS[k] for k in free), *["X_WC"] * 6, *["X_EB"] * 6]
        worst = int(np.argmax(np.abs(vectors[: len(names), 0])))
        raise InputError(
            f"calibrate: the views do not determine {names[worst]}; more views, turned about two axes and at different distances, would"
        )


def _levenberg_marquardt(observations, model, free, used, arm, noise):
    """The best model, the normal matrix there, and how many parameters the pixels determine: what the arm already knew counts less."""
    damping = 1e-3
    for _ in range(60):
        residuals, J = _linearise(observations, model, free)
        if J is None:
            raise InputError(f"calibrate: {DISAGREE}")
        r, J = (residuals[used] / noise).ravel(), J[used].reshape(-1, J.shape[2]) / noise
        prior = (model.arm_errors / arm.sigma).ravel()
        now = r @ r + prior @ prior
        of_pixels = J.T @ J
        normal = of_pixels.copy()
        gradient = J.T @ r
        at = normal.shape[0] - len(prior)
        weight = 1.0 / np.tile(arm.sigma, len(model.arm_errors))
        normal[np.arange(at, len(normal)), np.arange(at, len(normal))] += weight**2
        gradient[at:] += weight * prior
        improved = False
        while damping < 1e10:
            step = -np.linalg.solve(normal + damping * np.diag(np.diag(normal) + 1e-12), gradient)
            new = _moved(model, free, step)
            after, _ = _linearise(observations, new, free, derivatives=False)
            new_prior = new.arm_errors / arm.sigma
            value = np.sum((after[used] / noise) ** 2) + np.sum(new_prior**2)
            if value <= now:
                model, damping, improved = new, max(damping / 10.0, 1e-12), True
                break
            damping *= 10.0
        if not improved or now - value < 1e-9 * now:
            break
    return model, normal, float(np.trace(np.linalg.lstsq(normal, of_pixels, rcond=None)[0]))


def _moved(model: Model, free: tuple[int, ...], step: np.ndarray) -> Model:
    k = len(free)
    intrinsics = model.intrinsics.copy()
    intrinsics[list(free)] += step[:k]
    arm_errors = model.arm_errors + step[k + 12 :].reshape(-1, 6)
    X_CW, X_EB = se3.exp(step[k : k + 6]) @ model.X_CW, model.X_EB @ se3.exp(step[k + 6 : k + 12])
    return Model(intrinsics, X_CW, X_EB, arm_errors)


def _linearise(observations, model: Model, free, derivatives: bool = True):
    """Residuals (N, 2) [px] and their derivatives (N, 2, parameters)."""
    o, n = observations, len(observations.X_WE)
    X_EB, R_EB = model.X_EB, model.X_EB[:3, :3]
    X_CE = np.array([model.X_CW @ X @ se3.exp(e) for X, e in zip(o.X_WE, model.arm_errors, strict=True)])[o.view]
    p_E = o.points_B @ R_EB.T + X_EB[:3, 3]
    p_C = np.einsum("nij,nj->ni", X_CE[:, :3, :3], p_E) + X_CE[:, :3, 3]
    if (p_C[:, 2] < 1e-3).any():
        return np.full((len(p_C), 2), 1e6), None
    fx, fy, cx, cy, k1, k2 = model.intrinsics
    xy = p_C[:, :2] / p_C[:, 2:]
    r2 = (xy**2).sum(axis=1)
    swell = 1.0 + k1 * r2 + k2 * r2**2
    bent = xy * swell[:, None]
    residuals = bent * [fx, fy] + [cx, cy] - o.pixels
    if not derivatives:
        return residuals, None
    # Of the distorted point in the undistorted one, and of that in p_C.
    slope = k1 + 2.0 * k2 * r2
    D = swell[:, None, None] * np.eye(2) + 2.0 * slope[:, None, None] * xy[:, :, None] * xy[:, None, :]
    P = np.zeros((len(xy), 2, 3))
    P[:, 0, 0] = P[:, 1, 1] = 1.0 / p_C[:, 2]
    P[:, :, 2] = -xy / p_C[:, 2:]
    G = np.array([fx, fy])[None, :, None] * (D @ P)
    zero = np.zeros(len(xy))
    of_intrinsics = np.stack(
        [
            np.column_stack([bent[:, 0], zero]),
            np.column_stack([zero, bent[:, 1]]),
            np.column_stack([zero + 1.0, zero]),
            np.column_stack([zero, zero + 1.0]),
            [fx, fy] * xy * r2[:, None],
            [fx, fy] * xy * r2[:, None] ** 2,
        ],
        axis=2,
    )[:, :, list(free)]
    G_E = G @ X_CE[:, :3, :3]
    J_CW = np.concatenate([-G @ _skews(p_C), G], axis=2)
    J_EB = np.concatenate([-(G_E @ R_EB) @ _skews(o.points_B), G_E @ R_EB], axis=2)
    J_arm = np.zeros((len(xy), 2, n, 6))
    J_arm[np.arange(len(xy)), :, o.view] = np.concatenate([-G_E @ _skews(p_E), G_E], axis=2)
    return residuals, np.concatenate([of_intrinsics, J_CW, J_EB, J_arm.reshape(len(xy), 2, -1)], axis=2)


def _skews(p: np.ndarray) -> np.ndarray:
    """(N, 3, 3) of (N, 3)."""
    S = np.zeros((len(p), 3, 3))
    S[:, 0, 1], S[:, 0, 2], S[:, 1, 2] = -p[:, 2], p[:, 1], -p[:, 0]
    return S - S.swapaxes(1, 2)
