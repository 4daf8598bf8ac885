"""Constant-velocity filter on SE(3): prediction of a tracked pose, with its covariance.

State: pose X_CO and twist V_CO = (w, v) of O's origin, expressed in C; errors are displacements d as in ``displacements`` and
errors of V. Acceleration is white noise.
"""

from dataclasses import dataclass, field

import numpy as np

from vipr.systems.compiled import compiled
from vipr.systems.tracking.displacements import difference, move
from vipr.systems.tracking.small_algebra import solve


@dataclass(frozen=True, eq=False)
class Motion:
    """Pose, twist and their joint covariance at one time."""

    X_CO: np.ndarray = field(default_factory=lambda: np.eye(4))
    V_CO: np.ndarray = field(default_factory=lambda: np.zeros(6))  # rad/s, m/s
    covariance: np.ndarray = field(default_factory=lambda: np.zeros((12, 12)))  # of (d, V)


def at_rest(
    X_CO: np.ndarray, angle: float = 0.05, distance: float = 0.02, spin: float = 0.3, speed: float = 0.1
) -> Motion:
    """A pose given by hand: standard deviations of angle [rad], distance [m], spin [rad/s] and speed [m/s]."""
    deviations = np.repeat([angle, distance, spin, speed], 3)
    return Motion(X_CO, np.zeros(6), np.diag(deviations**2))


def predict(motion: Motion, dt: float, spin: float, speed: float, keep: float = 1.0) -> Motion:
    """The motion dt [s] later under accelerations of RMS spin [rad/s^2] and speed [m/s^2]; keep (0 to 1) of the twist survives."""
    X_CO = move(motion.X_CO, motion.V_CO * dt)
    return Motion(X_CO, keep * motion.V_CO, _propagated(motion.covariance, dt, spin, speed, keep))


@compiled
def _propagated(P, dt, spin, speed, keep):
    """F P F' + Q for F = [[1, dt], [0, keep]] and Q of white acceleration, block by block of (6, 6)."""
    after = np.empty((12, 12))
    for i in range(6):
        for j in range(6):
            A, B, B_, C = P[i, j], P[i, 6 + j], P[6 + i, j], P[6 + i, 6 + j]
            after[i, j] = A + dt * (B + B_) + dt * dt * C
            after[i, 6 + j] = keep * (B + dt * C)
            after[6 + i, j] = keep * (B_ + dt * C)
            after[6 + i, 6 + j] = keep * keep * C
        q = (spin if i < 3 else speed) ** 2
        after[i, i] += q * dt**4 / 4
        after[i, 6 + i] += q * dt**3 / 2
        after[6 + i, i] += q * dt**3 / 2
        after[6 + i, 6 + i] += q * dt**2
    return after


def settle(predicted: Motion, X_CO: np.ndarray, covariance: np.ndarray) -> Motion:
    """The predicted motion once a fit has weighed it against a measurement: X_CO is where both together put the pose.

    covariance (6, 6): of the measurement alone. The twist follows as far as it goes with the pose.
    """
    P = predicted.covariance
    V = predicted.V_CO + P[6:, :6] @ solve(np.ascontiguousarray(P[:6, :6]), difference(predicted.X_CO, X_CO))
    return Motion(X_CO, V, _updated(P, covariance)[1])


def correct(predicted: Motion, X_CO: np.ndarray, covariance: np.ndarray) -> Motion:
    """The predicted motion corrected by a measured pose with its (6, 6) covariance."""
    gain, P = _updated(predicted.covariance, covariance)
    step = gain @ difference(predicted.X_CO, X_CO)
    return Motion(move(predicted.X_CO, step[:6]), predicted.V_CO + step[6:], P)


@compiled
def _updated(P, R):
    """Kalman's gain (12, 6) of a measurement of the first six with covariance R (6, 6), and the covariance after it (Joseph's form)."""
    gain, kept = np.empty((12, 6)), np.eye(12)
    S = P[:6, :6] + R
    for i in range(12):
        gain[i] = solve(S, P[i, :6])
        for j in range(6):
            kept[i, j] -= gain[i, j]
    half, after = np.zeros((12, 12)), np.zeros((12, 12))
    for i in range(12):
        for k in range(12):
            for j in range(12):
                half[i, j] += kept[i, k] * P[k, j]
    for i in range(12):
        noise = np.zeros(6)
        for k in range(6):
            for j in range(6):
                noise[j] += gain[i, k] * R[k, j]
        for j in range(i + 1):
            for k in range(12):
                after[i, j] += half[i, k] * kept[j, k]
            for k in range(6):
                after[i, j] += noise[k] * gain[j, k]
            after[j, i] = after[i, j]
    return gain, after


@compiled
def surprise(predicted_X_CO: np.ndarray, covariance: np.ndarray, X_CO: np.ndarray) -> float:
    """Squared Mahalanobis distance of a pose from a predicted one with its covariance (6, 6) or larger."""
    off, total = difference(predicted_X_CO, X_CO), 0.0
    x = solve(np.ascontiguousarray(covariance[:6, :6]), off)
    for i in range(6):
        total += off[i] * x[i]
    return total
