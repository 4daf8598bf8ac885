"""Motions of objects in scenarios: rest, constant speed, rest, with limited acceleration."""

import numpy as np
from pydrake.trajectories import PiecewisePolynomial

from vipr.systems.errors import InputError


def out_and_back(
    start: np.ndarray, velocity: np.ndarray, *, begin: float, cruise: float, ramp: float = 0.5, pause: float = 0.4
) -> PiecewisePolynomial:
    """Joint positions over time: rest until ``begin``, out at ``velocity`` for ``cruise`` seconds, a pause, back the same way, rest.

    With a cruise of 0 s there is no motion at all.

    Args:
        start: (n,) positions at rest.
        velocity: (n,) velocities while cruising, reached and left at constant acceleration within ``ramp`` seconds.
        begin, cruise, ramp, pause: times [s].

    Returns:
        a trajectory of n positions with continuous velocity; its end is when the motion ends.
    """
    if cruise == 0:  # no motion at all
        return PiecewisePolynomial.ZeroOrderHold([0.0, begin], np.column_stack([start, start]))
    if min(cruise, ramp) <= 0 or begin < 0 or pause < 0:
        raise InputError(
            f"motion: times must be positive, got begin {begin}, cruise {cruise}, ramp {ramp}, pause {pause} s"
        )
    shape = [
        (begin, 0.0),
        (ramp, 1.0),
        (cruise, 1.0),
        (ramp, 0.0),
        (pause, 0.0),
        (ramp, -1.0),
        (cruise, -1.0),
        (ramp, 0.0),
    ]
    shape = [(duration, factor) for duration, factor in shape if duration > 0]
    times = np.cumsum([0.0, *(duration for duration, _ in shape)])
    factors = np.array([0.0, *(factor for _, factor in shape)])
    distances = np.concatenate([[0.0], np.cumsum(np.diff(times) * (factors[1:] + factors[:-1]) / 2.0)])
    positions = np.asarray(start)[:, None] + np.outer(velocity, distances)
    return PiecewisePolynomial.CubicHermite(times, positions, np.outer(velocity, factors))
