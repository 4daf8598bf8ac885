"""The Kalman filter of eq. (3) to (9): position and velocity of one region, driven by Gaussian acceleration.

x and y share dynamics and noise, so that one 2x2 covariance serves both; plain floats, since a filter costs less than one array.
"""

from dataclasses import dataclass


@dataclass(frozen=True)
class Kalman:
    """State of one track [px, px/s] and the covariance of either axis."""

    x: float
    y: float
    vx: float = 0.0
    vy: float = 0.0
    pp: float = 0.0  # variance of position, px^2
    pv: float = 0.0  # covariance of position and velocity, px^2/s
    vv: float = 0.0  # variance of velocity, px^2/s^2


def start(x: float, y: float, sigma_n: float, sigma_v: float) -> Kalman:
    """A track first seen at (x, y) [px] with measurement noise sigma_n [px] and unknown velocity of scale sigma_v [px/s]."""
    return Kalman(x, y, 0.0, 0.0, sigma_n**2, 0.0, sigma_v**2)


def predict(k: Kalman, dt: float, sigma_w: float, damping: float = 0.0) -> Kalman:
    """Eq. (5) to (7): ``dt`` s later under acceleration noise sigma_w [px/s^2].

    ``damping`` [1/s] slows the velocity of a track that is not seen (0 is the paper's A).
    """
    keep = 1.0 / (1.0 + damping * dt)
    q = sigma_w**2
    pp = k.pp + 2 * dt * k.pv + dt**2 * k.vv + q * dt**4 / 4
    pv = keep * (k.pv + dt * k.vv) + q * dt**3 / 2
    vv = keep**2 * k.vv + q * dt**2
    return Kalman(k.x + dt * k.vx, k.y + dt * k.vy, keep * k.vx, keep * k.vy, pp, pv, vv)


def update(k: Kalman, x: float, y: float, sigma_n: float) -> Kalman:
    """Eq. (8), (9): the track after a region was seen at (x, y) [px] with noise sigma_n [px]."""
    x, y, s = float(x), float(y), float(k.pp + sigma_n**2)  # numpy's numbers are slow
    gain_p, gain_v = k.pp / s, k.pv / s
    dx, dy = x - k.x, y - k.y
    return Kalman(
        k.x + gain_p * dx, k.y + gain_p * dy, k.vx + gain_v * dx, k.vy + gain_v * dy,
        (1 - gain_p) * k.pp, (1 - gain_p) * k.pv, k.vv - gain_v * k.pv,
    )  # fmt: skip


def distance2(k: Kalman, x: float, y: float, sigma_n: float) -> float:
    """Squared Mahalanobis distance of a region at (x, y) [px] from the predicted track."""
    return ((x - k.x) ** 2 + (y - k.y) ** 2) / (k.pp + sigma_n**2)
