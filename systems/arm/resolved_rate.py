"""Resolved rate: a twist of the tool to joint rates within position, speed and acceleration limits.

The inverse of the Jacobian, damped only along the directions that a singularity takes away (selective damping: Nakamura and Hanafusa 1986,
Maciejewski and Klein 1988): what the arm can still do it does exactly. Limits shorten the whole vector, so that the tool keeps its
direction: it slows down where a joint nears its speed or its stop, and halts rather than turn aside. Two things override the direction:
an acceleration limit while the arm changes from another motion, and a joint that must brake at its full deceleration before its stop.
"""

from dataclasses import dataclass, replace

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

    def stopping_within(self, seconds: float) -> "JointLimits":
        """The same limits, with no joint faster than it can be brought to rest in the given time [s]."""
        if not seconds > 0:
            raise InputError(f"joint limits: the time to stop in must be positive, got {seconds:g} s")
        return replace(self, speed=np.minimum(self.speed, seconds * self.acceleration))


@dataclass(frozen=True)
class Damping:
    """Damping d of singular values s below the threshold: s / (s^2 + d^2), with d rising from 0 to ``largest`` at s = 0."""

    threshold: float = 0.06  # of the Jacobian with lengths divided by `length`
    largest: float = 0.08
    length: float = 0.3  # m, makes rotations and translations comparable

    def __post_init__(self):
        for name in self.__dataclass_fields__:
            if not getattr(self, name) > 0:
                raise InputError(f"arm: damping {name} must be positive, got {getattr(self, name)}")


def damped_rates(J: np.ndarray, V: np.ndarray, damping: Damping = Damping()) -> tuple[np.ndarray, float]:
    """Joint rates (n,) [rad/s] for the twist V (w, v), and the share of the twist (0 to 1) that damping gives up."""
    scale = np.array([1.0, 1.0, 1.0, *(1.0 / damping.length,) * 3])
    U, s, Vt = np.linalg.svd(J * scale[:, None], full_matrices=False)
    d2 = np.maximum(1.0 - (s / damping.threshold) ** 2, 0.0) * damping.largest**2
    wanted = V * scale
    parts = U.T @ wanted
    kept = s**2 / (s**2 + d2)
    lost = np.linalg.norm((1.0 - kept) * parts) / max(np.linalg.norm(wanted), 1e-12)
    return Vt.T @ (s / (s**2 + d2) * parts), float(lost)


def limited_rates(
    rates: np.ndarray, q: np.ndarray, previous: np.ndarray, limits: JointLimits, dt: float
) -> tuple[np.ndarray, str]:
    """Rates (n,) [rad/s] that respect every limit over the next dt, and what limited them.

    Args:
        rates: wanted joint rates.
        q: joint set-points [rad], within their limits.
        previous: rates of the last period [rad/s], as given by this function.
        limits: of the joints.
        dt: period [s].

    Returns:
        the rates, and ``""``, ``"speed"``, ``"acceleration"`` or ``"position"`` (the tightest).
    """
    room = np.where(rates > 0, limits.upper - q, q - limits.lower)
    size = np.maximum(np.abs(rates), 1e-12)
    speed = np.min(limits.speed / size)
    # Along the wanted direction the arm is one body: the nearest stop and the weakest joint tell how fast it may go.
    position = braking_speed(np.min(np.maximum(room, 0.0) / size), np.min(limits.acceleration / size), dt)
    reason = ""
    if min(speed, position) < 1.0 - 1e-9:
        reason = "speed" if speed < position else "position"
        rates = min(speed, position) * rates
    new = step_towards(rates, previous, limits, dt)
    if not reason and not np.array_equal(new, rates):
        reason = "acceleration"
    clipped = within_stops(new, q, limits, dt)
    if not np.array_equal(clipped, new):
        reason = "position"
    return clipped, reason


def step_towards(rates: np.ndarray, previous: np.ndarray, limits: JointLimits, dt: float) -> np.ndarray:
    """The largest share of the wanted rates that the accelerations allow now.

    Where no share is within reach (the arm moves otherwise still), straight from the previous rates towards the wanted ones.
    """
    most = limits.acceleration * dt
    size = np.maximum(np.abs(rates), 1e-12)
    towards = np.sign(rates) * previous
    low, high = np.max((towards - most) / size), np.min((towards + most) / size)
    if max(low, 0.0) <= min(high, 1.0) and (np.abs(previous[rates == 0.0]) <= most[rates == 0.0]).all():
        return min(high, 1.0) * rates
    change = rates - previous
    return previous + change / max(np.max(np.abs(change) / most), 1.0)


def within_stops(rates: np.ndarray, q: np.ndarray, limits: JointLimits, dt: float) -> np.ndarray:
    """The rates, each low enough to brake before its joint's stop at the joint's own deceleration."""
    top = braking_speed(np.maximum(limits.upper - q, 0.0), limits.acceleration, dt)
    bottom = braking_speed(np.maximum(q - limits.lower, 0.0), limits.acceleration, dt)
    return np.clip(rates, -bottom, top)


def braking_speed(room: np.ndarray, deceleration: np.ndarray, dt: float) -> np.ndarray:
    """Largest speed at which a step of dt leaves room to stop by steps that are slower by deceleration * dt each; exact.

    In units of u = deceleration * dt a speed x between m and m + 1 stops within x + (x - 1) + ... + (x - m) of u * dt.
    """
    room = room / (deceleration * dt**2)
    m = np.floor(0.5 * (np.sqrt(1.0 + 8.0 * room) - 1.0))
    return deceleration * dt * (room / (m + 1.0) + 0.5 * m)
