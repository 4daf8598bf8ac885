"""Resolved rate: a twist of the tool to joint rates within position, speed and acceleration limits.

Damped least squares (Nakamura and Hanafusa 1986; Wampler 1986) with a damping that grows only near singularities, then one scale for
the whole vector, so that the tool keeps its direction when a joint reaches its speed limit.
"""

from dataclasses import dataclass

import numpy as np

from vipr.systems.errors import InputError


@dataclass(frozen=True, eq=False)
class JointLimits:
    """Limits of n joints; every array (n,)."""

    lower: np.ndarray  # rad
    upper: np.ndarray  # rad
    speed: np.ndarray  # rad/s
    acceleration: np.ndarray  # rad/s^2

    def __post_init__(self):
        if not (np.asarray(self.lower) < self.upper).all():
            raise InputError(f"joint limits: lower must be below upper, got {self.lower} and {self.upper} rad")
        if not (np.asarray(self.speed) > 0).all() or not (np.asarray(self.acceleration) > 0).all():
            raise InputError("joint limits: speeds and accelerations must be positive")


@dataclass(frozen=True)
class Damping:
    """Damped least squares: J^T (J J^T + d^2 I)^-1 with d rising from 0 below a smallest singular value."""

    threshold: float = 0.06  # of the Jacobian with lengths divided by `length`
    largest: float = 0.08
    length: float = 0.3  # m, makes rotations and translations comparable


def damped_rates(J: np.ndarray, V: np.ndarray, damping: Damping = Damping()) -> tuple[np.ndarray, float]:
    """Joint rates (n,) [rad/s] for the twist V (w, v), and the smallest singular value of the scaled Jacobian."""
    scale = np.array([1.0, 1.0, 1.0, *(1.0 / damping.length,) * 3])
    U, s, Vt = np.linalg.svd(J * scale[:, None])
    d2 = 0.0
    if s[-1] < damping.threshold:
        d2 = (1.0 - (s[-1] / damping.threshold) ** 2) * damping.largest**2
    return Vt.T[:, : len(s)] @ (s / (s**2 + d2) * (U.T @ (V * scale))), float(s[-1])


def limited_rates(
    rates: np.ndarray, q: np.ndarray, previous: np.ndarray, limits: JointLimits, dt: float
) -> tuple[np.ndarray, str]:
    """Rates (n,) [rad/s] that respect every limit over the next dt, and what limited them.

    Args:
        rates: wanted joint rates.
        q: joint set-points [rad].
        previous: rates of the last period [rad/s].
        limits: of the joints.
        dt: period [s].

    Returns:
        the rates, and ``""``, ``"speed"``, ``"acceleration"`` or ``"position"`` (the last that applied).
    """
    reason = ""
    over = np.max(np.abs(rates) / limits.speed)
    if over > 1.0:
        rates, reason = rates / over, "speed"
    change = rates - previous
    over = np.max(np.abs(change) / (limits.acceleration * dt))
    if over > 1.0:
        rates, reason = previous + change / over, reason or "acceleration"
    # Position: a joint must be able to brake before its stop: v^2 <= 2 a (distance left), so that braking never needs more than a.
    room_up = np.maximum(limits.upper - q, 0.0)
    room_down = np.maximum(q - limits.lower, 0.0)
    top = _braking_speed(room_up, limits.acceleration, dt)
    bottom = -_braking_speed(room_down, limits.acceleration, dt)
    clipped = np.clip(rates, bottom, top)
    if not np.array_equal(clipped, rates):
        reason = "position"
    return clipped, reason


def _braking_speed(room: np.ndarray, acceleration: np.ndarray, dt: float) -> np.ndarray:
    """Largest speed [rad/s] from which steps of dt still stop within the room [rad] at the given deceleration."""
    half = 0.5 * acceleration * dt
    return np.sqrt(half**2 + 2.0 * acceleration * room) - half
