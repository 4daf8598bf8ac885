"""Pose from edge displacements: robust Gauss-Newton over several hypotheses a node, coarse to fine.

Displacements d = (w, v) turn the object about its own origin and move it, both expressed in C: ``R' = exp(w) R``, ``t' = t + v``
(rad, m). Normal displacement of a node with image normal n: ``J d``; the rows of J are (q x g, g) with q = R p_O and
g = n' du/dp_C.
"""

from dataclasses import dataclass

import cv2
import numpy as np

from vipr.systems import se3
from vipr.systems.camera.lens import Lens
from vipr.systems.tracking.cad_model import CadModel
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
    spread: float = 0.0  # px^2, variance of what the nodes of an edge have in common


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
    x, y, z = q.T[:, :, None]
    gx, gy, gz = J[:, :, 3], J[:, :, 4], J[:, :, 5]
    J[:, :, 0] = y * gz - z * gy
    J[:, :, 1] = z * gx - x * gz
    J[:, :, 2] = x * gy - y * gx
    return J


def normal_jacobian(nodes: Nodes, X_CO: np.ndarray, lens: Lens) -> np.ndarray:
    """(N, 6) derivative of the nodes' displacement along their normals [px] by d."""
    q = nodes.p_O @ X_CO[:3, :3].T
    p = q + X_CO[:3, 3]
    J = np.empty((len(q), 6))
    inverse = 1.0 / p[:, 2]
    gx = nodes.normal[:, 0] * (lens.fx * inverse)
    gy = nodes.normal[:, 1] * (lens.fy * inverse)
    gz = -(gx * p[:, 0] + gy * p[:, 1]) * inverse
    x, y, z = q.T
    J[:, 0], J[:, 1], J[:, 2] = y * gz - z * gy, z * gx - x * gz, x * gy - y * gx
    J[:, 3], J[:, 4], J[:, 5] = gx, gy, gz
    return J


def tukey(r: np.ndarray, c: float) -> np.ndarray:
    """Tukey's weight of residuals: (1 - (r/c)^2)^2 inside c, 0 outside."""
    inside = np.maximum(1.0 - (r / c) ** 2, 0.0)
    return inside * inside


def damping(J: np.ndarray, scale: float = 1e-4) -> np.ndarray:
    """(6, 6) a trace of information on every displacement, so that what the nodes do not see stays where it is."""
    H = np.zeros((6, 6))
    H.flat[::7] = scale * (J * J).sum(0) + 1e-12
    return H


def fit_pose(
    J: np.ndarray,
    matches: Matches,
    preference: np.ndarray,
    widths: tuple[float, ...],
    prior: Prior | None = None,
    edge: np.ndarray | None = None,
    noise_floor: float = 0.2,
    model_error: float = 0.1,
    doubt: float = 1.0,
    node_weight: np.ndarray | float = 1.0,
    spread: float | None = None,
    anneal: bool = True,
) -> Fit:
    """Displacement that brings the nodes to their edges.

    preference (N, K): how likely each hypothesis is its node's edge before its place is looked at, 0 (absent) to 1. widths [px]: in
    each pass hypotheses share a node's pull in proportion to preference and to a Gaussian of that width about the prediction; passes go
    from wide to narrow. The last ones end with Tukey's weights about the nearest hypothesis.

    edge (N,): which edge each node is on. What the nodes of one edge have in common (a model that is a little wrong, a shadow
    beside the edge) does not average out over them: the residuals' spread between edges, at least model_error [px], is counted once
    an edge, in the weights and in the information; `doubt` multiplies the spread, and `spread` [px^2]
    stands for it if given. node_weight (N,): 0 to 1, confidence in a node from elsewhere. Without anneal, only
    the nearest hypotheses about no displacement are looked at.
    """
    N = len(J)
    prior_information = prior.information if prior is not None else np.zeros((6, 6))
    prior_pull = prior_information @ prior.mean if prior is not None else np.zeros(6)
    d = np.zeros(6)
    present = preference > 0
    if N == 0 or not present.any():
        return Fit(d, prior_information, np.full(N, np.nan), np.zeros(N, int), np.zeros(N), float("nan"))
    base = damping(J) + prior_information
    Jt = np.ascontiguousarray(J.T)
    offset = np.where(present, matches.offset, 0.0)
    far = np.where(present, matches.offset, 1e3)
    for width in widths if anneal else ():
        r = far - (J @ d)[:, None]
        share = preference * np.exp((-0.5 / width**2) * (r * r))
        total = share.sum(1)
        # A node with nothing near its prediction says nothing.
        w = node_weight * total / ((total + 0.1) * max(width, noise_floor) ** 2)
        target = (share * offset).sum(1) / (total + 1e-12)
        WJ = Jt * w
        d = solve(WJ @ J + base, WJ @ target + prior_pull)
    rows = np.arange(N)
    far_preferred = 2.0 * widths[-1] * (1.0 - preference)
    members = np.bincount(edge) if edge is not None else None
    common, own = 1.0, 0.0
    for _ in range(3):
        r = far - (J @ d)[:, None]
        chosen = (np.abs(r) + far_preferred).argmin(1)
        residual = r[rows, chosen]
        magnitude = np.abs(residual)
        near = magnitude[magnitude < 4.0 * widths[-1]]
        half = len(near) // 2
        sigma = max(1.4826 * float(np.partition(near, half)[half]), noise_floor) if len(near) else widths[-1]
        sigma = min(sigma, widths[-1])
        w = node_weight * tukey(residual, 4.685 * sigma)  # of what is absent: 0
        if edge is not None:
            held = np.bincount(edge, w)
            mean = np.bincount(edge, w * residual) / np.maximum(held, 1e-9)
            mean = mean[held > 0.3 * members]
            # The pose has taken up some of it, and noise makes some.
            noise = sigma**2 * len(mean) / max(float(w.sum()), 1.0)
            own = spread if spread is not None else max(float(mean @ mean) / max(len(mean) - 4, 1) - noise, 0.0)
            common = 1.0 / (1.0 + held * (max(doubt * own, model_error**2) / sigma**2))[edge]
        WJ = Jt * (w * common / sigma**2)
        H = WJ @ J
        d = solve(H + base, WJ @ offset[rows, chosen] + prior_pull)
    residual = np.where(present[rows, chosen], (far - (J @ d)[:, None])[rows, chosen], np.nan)
    return Fit(d, H + prior_information, residual, chosen, w, sigma, own)


def solve(H: np.ndarray, g: np.ndarray) -> np.ndarray:
    """x of H x = g for a small symmetric positive H; by OpenCV, which has a fraction of numpy's overhead."""
    scale = 1.0 / np.sqrt(H.diagonal())  # metres and radians side by side
    ok, x = cv2.solve(H * scale * scale[:, None], (g * scale)[:, None], flags=cv2.DECOMP_CHOLESKY)
    return x[:, 0] * scale if ok else np.linalg.lstsq(H, g, rcond=None)[0]


def fit_points(
    p_O: np.ndarray, pixel: np.ndarray, weight: np.ndarray, X_CO: np.ndarray, lens: Lens, iterations: int = 3
) -> np.ndarray:
    """POSE from points moved in the image (paper Fig. 6): X_CO refined until p_O (N, 3) project to pixel (N, 2)."""
    for _ in range(iterations):
        p_C = p_O @ X_CO[:3, :3].T + X_CO[:3, 3]
        J = point_jacobian(p_O, X_CO, lens).reshape(-1, 6)
        r = (pixel - lens.project(p_C)).reshape(-1)
        WJ = J * np.repeat(weight, 2)[:, None]
        X_CO = move(X_CO, solve(J.T @ WJ + damping(J, 1e-5), WJ.T @ r))
    return X_CO


def corner_information(model: CadModel, X_CO: np.ndarray, lens: Lens, pixels: float) -> np.ndarray:
    """(6, 6) information of a pose whose projected model corners are each known to `pixels` RMS."""
    J = point_jacobian(model.corners, X_CO, lens).reshape(-1, 6)
    return J.T @ J / pixels**2


def corner_shift(model: CadModel, lens: Lens, X_CA: np.ndarray, X_CB: np.ndarray) -> float:
    """RMS px between the projections of the model's corners at two poses; 1000 behind the camera."""
    ends = []
    for X in (X_CA, X_CB):
        p_C = model.corners @ X[:3, :3].T + X[:3, 3]
        if p_C[:, 2].min() <= 1e-3:
            return 1e3
        ends.append(lens.project(p_C))
    off = ends[0] - ends[1]
    return float(np.sqrt((off * off).sum() / len(off)))
