"""Displacements of a pose, and how they move what is seen of a model.

A displacement d = (w, v) turns the object about its own origin and moves it, both expressed in C:
``R' = exp(w) R``, ``t' = t + v`` (rad, m).
Frames: O object, C camera (x right, y down, z forward).
"""

import numpy as np

from vipr.systems import se3
from vipr.systems.camera.lens import Lens
from vipr.systems.compiled import compiled
from vipr.systems.tracking.cad_model import CadModel
from vipr.systems.tracking.visible_edges import Nodes

exp_so3, log_so3 = compiled(se3.exp_so3), compiled(se3.log_so3)


@compiled
def turned(X_CO, p_O):
    """Components in C of the vector from O's origin to a point p_O (3,): what the rotation alone makes of it."""
    return (
        X_CO[0, 0] * p_O[0] + X_CO[0, 1] * p_O[1] + X_CO[0, 2] * p_O[2],
        X_CO[1, 0] * p_O[0] + X_CO[1, 1] * p_O[1] + X_CO[1, 2] * p_O[2],
        X_CO[2, 0] * p_O[0] + X_CO[2, 1] * p_O[1] + X_CO[2, 2] * p_O[2],
    )


@compiled
def move(X_CO: np.ndarray, d: np.ndarray) -> np.ndarray:
    """The pose displaced by d = (w, v)."""
    X = np.eye(4)
    dR = exp_so3(d[:3])
    for i in range(3):
        for j in range(3):
            X[i, j] = dR[i, 0] * X_CO[0, j] + dR[i, 1] * X_CO[1, j] + dR[i, 2] * X_CO[2, j]
        X[i, 3] = X_CO[i, 3] + d[3 + i]
    return X


@compiled
def difference(X_CO: np.ndarray, X_CP: np.ndarray) -> np.ndarray:
    """d with ``move(X_CO, d) == X_CP``."""
    d, dR = np.empty(6), np.empty((3, 3))
    for i in range(3):
        for j in range(3):
            dR[i, j] = X_CP[i, 0] * X_CO[j, 0] + X_CP[i, 1] * X_CO[j, 1] + X_CP[i, 2] * X_CO[j, 2]
        d[3 + i] = X_CP[i, 3] - X_CO[i, 3]
    d[:3] = log_so3(dR)
    return d


def point_jacobian(p_O: np.ndarray, X_CO: np.ndarray, lens: Lens) -> np.ndarray:
    """(N, 2, 6) derivative of the pixels of points (N, 3) by d."""
    return _point_jacobian(p_O, X_CO, lens.fx, lens.fy)


@compiled
def _point_jacobian(p_O, X_CO, fx, fy):
    J = np.empty((len(p_O), 2, 6))
    for n in range(len(p_O)):
        x, y, z = turned(X_CO, p_O[n])
        pixel_derivatives(J[n], x, y, z, X_CO, fx, fy)
    return J


@compiled
def pixel_derivatives(J, x, y, z, X_CO, fx, fy):
    """Derivative of a point's pixel by d, into J (2, 6); (x, y, z): the point as ``turned`` gives it."""
    inverse = 1.0 / (z + X_CO[2, 3])
    gx, gy = fx * inverse, fy * inverse
    ax, ay = -gx * (x + X_CO[0, 3]) * inverse, -gy * (y + X_CO[1, 3]) * inverse
    J[0, 0], J[0, 1], J[0, 2], J[0, 3], J[0, 4], J[0, 5] = y * ax, z * gx - x * ax, -y * gx, gx, 0.0, ax
    J[1, 0], J[1, 1], J[1, 2], J[1, 3], J[1, 4], J[1, 5] = y * ay - z * gy, -x * ay, x * gy, 0.0, gy, ay


def normal_jacobian(nodes: Nodes, X_CO: np.ndarray, lens: Lens) -> np.ndarray:
    """(N, 6) derivative of the nodes' displacement along their normals [px] by d."""
    return _normal_jacobian(nodes.p_O, nodes.normal, X_CO, lens.fx, lens.fy)


@compiled
def _normal_jacobian(p_O, normal, X_CO, fx, fy):
    J = np.empty((len(p_O), 6))
    for n in range(len(p_O)):
        x, y, z = turned(X_CO, p_O[n])
        inverse = 1.0 / (z + X_CO[2, 3])
        gx, gy = normal[n, 0] * fx * inverse, normal[n, 1] * fy * inverse
        gz = -(gx * (x + X_CO[0, 3]) + gy * (y + X_CO[1, 3])) * inverse
        J[n, 0], J[n, 1], J[n, 2] = y * gz - z * gy, z * gx - x * gz, x * gy - y * gx
        J[n, 3], J[n, 4], J[n, 5] = gx, gy, gz
    return J


@compiled
def damping(J: np.ndarray, scale: float) -> np.ndarray:
    """(6, 6) a trace of information on every displacement, so that what the nodes do not see stays where it is."""
    H = np.zeros((6, 6))
    for i in range(6):
        H[i, i] = 1e-12
        for n in range(len(J)):
            H[i, i] += scale * J[n, i] * J[n, i]
    return H


def corner_information(model: CadModel, X_CO: np.ndarray, lens: Lens, pixels: float) -> np.ndarray:
    """(6, 6) information of a pose whose projected model corners are each known to `pixels` RMS."""
    J = point_jacobian(model.corners, X_CO, lens).reshape(-1, 6)
    return J.T @ J / pixels**2


def corner_shift(model: CadModel, lens: Lens, X_CA: np.ndarray, X_CB: np.ndarray) -> float:
    """RMS px between the projections of the model's corners at two poses; 1000 behind the camera."""
    return _corner_shift(model.corners, lens.fx, lens.fy, X_CA, X_CB)


@compiled
def _corner_shift(corners, fx, fy, X_CA, X_CB):
    total = 0.0
    for n in range(len(corners)):
        xa, ya, za = turned(X_CA, corners[n])
        xb, yb, zb = turned(X_CB, corners[n])
        za, zb = za + X_CA[2, 3], zb + X_CB[2, 3]
        if za <= 1e-3 or zb <= 1e-3:
            return 1e3
        dx = fx * ((xa + X_CA[0, 3]) / za - (xb + X_CB[0, 3]) / zb)
        dy = fy * ((ya + X_CA[1, 3]) / za - (yb + X_CB[1, 3]) / zb)
        total += dx * dx + dy * dy
    return np.sqrt(total / len(corners))


def corner_spread(model: CadModel, lens: Lens, X_CO: np.ndarray, covariance: np.ndarray) -> float:
    """RMS px by which the model's corners may be off a pose with this covariance (6, 6); 0 where that cannot be told."""
    J = point_jacobian(model.corners, X_CO, lens).reshape(-1, 6)
    square = ((J @ covariance) * J).sum() / len(model.corners)
    return float(np.sqrt(square)) if np.isfinite(square) else 0.0
