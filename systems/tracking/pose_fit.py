"""Pose from edge displacements: robust Gauss-Newton over several hypotheses a node, coarse to fine.

Displacements d = (w, v) turn the object about its own origin and move it, both expressed in C: ``R' = exp(w) R``, ``t' = t + v``
(rad, m). Normal displacement of a node with image normal n: ``J d``; the rows of J are (q x g, g) with q = R p_O and
g = n' du/dp_C.
"""

from dataclasses import dataclass

import numpy as np

from vipr.systems import se3
from vipr.systems.camera.lens import Lens
from vipr.systems.tracking.normal_flow import Matches
from vipr.systems.tracking.visible_edges import Nodes


@dataclass(frozen=True, eq=False)
class Fit:
    """A pose displacement and how well the nodes agree with it."""

    d: np.ndarray  # (6,) (w, v)
    information: np.ndarray  # (6, 6) of d, for the noise in `sigma`
    residual: np.ndarray  # (N,) px to the chosen hypothesis; nan where there is none
    chosen: np.ndarray  # (N,) index of the hypothesis
    weight: np.ndarray  # (N,) 0 to 1
    sigma: float  # px, robust RMS residual


@dataclass(frozen=True, eq=False)
class Prior:
    """What other cues say of the displacement d: Gaussian with mean and information."""

    mean: np.ndarray  # (6,)
    information: np.ndarray  # (6, 6)


def move(X_CO: np.ndarray, d: np.ndarray) -> np.ndarray:
    """The pose displaced by d = (w, v)."""
    X = np.eye(4)
    X[:3, :3] = se3.exp_so3(d[:3]) @ X_CO[:3, :3]
    X[:3, 3] = X_CO[:3, 3] + d[3:]
    return X


def difference(X_CO: np.ndarray, X_CP: np.ndarray) -> np.ndarray:
    """d with ``move(X_CO, d) == X_CP``."""
    return np.r_[se3.log_so3(X_CP[:3, :3] @ X_CO[:3, :3].T), X_CP[:3, 3] - X_CO[:3, 3]]


def point_jacobian(p_O: np.ndarray, X_CO: np.ndarray, lens: Lens) -> np.ndarray:
    """(N, 2, 6) derivative of the pixels of points (N, 3) by d."""
    q = p_O @ X_CO[:3, :3].T
    p = q + X_CO[:3, 3]
    inverse = 1.0 / p[:, 2]
    J = np.zeros((len(p), 2, 6))
    J[:, 0, 3] = lens.fx * inverse
    J[:, 0, 5] = -lens.fx * p[:, 0] * inverse**2
    J[:, 1, 4] = lens.fy * inverse
    J[:, 1, 5] = -lens.fy * p[:, 1] * inverse**2
    J[:, :, :3] = np.cross(q[:, None], J[:, :, 3:])
    return J


def normal_jacobian(nodes: Nodes, X_CO: np.ndarray, lens: Lens) -> np.ndarray:
    """(N, 6) derivative of the nodes' displacement along their normals [px] by d."""
    q = nodes.p_O @ X_CO[:3, :3].T
    p = q + X_CO[:3, 3]
    J = np.empty((len(q), 6))
    g = J[:, 3:]
    np.multiply(nodes.normal, (lens.fx, lens.fy), out=g[:, :2])
    g[:, 2] = -(g[:, 0] * p[:, 0] + g[:, 1] * p[:, 1]) / p[:, 2]
    g /= p[:, 2:]
    J[:, 0] = q[:, 1] * g[:, 2] - q[:, 2] * g[:, 1]
    J[:, 1] = q[:, 2] * g[:, 0] - q[:, 0] * g[:, 2]
    J[:, 2] = q[:, 0] * g[:, 1] - q[:, 1] * g[:, 0]
    return J


def tukey(r: np.ndarray, c: float) -> np.ndarray:
    """Tukey's weight of residuals: (1 - (r/c)^2)^2 inside c, 0 outside."""
    inside = 1.0 - np.minimum((r / c) ** 2, 1.0)
    return inside * inside


def damping(J: np.ndarray, scale: float = 1e-4) -> np.ndarray:
    """(6, 6) a trace of information on every displacement, so that what the nodes do not see stays where it is."""
    return np.diag(scale * np.maximum((J * J).sum(0), 1e-12))


def fit_pose(
    J: np.ndarray,
    matches: Matches,
    preference: np.ndarray,
    widths: tuple[float, ...],
    prior: Prior | None = None,
    node_weight: np.ndarray | float = 1.0,
    noise_floor: float = 0.25,
) -> Fit:
    """Displacement that brings the nodes to their edges.

    preference (N, K): how likely each hypothesis is its node's edge before its place is looked at, 0 (absent) to 1. widths [px]: in
    each pass hypotheses share a node's pull in proportion to preference and to a Gaussian of that width about the prediction; passes go
    from wide to narrow. The last ones end with Tukey's weights about the nearest hypothesis.
    """
    N = len(J)
    prior_information = prior.information if prior is not None else np.zeros((6, 6))
    prior_pull = prior_information @ prior.mean if prior is not None else np.zeros(6)
    d = prior.mean.copy() if prior is not None else np.zeros(6)
    present = preference > 0
    if N == 0 or not present.any():
        return Fit(d, prior_information, np.full(N, np.nan), np.zeros(N, int), np.zeros(N), float("nan"))
    base = damping(J) + prior_information
    far = np.where(present, matches.offset, 1e9)
    for width in widths:
        r = far - (J @ d)[:, None]
        share = preference * np.exp(np.maximum(-0.5 * (r / width) ** 2, -50.0))
        total = share.sum(1)
        w = node_weight * total / (total + 0.1)  # a node with nothing near its prediction says nothing
        target = (share * np.where(present, matches.offset, 0.0)).sum(1) / np.maximum(total, 1e-12)
        WJ = J * (w / max(width, noise_floor) ** 2)[:, None]
        d = np.linalg.solve(J.T @ WJ + base, WJ.T @ target + prior_pull)
    rows = np.arange(N)
    for _ in range(3):
        r = far - (J @ d)[:, None]
        chosen = np.argmin(np.abs(r) + 2.0 * widths[-1] * (1.0 - preference), axis=1)
        residual = r[rows, chosen]
        found = present[rows, chosen]
        near = np.abs(residual[found & (np.abs(residual) < 4.0 * widths[-1])])
        sigma = max(1.4826 * float(np.median(near)), noise_floor) if len(near) else widths[-1]
        w = node_weight * tukey(residual, 4.685 * sigma) * found
        WJ = J * (w / sigma**2)[:, None]
        d = np.linalg.solve(J.T @ WJ + base, WJ.T @ np.where(found, matches.offset[rows, chosen], 0.0) + prior_pull)
    residual = np.where(found, (far - (J @ d)[:, None])[rows, chosen], np.nan)
    return Fit(d, J.T @ WJ + prior_information, residual, chosen, w, sigma)
