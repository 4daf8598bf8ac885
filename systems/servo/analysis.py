"""The closed servo loop as a sampled linear system: poles, gain margin, step response.

About the goal the loop is linear: the servo asks for joint rates -gain times the joints' error, which is what a pose error, or an image
error with an exact interaction matrix, comes to. What remains are the clocks: the exposure every ``camera`` seconds, the servo's tick
``latency`` after the exposure that it answers, the arm's set-points every ``arm`` seconds, and the joint servo that follows them. One
camera period of all this, exactly, is a matrix (``transition``); the loop is stable while its eigenvalues are inside the unit circle.

Two ways to use a measurement are told apart. ``delayed``: the error is that of the exposure. ``predicted``: the error of the exposure is
carried to the servo's tick by the encoders (what ``VisualServo`` does), so that latency is not in the loop.
"""

from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Literal

import numpy as np
from scipy.linalg import expm

from vipr.systems.errors import InputError

GAIN_LIMIT = 1e3  # 1/s: no gain is looked for above
SETTLED = 0.02  # of the start


@dataclass(frozen=True, eq=False)
class ArmResponse:
    """The joint servo near the goal: x' = A x + B u with x = [q; qdot] (2n), u = [q; qdot; qddot] of its reference, as deviations."""

    A: np.ndarray  # (2n, 2n)
    B: np.ndarray  # (2n, 3n)

    @classmethod
    def second_order(cls, frequency: float = 35.0, damping: float = 0.7) -> "ArmResponse":
        """One joint whose servo has the natural frequency [rad/s] and damping ratio, and knows nothing of the acceleration."""
        k, c = frequency**2, 2.0 * damping * frequency
        return cls(np.array([[0.0, 1.0], [-k, -c]]), np.array([[0.0, 0.0, 0.0], [k, c, 0.0]]))


@dataclass(frozen=True, eq=False)
class SampledLoop:
    """Clocks of the loop and the arm in it."""

    arm_response: ArmResponse = field(default_factory=ArmResponse.second_order)
    latency: float = 0.022  # s, from an exposure to the servo's tick that answers it
    use: Literal["delayed", "predicted"] = "delayed"
    camera: float = 0.04  # s, period of exposures and of the servo
    arm: float = 0.01  # s, period of the set-points; divides the camera's
    arm_offset: float = 0.004  # s
    smooth: bool = False  # the servo's reference comes from one set-point's rate to the next at constant acceleration; else at once

    def __post_init__(self):
        if self.use not in ("delayed", "predicted"):
            raise InputError(f"servo analysis: use must be delayed or predicted, got {self.use!r}")
        if not 0 <= self.latency <= 2.0:
            raise InputError(f"servo analysis: latency must be 0 to 2000 ms, got {1e3 * self.latency:g} ms")
        if not (self.camera > 0 and self.arm > 0 and 0 <= self.arm_offset < self.arm):
            raise InputError(
                f"servo analysis: periods must be positive and the arm's offset below its period, got camera {1e3 * self.camera:g} ms, "
                f"arm {1e3 * self.arm:g} ms, offset {1e3 * self.arm_offset:g} ms"
            )
        if abs(self.camera / self.arm - round(self.camera / self.arm)) > 1e-9:
            raise InputError(
                f"servo analysis: the arm's period must divide the camera's, got {1e3 * self.arm:g} and {1e3 * self.camera:g} ms"
            )

    @property
    def joints(self) -> int:
        return len(self.arm_response.A) // 2

    @cached_property
    def _pictures(self) -> int:
        """Exposures before the one that has just been taken which are still to be answered."""
        return int(np.floor(self.latency / self.camera + 1e-9))

    @property
    def size(self) -> int:
        """Length of the state: [q, qdot; q, qdot, qddot of the reference; wanted rates; errors seen (newest first)]."""
        return self.joints * (7 + self._pictures)

    @cached_property
    def _events(self) -> list[tuple[float, str]]:
        """(time [s], what) within one period from an exposure; at one instant the servo acts before the arm."""
        ticks = [(self.arm_offset + i * self.arm, "arm") for i in range(round(self.camera / self.arm))]
        return sorted(
            [(self.latency - self._pictures * self.camera, "0 servo"), *ticks], key=lambda e: (round(e[0], 9), e[1])
        )

    def steps(self, gain: float) -> list[tuple[float, np.ndarray]]:
        """The matrices of one camera period in their order, each with the time [s] from the exposure at which it is done."""
        done, time = [(0.0, self._expose)], 0.0
        for at, what in self._events:
            if at > time:
                done.append((at, self.flow(at - time)))
            done.append((at, self._set_point if what == "arm" else self._answer(gain)))
            time = max(time, at)
        return [*done, (self.camera, self.flow(self.camera - time))]

    def transition(self, gain: float) -> np.ndarray:
        """(size, size): the state from just before one exposure to just before the next."""
        M = np.eye(self.size)
        for _, step in self.steps(gain):
            M = step @ M
        return M

    def flow(self, duration: float) -> np.ndarray:
        """The state after so long [s] without an event: the joints move, everything else is held."""
        n, one = self.joints, np.eye(self.joints)
        F = np.zeros((5 * n, 5 * n))
        F[: 2 * n, : 2 * n], F[: 2 * n, 2 * n :] = self.arm_response.A, self.arm_response.B
        if self.smooth:
            F[self._part(2), self._part(3)] = F[self._part(3), self._part(4)] = one
        M = np.eye(self.size)
        M[: 5 * n, : 5 * n] = expm(F * duration)
        return M

    def _part(self, k: int) -> slice:
        return slice(k * self.joints, (k + 1) * self.joints)

    @cached_property
    def _expose(self) -> np.ndarray:
        M, one = np.eye(self.size), np.eye(self.joints)
        M[6 * self.joints :] = 0.0
        M[self._part(6), self._part(0)] = one
        for k in range(self._pictures):
            M[self._part(7 + k), self._part(6 + k)] = one
        return M

    @cached_property
    def _set_point(self) -> np.ndarray:
        M, one = np.eye(self.size), np.eye(self.joints)
        M[self._part(4)] = 0.0
        if self.smooth:  # the rate is that of the last set-point now, and this one's when the next comes
            M[self._part(4), self._part(5)], M[self._part(4), self._part(3)] = one / self.arm, -one / self.arm
        else:
            M[self._part(2), self._part(5)] = self.arm * one
            M[self._part(3), self._part(3)], M[self._part(3), self._part(5)] = 0.0, one
        return M

    def _answer(self, gain: float) -> np.ndarray:
        M = np.eye(self.size)
        M[self._part(5)] = 0.0
        seen = 0 if self.use == "predicted" else 6 + self._pictures
        M[self._part(5), self._part(seen)] = -gain * np.eye(self.joints)
        return M


def poles(loop: SampledLoop, gain: float) -> np.ndarray:
    """Poles z of the loop, one camera period a step, the slowest first."""
    z = np.linalg.eigvals(loop.transition(gain))
    return z[np.argsort(-np.abs(z))]


def is_stable(loop: SampledLoop, gain: float) -> bool:
    return bool(np.abs(poles(loop, gain)[0]) < 1.0 - 1e-9)


def largest_stable_gain(loop: SampledLoop) -> float:
    """The gain [1/s] at which the loop begins to oscillate: every smaller positive one is stable."""
    low, high = 0.0, 0.25
    while is_stable(loop, high) and high < GAIN_LIMIT:
        low, high = high, 1.25 * high
    for _ in range(40):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if is_stable(loop, middle) else (low, middle)
    return low


def largest_stable_latency(loop: SampledLoop, gain: float) -> float:
    """The latency [s] above which the loop oscillates at this gain, to a millisecond; 2 s if none up to that does."""
    low, high = 0.0, 2.0
    if is_stable(replace(loop, latency=high), gain):
        return high
    while high - low > 1e-3:
        middle = 0.5 * (low + high)
        low, high = (middle, high) if is_stable(replace(loop, latency=middle), gain) else (low, middle)
    return low


def step_response(loop: SampledLoop, gain: float, duration: float, start: np.ndarray | None = None):
    """How the loop comes from rest at ``start`` (n,) (default: 1 in every joint) to the goal at 0.

    Returns:
        times (K,) [s] from the first exposure, one per arm period, and the joints' deviations (K, n); the servo asks for no motion
        until it answers that exposure.
    """
    n = loop.joints
    state = np.zeros(loop.size)
    state[:n] = state[2 * n : 3 * n] = np.ones(n) if start is None else start
    per = round(loop.camera / loop.arm)
    times, places, wanted = [], [], np.arange(per) * loop.arm
    steps = loop.steps(gain)
    for period in range(int(np.ceil(duration / loop.camera))):
        at, k = 0.0, 0
        for time, step in steps:
            while k < per and wanted[k] <= time + 1e-12 and time > at:
                places.append((loop.flow(wanted[k] - at) @ state)[:n])  # a place between two events
                times.append(period * loop.camera + wanted[k])
                k += 1
            state, at = step @ state, time
    return np.array(times), np.array(places)


@dataclass(frozen=True)
class Behaviour:
    """How the loop comes to its goal at one gain."""

    gain: float  # 1/s
    stable: bool
    margin: float  # by how much the gain could grow
    overshoot: float  # of the start
    settling: float  # s, until it stays within 2 % of the start; infinite if it does not


def require_gain(gain: float) -> None:
    """InputError for a gain [1/s] that makes no sense."""
    if not (np.isfinite(gain) and 0 < gain <= GAIN_LIMIT):
        raise InputError(f"servo analysis: gain must be above 0 and at most {GAIN_LIMIT:g} 1/s, got {gain:g} 1/s")


def behaviour(loop: SampledLoop, gain: float) -> Behaviour:
    """Gain margin, overshoot and settling time at a gain [1/s]."""
    require_gain(gain)
    margin = largest_stable_gain(loop) / gain
    if not is_stable(loop, gain):
        return Behaviour(gain, False, margin, np.inf, np.inf)
    slowest = -loop.camera / np.log(np.abs(poles(loop, gain)[0]))  # s, its time constant
    times, places = step_response(loop, gain, min(5.0 * slowest + 2.0 * loop.latency + 0.2, 60.0))
    last = np.flatnonzero((np.abs(places) > SETTLED).any(axis=1))[-1]
    settling = times[last + 1] if last + 1 < len(times) else np.inf
    return Behaviour(gain, True, margin, _overshoot(places), float(settling))


def quickest_gain(loop: SampledLoop, overshoot: float = 0.02) -> float:
    """The largest gain [1/s], to 2 %, at which the step overshoots by at most so much."""
    low, high = 0.0, largest_stable_gain(loop)
    while high - low > 0.02 * high:
        middle = 0.5 * (low + high)
        _, places = step_response(loop, middle, 3.0 / middle + 2.0 * loop.latency)
        low, high = (middle, high) if _overshoot(places) <= overshoot else (low, middle)
    return low


def _overshoot(places: np.ndarray) -> float:
    return float(max(-places.min(), 0.0))
