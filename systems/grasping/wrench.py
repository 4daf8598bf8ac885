"""How well a grasp resists pushes from anywhere: the epsilon of its wrench space (Ferrari and Canny 1992).

Each contact can push within its friction cone. The wrenches of unit pushes, torques divided by a length of the object, span a convex hull;
epsilon is the radius of the largest ball about the origin inside it: the smallest push, as a share of what the fingers give together, that
could break the grasp. Zero: some push meets no resistance.
"""

import numpy as np
from scipy.spatial import ConvexHull, QhullError

CONE_SIDES = 8


def contact_wrenches(points: np.ndarray, normals: np.ndarray, friction: np.ndarray, centre: np.ndarray, length: float):
    """(8 n, 6) wrenches (force, torque / length) about the centre of unit normal pushes along the edges of n friction cones.

    points (n, 3) [m], normals (n, 3) unit and into the object, friction (n,) coefficients, centre (3,) [m], length [m].
    """
    wrenches = []
    for p, n, mu in zip(points, normals, friction, strict=True):
        u = np.cross(n, np.eye(3)[np.argmin(np.abs(n))])
        u /= np.linalg.norm(u)
        v = np.cross(n, u)
        for angle in 2.0 * np.pi * np.arange(CONE_SIDES) / CONE_SIDES:
            force = n + mu * (np.cos(angle) * u + np.sin(angle) * v)
            wrenches.append(np.concatenate([force, np.cross(p - centre, force) / length]))
    return np.array(wrenches)


def epsilon(wrenches: np.ndarray) -> float:
    """Radius of the largest ball about the origin within the convex hull of the wrenches (m, 6); 0 without force closure."""
    if len(wrenches) < 7:
        return 0.0
    try:
        hull = ConvexHull(wrenches)
    except QhullError:  # flat: some direction is not resisted at all
        return 0.0
    return float(max(0.0, -np.max(hull.equations[:, -1])))
