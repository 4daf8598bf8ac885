"""Fit of the projected model to the image's gradients by a discrete hierarchical search of the pose (paper III-B.1, eq. 35).

The cost of a pose is minus the mean, over the nodes, of the intensity difference across the projected edge. Six displacements
(rotations and translations of O in C) are tried in both directions, the best is kept, and the steps shrink from level to level. The
paper's own contribution is the size of the first steps: it follows the object's estimated velocity, axis by axis.
"""

from dataclasses import dataclass

import numpy as np

from vipr.systems.camera.lens import Lens
from vipr.systems.compiled import compiled
from vipr.systems.tracking.displacements import move, normal_jacobian, turned
from vipr.systems.tracking.normal_flow import Patch, bilinear
from vipr.systems.tracking.visible_edges import Nodes


@dataclass(frozen=True, eq=False)
class GradientFit:
    """Pose found, its cost (minus the mean edge difference, grey levels) and the number of poses tried."""

    X_CO: np.ndarray
    cost: float
    tried: int


def search_steps(
    nodes: Nodes, X_CO: np.ndarray, lens: Lens, V_CO: np.ndarray | None, dt: float, pixels: float = 3.0
) -> np.ndarray:
    """(6,) first steps (rad, m): each moves the nodes by `pixels` RMS; with a velocity, at least half of its way in dt instead.

    A fixed step is what the search without dynamic steps uses (V_CO None).
    """
    J = normal_jacobian(nodes, X_CO, lens)
    fixed = pixels / np.maximum(np.sqrt((J * J).mean(0)), 1e-9) if len(nodes) else np.zeros(6)
    if V_CO is None:
        return fixed
    return np.clip(0.5 * np.abs(V_CO) * dt, fixed / 2.0, 4.0 * fixed)


def fit_gradients(
    patch: Patch,
    nodes: Nodes,
    X_CO: np.ndarray,
    lens: Lens,
    steps: np.ndarray,
    levels: int = 4,
    half_width: float = 1.5,
) -> GradientFit:
    """The pose near X_CO whose projected nodes lie on the strongest gradients.

    At each of the levels the 12 neighbours at distance `steps` are compared in one sampling, then the pose that their costs point to; the
    steps are halved from level to level. half_width [px]: where the difference is taken, either side of the edge.
    """
    if not len(nodes):
        return GradientFit(X_CO, 0.0, 0)
    across = half_width * nodes.normal
    return GradientFit(
        *_descend(
            patch.grey,
            nodes.p_O,
            across,
            X_CO,
            lens.fx,
            lens.fy,
            lens.cx - patch.origin[0],
            lens.cy - patch.origin[1],
            steps,
            levels,
        )
    )


@compiled
def _descend(grey, p_O, across, X_CO, fx, fy, cx, cy, steps, levels):
    """(pose, cost, poses tried) at the foot of the discrete hierarchical search."""
    X, cost, tried = X_CO, _cost(grey, p_O, across, X_CO, fx, fy, cx, cy), 1
    poses, costs = np.empty((13, 4, 4)), np.empty(13)
    for level in range(levels):
        step = steps * 0.5**level
        for _ in range(3):
            jump = np.zeros(6)
            for i in range(6):
                for sign, k in ((1.0, i), (-1.0, 6 + i)):
                    d = np.zeros(6)
                    d[i] = sign * step[i]
                    poses[k] = move(X, d)
                    costs[k] = _cost(grey, p_O, across, poses[k], fx, fy, cx, cy)
                # Along the slope that the pair shows, by its parabola.
                slope, bend = costs[6 + i] - costs[i], costs[i] + costs[6 + i] - 2.0 * cost
                jump[i] = step[i] * (min(max(0.5 * slope / bend, -1.0), 1.0) if bend > 1e-9 else np.sign(slope))
            poses[12] = move(X, jump)  # one more pose: all axes at once
            costs[12] = _cost(grey, p_O, across, poses[12], fx, fy, cx, cy)
            tried += 13
            best = np.argmin(costs)
            if costs[best] >= cost - 1e-6:
                break
            X, cost = poses[best].copy(), costs[best]
    return X, cost, tried


@compiled
def _cost(grey, p_O, across, X_CO, fx, fy, cx, cy):
    """Minus the mean absolute difference across the projected nodes."""
    total = 0.0
    for n in range(len(p_O)):
        x, y, z = turned(X_CO, p_O[n])
        inverse = 1.0 / max(z + X_CO[2, 3], 1e-3)
        u, v = fx * (x + X_CO[0, 3]) * inverse + cx, fy * (y + X_CO[1, 3]) * inverse + cy
        total += abs(
            bilinear(grey, u + across[n, 0], v + across[n, 1]) - bilinear(grey, u - across[n, 0], v - across[n, 1])
        )
    return -total / len(p_O)
