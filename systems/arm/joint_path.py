"""Paths through joint space in time: a smooth curve through way-points, at rest at both ends, as fast as the limits allow."""

from dataclasses import dataclass

import numpy as np
from scipy.interpolate import CubicSpline

from vipr.systems.arm.resolved_rate import JointLimits
from vipr.systems.errors import InputError

# Of the time law s = 10 u^3 - 15 u^4 + 6 u^5, per second and per second squared.
PEAK_SPEED, PEAK_ACCELERATION = 1.875, 5.774
# Of the joints' limits, what a path uses: the rest is for the loop around it, and for what the hand holds by friction.
SPEED_SHARE, ACCELERATION_SHARE = 0.7, 0.56
SHORTEST = 0.3  # s


@dataclass(frozen=True, eq=False)
class JointPath:
    """A curve q(s), s from 0 to 1, walked in ``duration`` seconds."""

    curve: CubicSpline
    duration: float

    def __deepcopy__(self, memo):
        return self  # immutable

    def at(self, time: float) -> tuple[np.ndarray, np.ndarray]:
        """Joint angles and rates (n,) [rad, rad/s] so long after the start [s]; the end is held."""
        u = min(max(time / self.duration, 0.0), 1.0)
        s, rate = u**3 * (10.0 - 15.0 * u + 6.0 * u**2), 30.0 * u**2 * (1.0 - u) ** 2 / self.duration
        return self.curve(s), self.curve(s, 1) * rate

    @property
    def end(self) -> np.ndarray:
        return self.curve(1.0)

    def part(self, share: float) -> "JointPath":
        """The way only as far as s = share, in the same time."""
        s = self.curve.x
        return JointPath(CubicSpline(s, self.curve(share * s), axis=0, bc_type="natural"), self.duration)

    def shifted(self, q: np.ndarray) -> "JointPath":
        """The same way beside it, by q (n,) [rad]."""
        s = self.curve.x
        return JointPath(CubicSpline(s, self.curve(s) + q, axis=0, bc_type="natural"), self.duration)

    def reversed(self) -> "JointPath":
        """The same way back."""
        s = self.curve.x
        return JointPath(CubicSpline(s, self.curve(1.0 - s), axis=0, bc_type="natural"), self.duration)


def joint_path(points: np.ndarray, limits: JointLimits, length: float = 0.0, speed: float = np.inf) -> JointPath:
    """The path through points (m, n) [rad], m >= 2, at even steps of s, whose tool goes ``length`` [m] at no more than ``speed`` [m/s].

    The duration is the shortest in which no joint exceeds its share of its speed or acceleration.
    """
    points = np.asarray(points, float)
    if len(points) < 2 or not np.isfinite(points).all():
        raise InputError(f"joint path: needs two or more finite points, got {len(points)}")
    curve = CubicSpline(np.linspace(0.0, 1.0, len(points)), points, axis=0, bc_type="natural")
    s = np.linspace(0.0, 1.0, 4 * len(points))
    slope, bend = np.abs(curve(s, 1)), np.abs(curve(s, 2))
    by_speed = np.max(slope / (SPEED_SHARE * limits.speed)) * PEAK_SPEED
    # |q''| <= |dq/ds| peak / T^2 + |d2q/ds2| (peak speed / T)^2
    by_acceleration = np.sqrt(
        np.max((slope * PEAK_ACCELERATION + bend * PEAK_SPEED**2) / (ACCELERATION_SHARE * limits.acceleration))
    )
    return JointPath(curve, float(max(by_speed, by_acceleration, PEAK_SPEED * length / speed, SHORTEST)))
