"""What is known of an object that rests on a level surface of known height: it is upright, and its lowest point is on the surface.

One camera sees across its line of sight far better than along it. Where that line meets the surface says how far away the object is.
Frames: W world (z up), C camera, O object.
"""

from dataclasses import dataclass, field

import numpy as np

from vipr.systems import se3


@dataclass(frozen=True, eq=False)
class Support:
    """A level surface, and the box of the object that rests on it."""

    height: float = 0.0  # m, z of W
    low: np.ndarray = field(default_factory=lambda: np.zeros(3))  # (3,) in O, m
    high: np.ndarray = field(default_factory=lambda: np.zeros(3))


def settled(X_WO: np.ndarray, up_O: np.ndarray, support: Support, X_WC: np.ndarray) -> np.ndarray:
    """X_WO made upright, ``up_O`` (3,) exactly upwards, and moved along the camera's line of sight until it stands on the support."""
    up_W = X_WO[:3, :3] @ up_O
    axis = np.cross(up_W, [0.0, 0.0, 1.0])
    sine = np.linalg.norm(axis)
    R = np.eye(3) if sine < 1e-12 else se3.exp_so3(axis / sine * np.arctan2(sine, up_W[2]))
    middle_O = 0.5 * (support.low + support.high)
    middle = X_WO[:3, :3] @ middle_O + X_WO[:3, 3]
    R_WO = R @ X_WO[:3, :3]
    half = 0.5 * float(np.abs(R_WO[2]) @ (support.high - support.low))
    ray = middle - X_WC[:3, 3]
    wanted = support.height + half
    if abs(ray[2]) > 0.05 * np.linalg.norm(ray):
        middle = X_WC[:3, 3] + ray * (wanted - X_WC[2, 3]) / ray[2]
    else:  # seen from the side: the surface says nothing about the distance
        middle = np.array([middle[0], middle[1], wanted])
    return se3.pose(R_WO, middle - R_WO @ middle_O)


def settled_doubt(X_WO: np.ndarray, covariance: np.ndarray, X_WC: np.ndarray) -> float:
    """Standard deviation [m] of a settled object's place, from the covariance (3, 3) in C of its seen position."""
    ray = X_WC[:3, :3].T @ (X_WO[:3, 3] - X_WC[:3, 3])
    ray /= np.linalg.norm(ray)
    across = np.eye(3) - np.outer(ray, ray)
    spread = np.sqrt(max(float(np.trace(across @ covariance @ across)), 0.0))
    slope = abs(float((X_WC[:3, :3] @ ray)[2]))
    return spread / max(slope, 0.05)
