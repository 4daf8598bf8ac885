"""Fit of the projected model to the image's gradients by a discrete hierarchical search of the pose (paper III-B.1, eq. 35).

The cost of a pose is minus the mean, over the nodes, of the intensity difference across the projected edge. Six displacements
(rotations and translations of O in C) are tried in both directions, the best is kept, and the steps shrink from level to level. The
paper's own contribution is the size of the first steps: it follows the object's estimated velocity, axis by axis.
"""

from dataclasses import dataclass

import cv2
import numpy as np

from vipr.systems.camera.lens import Lens
from vipr.systems.tracking.displacements import move, normal_jacobian
from vipr.systems.tracking.normal_flow import Patch
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
    X, cost, tried = X_CO, _costs(patch, nodes, [X_CO], lens, half_width)[0], 1
    for level in range(levels):
        step = steps * 0.5**level
        for _ in range(3):
            moves = np.concatenate([np.diag(step), -np.diag(step)])
            poses = [move(X, d) for d in moves]
            costs = _costs(patch, nodes, poses, lens, half_width)
            # One more pose: along the slope that the pairs show, each axis by its own parabola.
            plus, minus = costs[:6], costs[6:]
            bend = plus + minus - 2.0 * cost
            jump = np.where(bend > 1e-9, 0.5 * (minus - plus) / np.maximum(bend, 1e-9), np.sign(minus - plus))
            poses.append(move(X, np.clip(jump, -1.0, 1.0) * step))
            costs = np.append(costs, _costs(patch, nodes, poses[-1:], lens, half_width))
            tried += 13
            best = int(np.argmin(costs))
            if costs[best] >= cost - 1e-6:
                break
            X, cost = poses[best], costs[best]
    return GradientFit(X, float(cost), tried)


def _costs(patch, nodes, poses, lens, half_width):
    """Cost of each pose: minus the mean absolute difference across the projected nodes."""
    if not len(nodes):
        return np.zeros(len(poses))
    p_C = np.concatenate([nodes.p_O @ X[:3, :3].T + X[:3, 3] for X in poses])
    pixel = lens.project(np.maximum(p_C, (-np.inf, -np.inf, 1e-3))) - patch.origin
    across = np.tile(half_width * nodes.normal, (len(poses), 1))
    maps = np.stack([pixel + across, pixel - across]).astype(np.float32)
    values = cv2.remap(patch.grey, maps.reshape(2, -1, 2), None, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)
    return -np.abs(values[0] - values[1]).reshape(len(poses), -1).mean(1)
