"""Paths through joint space: smooth, at rest at both ends, within the limits."""

import numpy as np
import pytest

from vipr.systems.arm.joint_path import ACCELERATION_SHARE, SPEED_SHARE, joint_path
from vipr.systems.arm.resolved_rate import JointLimits
from vipr.systems.errors import InputError

LIMITS = JointLimits(np.full(3, -3.0), np.full(3, 3.0), np.array([1.0, 2.0, 3.0]), np.array([4.0, 4.0, 8.0]))
POINTS = np.array([[0.0, 0.0, 0.0], [0.3, 0.5, -0.4], [0.2, 1.0, -1.0]])


def test_speeds_and_accelerations_stay_within_their_share():
    path = joint_path(POINTS, LIMITS)
    times = np.linspace(0.0, path.duration, 2000)
    rates = np.array([path.at(t)[1] for t in times])
    accelerations = np.diff(rates, axis=0) / (times[1] - times[0])
    assert (np.abs(rates).max(0) <= SPEED_SHARE * LIMITS.speed * 1.001).all()
    assert (np.abs(accelerations).max(0) <= ACCELERATION_SHARE * LIMITS.acceleration * 1.01).all()


def test_rates_are_those_of_the_angles_and_the_ends_are_at_rest():
    path = joint_path(POINTS, LIMITS)
    for t in (0.2, 0.5):
        step = (path.at(t + 1e-5)[0] - path.at(t - 1e-5)[0]) / 2e-5
        np.testing.assert_allclose(path.at(t)[1], step, atol=1e-6)
    np.testing.assert_allclose(path.at(0.0)[0], POINTS[0], atol=1e-12)
    np.testing.assert_allclose(path.at(99.0)[0], POINTS[-1], atol=1e-12)
    assert not path.at(0.0)[1].any() and not path.at(99.0)[1].any()


def test_the_way_back_is_the_way():
    path = joint_path(POINTS, LIMITS)
    back = path.reversed()
    np.testing.assert_allclose(back.at(0.3 * path.duration)[0], path.at(0.7 * path.duration)[0], atol=1e-3)


def test_a_slow_tool_takes_its_time_and_one_point_is_no_path():
    assert joint_path(POINTS, LIMITS, length=1.0, speed=0.1).duration == pytest.approx(18.75)
    with pytest.raises(InputError, match="needs two or more finite points"):
        joint_path(POINTS[:1], LIMITS)
