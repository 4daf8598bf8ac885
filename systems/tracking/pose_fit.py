"""Pose from edge displacements: robust Gauss-Newton over several hypotheses a node, coarse to fine.

Displacements d = (w, v) are those of ``displacements``. Normal displacement of a node with image normal n: ``J d``; the rows of J
are (q x g, g) with q = R p_O and g = n' du/dp_C.
"""

from dataclasses import dataclass, field

import numpy as np

from vipr.systems.camera.lens import Lens
from vipr.systems.compiled import compiled
from vipr.systems.tracking.displacements import damping, move, point_jacobian
from vipr.systems.tracking.normal_flow import Matches
from vipr.systems.tracking.small_algebra import dot6, kth_smallest, mirror, solve


@dataclass(frozen=True, eq=False)
class Fit:
    """A pose displacement and how well the nodes agree with it."""

    d: np.ndarray  # (6,) (w, v)
    information: np.ndarray  # (6, 6) of d
    residual: np.ndarray  # (N,) px to the chosen hypothesis; nan where there is none
    chosen: np.ndarray  # (N,) index of the hypothesis
    weight: np.ndarray  # (N,) 0 to 1
    sigma: float  # px, robust RMS residual
    spread: float = 0.0  # px^2, variance of what the nodes of an edge have in common
    # (6, 6) covariance of the pull, information times d, by what the nodes of an edge have in common: it is the same in the next frame.
    shared: np.ndarray = field(default_factory=lambda: np.zeros((6, 6)))


@dataclass(frozen=True, eq=False)
class Prior:
    """What other cues say of the displacement d: Gaussian with mean and information."""

    mean: np.ndarray  # (6,)
    information: np.ndarray  # (6, 6)


def fit_pose(
    J: np.ndarray,
    matches: Matches,
    preference: np.ndarray,
    widths: tuple[float, ...],
    prior: Prior | None = None,
    edge: np.ndarray | None = None,
    noise: np.ndarray | float = 0.2,
    model_error: np.ndarray | float = 0.1,
    doubt: float = 1.0,
    node_weight: np.ndarray | float = 1.0,
    spread: float | None = None,
    anneal: bool = True,
) -> Fit:
    """Displacement that brings the nodes to their edges.

    preference (N, K): how likely each hypothesis is its node's edge before its place is looked at, 0 (absent) to 1. widths [px]: in
    each pass hypotheses share a node's pull in proportion to preference and to a Gaussian of that width about the prediction; passes go
    from wide to narrow. The last ones end with Tukey's weights about the nearest hypothesis.

    noise (N, K) [px]: least noise of each hypothesis' place; if the residuals speak of more, all count as so many times noisier.
    edge (N,): which edge each node is on. What the nodes of one edge have in common (a model that is a little wrong, a shadow
    beside the edge) does not average out over them: the residuals' spread between edges, at least model_error (N,) [px], is counted once
    an edge, in the weights and in the information; `doubt` multiplies the spread, and `spread` [px^2]
    stands for it if given. node_weight (N,): 0 to 1, confidence in a node from elsewhere. Without anneal, only
    the nearest hypotheses about no displacement are looked at.
    """
    N = len(J)
    information = prior.information if prior is not None else np.zeros((6, 6))
    pull = information @ prior.mean if prior is not None else np.zeros(6)
    if N == 0 or not preference.any():
        return Fit(np.zeros(6), information, np.full(N, np.nan), np.zeros(N, int), np.zeros(N), float("nan"))
    base = damping(J, 1e-4) + information
    own_weight = node_weight * np.ones(N)
    start = np.zeros(6)
    if anneal:
        start = _anneal(J, matches.offset, preference, own_weight, base, pull, np.array(widths))
    d, H, residual, chosen, weight, sigma, own, shared = _refine(
        J,
        matches.offset,
        preference,
        noise * np.ones(preference.shape),
        own_weight,
        base,
        pull,
        start,
        widths[-1],
        np.arange(N) if edge is None else edge,
        edge is not None,
        model_error * np.ones(N),
        doubt,
        -1.0 if spread is None else spread,
    )
    return Fit(d, H + information, residual, chosen, weight, sigma, own, shared)


@compiled
def add_row(H, g, row, weight, target):
    """Normal equations of one more measurement ``row . d = target``; H below the diagonal stays empty until ``mirror``."""
    for i in range(6):
        wi = weight * row[i]
        g[i] += wi * target
        for j in range(i + 1):
            H[i, j] += wi * row[j]


@compiled
def _anneal(J, offset, preference, node_weight, base, pull, widths):
    """Displacement (6,) after one pass of each width in which the hypotheses of a node share its pull."""
    d = np.zeros(6)
    for width in widths:
        H, g = np.zeros((6, 6)), pull.copy()
        for n in range(len(J)):
            predicted, total, mean = dot6(J[n], d), 0.0, 0.0
            for k in range(offset.shape[1]):
                if preference[n, k] > 0.0:
                    r = (offset[n, k] - predicted) / width
                    share = preference[n, k] * np.exp(-0.5 * r * r)
                    total += share
                    mean += share * offset[n, k]
            if total > 1e-12:  # a node with nothing near its prediction says nothing
                weight = node_weight[n] * total / ((total + 0.1) * width**2)
                add_row(H, g, J[n], weight, mean / total)
        mirror(H)
        d = solve(H + base, g)
    return d


@compiled
def _refine(
    J,
    offset,
    preference,
    noise,
    node_weight,
    base,
    pull,
    start,
    width,
    edge,
    by_edge,
    model_error,
    doubt,
    spread,
):
    """Three passes of Tukey's weights about the nearest hypotheses: (d, information, residual, chosen, weight, sigma, spread, shared).

    spread < 0: to be estimated.
    """
    N, d = len(J), start
    chosen, weight = np.zeros(N, np.int64), np.zeros(N)
    residual, near, near_px, own_noise = np.empty(N), np.empty(N), np.empty(N), np.empty(N)
    edges = edge.max() + 1
    members = np.zeros(edges)
    for n in range(N):
        members[edge[n]] += 1.0
    H, sigma, own = np.zeros((6, 6)), width, 0.0
    for _ in range(3):
        found = 0
        for n in range(N):
            predicted, least = dot6(J[n], d), np.inf
            residual[n] = np.inf
            for k in range(offset.shape[1]):
                if preference[n, k] > 0.0:
                    r = offset[n, k] - predicted
                    cost = abs(r) + 2.0 * width * (1.0 - preference[n, k])
                    if cost < least:
                        least, residual[n], chosen[n] = cost, r, k
            own_noise[n] = noise[n, chosen[n]]
            if abs(residual[n]) < 4.0 * width:
                near_px[found] = abs(residual[n])
                near[found] = near_px[found] / own_noise[n]
                found += 1
        sigma, times = width, np.inf
        if found:
            sigma = min(1.4826 * kth_smallest(near_px[:found], found // 2), width)
            times = max(1.4826 * kth_smallest(near[:found], found // 2), 1.0)
        held, worth, sums = np.zeros(edges), np.zeros(edges), np.zeros(edges)
        for n in range(N):
            own_noise[n] = min(times * own_noise[n], width)
            t = residual[n] / (4.685 * own_noise[n])
            weight[n] = node_weight[n] * (1.0 - t * t) ** 2 if abs(t) < 1.0 else 0.0  # Tukey
            if weight[n] > 0.0:
                held[edge[n]] += weight[n]
                worth[edge[n]] += weight[n] / own_noise[n] ** 2
                sums[edge[n]] += weight[n] / own_noise[n] ** 2 * residual[n]
        common = np.zeros(edges)
        if by_edge:
            own = spread
            if spread < 0.0:
                square, count = 0.0, 0
                for e in range(edges):
                    if held[e] > 0.3 * members[e]:
                        square += (sums[e] / worth[e]) ** 2 - 1.0 / worth[e]  # noise makes some of it
                        count += 1
                own = max(square / max(count - 4, 1), 0.0)  # the pose has taken up some of it
            for n in range(N):
                common[edge[n]] = max(doubt * own, model_error[n] ** 2)
        H, g, pulls = np.zeros((6, 6)), pull.copy(), np.zeros((edges, 6))
        for n in range(N):
            if weight[n] > 0.0:
                pulled = weight[n] / (own_noise[n] ** 2 * (1.0 + worth[edge[n]] * common[edge[n]]))
                add_row(H, g, J[n], pulled, offset[n, chosen[n]])
                pulls[edge[n]] += np.sqrt(max(own, model_error[n] ** 2)) * pulled * J[n]
        mirror(H)
        d = solve(H + base, g)
    shared = np.zeros((6, 6))
    if by_edge:
        shared = pulls.T @ pulls
    for n in range(N):
        k = chosen[n]
        residual[n] = offset[n, k] - dot6(J[n], d) if preference[n, k] > 0.0 else np.nan
    return d, H, residual, chosen, weight, sigma, own, shared


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
