"""Constant-velocity filter on SE(3): prediction of a tracked pose, with its covariance.

State: pose X_CO and twist V_CO = (w, v) of O's origin, expressed in C; errors are displacements d as in ``pose_fit`` and
errors of V. Acceleration is white noise.
"""

from dataclasses import dataclass, field

import numpy as np

from vipr.systems.tracking.displacements import difference, move


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
    F = np.eye(12)
    F[:6, 6:] = dt * np.eye(6)
    F[6:, 6:] *= keep
    q = np.repeat([spin, speed], 3) ** 2
    Q = np.zeros((12, 12))
    Q[:6, :6], Q[6:, 6:] = np.diag(q * dt**4 / 4), np.diag(q * dt**2)
    Q[:6, 6:] = Q[6:, :6] = np.diag(q * dt**3 / 2)
    return Motion(move(motion.X_CO, motion.V_CO * dt), keep * motion.V_CO, F @ motion.covariance @ F.T + Q)


def settle(predicted: Motion, X_CO: np.ndarray, covariance: np.ndarray) -> Motion:
    """The predicted motion once a fit has weighed it against a measurement: X_CO is where both together put the pose.

    covariance (6, 6): of the measurement alone. The twist follows as far as it goes with the pose.
    """
    P = predicted.covariance
    gain = np.linalg.solve(P[:6, :6] + covariance, P[:6]).T
    V = predicted.V_CO + P[6:, :6] @ np.linalg.solve(P[:6, :6] + 1e-15 * np.eye(6), difference(predicted.X_CO, X_CO))
    I_KH = np.eye(12)
    I_KH[:, :6] -= gain
    P = I_KH @ P @ I_KH.T + gain @ covariance @ gain.T
    return Motion(X_CO, V, 0.5 * (P + P.T))


def correct(predicted: Motion, X_CO: np.ndarray, covariance: np.ndarray) -> Motion:
    """The predicted motion corrected by a measured pose with its (6, 6) covariance."""
    P = predicted.covariance
    gain = np.linalg.solve(P[:6, :6] + covariance, P[:6]).T
    step = gain @ difference(predicted.X_CO, X_CO)
    I_KH = np.eye(12)
    I_KH[:, :6] -= gain
    P = I_KH @ P @ I_KH.T + gain @ covariance @ gain.T
    return Motion(move(predicted.X_CO, step[:6]), predicted.V_CO + step[6:], 0.5 * (P + P.T))
