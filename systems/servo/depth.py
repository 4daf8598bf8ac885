"""Depths of points from how they move in the image while their motion in space is known: a Kalman filter of 1 / Z a point.

(Matthies, Kanade and Szeliski 1989.) The image velocity of a point is linear in chi = 1 / Z: ``xdot = L_w w + chi L_v1 v``, with L_v1
the translational half of its interaction matrix at unit depth.
"""

from dataclasses import dataclass, field

import numpy as np

from vipr.systems.servo.interaction import point_interaction, require_depths

IMAGE_NOISE = 1e-4  # standard deviation of one normalised coordinate: 0.2 px of the XC-77
START_UNCERTAINTY = 0.3  # of 1 / Z at the start, relative
DRIFT = 0.02  # of 1 / Z in one second, relative
LEAST_SHARE, MOST_SHARE = 0.2, 5.0  # of the start's 1 / Z: the range that is believed


@dataclass(frozen=True, eq=False)
class DepthBelief:
    """Inverse depths of n points, and what is needed to go on."""

    inverse: np.ndarray = field(default_factory=lambda: np.zeros(0))  # (n,) 1/m
    variance: np.ndarray = field(default_factory=lambda: np.zeros(0))  # (n,)
    start: np.ndarray = field(default_factory=lambda: np.zeros(0))  # (n,) 1/m, what was assumed first
    x: np.ndarray = field(default_factory=lambda: np.zeros((0, 2)))  # (n, 2) features at ``time``
    time: float = float("nan")  # s

    @property
    def depths(self) -> np.ndarray:
        """(n,) [m]."""
        return 1.0 / self.inverse


def assume(Z: np.ndarray, x: np.ndarray, time: float) -> DepthBelief:
    """The belief before any motion: the depths Z (n,) [m], such as those of the goal."""
    require_depths(Z)
    inverse = 1.0 / np.asarray(Z, float)
    return DepthBelief(inverse, (START_UNCERTAINTY * inverse) ** 2, inverse, x, time)


def update_depths(belief: DepthBelief, x: np.ndarray, V_C: np.ndarray, time: float) -> DepthBelief:
    """The belief after the features were seen at x (n, 2) at ``time`` [s], the camera having moved by V_C (w, v) relative to them.

    For a body that moves before a fixed camera, V_C is the opposite of its twist at C's origin in C.
    """
    dt = time - belief.time
    if dt <= 0:
        return belief
    w, v = V_C[:3], V_C[3:]
    L = point_interaction(0.5 * (x + belief.x), np.ones(len(x))).reshape(-1, 2, 6)
    H = dt * (L[:, :, 3:] @ v)  # (n, 2) change of the image for 1 / Z = 1
    moved = x - belief.x - dt * (L[:, :, :3] @ w)
    turn = x[:, 1] * w[0] - x[:, 0] * w[1]
    chi = belief.inverse + dt * (v[2] * belief.inverse**2 + turn * belief.inverse)
    P = belief.variance + (DRIFT * belief.start) ** 2 * dt
    information = (H**2).sum(1) / (2.0 * IMAGE_NOISE**2)
    gain = 1.0 / (1.0 / P + information)
    innovation = (H * (moved - chi[:, None] * H)).sum(1) / (2.0 * IMAGE_NOISE**2)
    chi = np.clip(chi + gain * innovation, LEAST_SHARE * belief.start, MOST_SHARE * belief.start)
    return DepthBelief(chi, gain, belief.start, x, time)
