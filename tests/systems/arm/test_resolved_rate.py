"""Limits are kept, the direction survives them, singularities stay calm."""

import numpy as np
import pytest

from vipr.systems.arm.resolved_rate import Damping, JointLimits, braking_speed, damped_rates, limited_rates
from vipr.systems.errors import InputError

LIMITS = JointLimits(
    lower=-np.ones(3), upper=np.ones(3), speed=np.array([1.0, 2.0, 3.0]), acceleration=np.full(3, 10.0)
)
DT = 0.01


def test_far_from_singularities_the_twist_is_met_exactly():
    J = np.random.default_rng(3).normal(size=(6, 6)) + 2 * np.eye(6)
    V = np.arange(6.0)
    rates, lost = damped_rates(J, V, Damping(threshold=1e-3))
    assert lost == 0.0
    assert np.allclose(J @ rates, V)


def test_near_a_singularity_the_rates_stay_bounded():
    J = np.diag([1.0, 1, 1, 1, 1, 1e-9])
    V = np.ones(6)
    rates, lost = damped_rates(J, V)
    assert np.abs(rates).max() < 10
    assert np.allclose((J @ rates)[:5], V[:5]), "what the arm can still do it does exactly"
    assert 0.3 < lost < 1.0


@pytest.mark.parametrize("v", [0.3, 0.5, 0.77, 1.0, 1.49, 2.0, 3.7])
def test_the_braking_speed_is_exact_in_steps(v):
    a, dt = 10.0, 0.01
    room = 0.0
    speed = v
    while speed > 0:  # the way of a step at v and of steps each slower by a dt
        room += speed * dt
        speed -= a * dt
    assert braking_speed(room, a, dt) == pytest.approx(v)


def test_speed_limit_keeps_the_direction():
    wanted = np.array([4.0, 4.0, 4.0])
    rates, reason = limited_rates(wanted, np.zeros(3), wanted / 4.0, LIMITS, DT)
    assert reason == "speed"
    assert np.allclose(rates / rates[0], wanted / wanted[0])
    assert np.allclose(np.max(np.abs(rates) / LIMITS.speed), 1.0)


def test_acceleration_limit_ramps_from_rest():
    rates, reason = limited_rates(np.array([0.5, 0.0, 0.0]), np.zeros(3), np.zeros(3), LIMITS, DT)
    assert reason == "acceleration"
    assert np.allclose(rates, [0.1, 0, 0])


def test_a_joint_driven_at_its_stop_brakes_in_time_and_never_passes():
    q, v = np.zeros(3), np.zeros(3)
    for _ in range(400):
        new, _ = limited_rates(np.full(3, 1.0), q, v, LIMITS, DT)
        assert (np.abs(new - v) <= LIMITS.acceleration * DT + 1e-9).all()
        q, v = q + DT * new, new
        assert (q <= LIMITS.upper + 1e-12).all()
    assert np.allclose(q, LIMITS.upper, atol=1e-3)


def test_no_joint_is_faster_than_it_stops_in_the_given_time():
    bounded = LIMITS.stopping_within(0.15)
    assert np.allclose(bounded.speed, [1.0, 1.5, 1.5]), "a joint that stops sooner keeps its speed"
    q, v = np.zeros(3), np.zeros(3)
    for _ in range(30):
        v, _ = limited_rates(np.array([0.1, 9.0, 2.0]), q, v, bounded, DT)
    assert np.max(np.abs(v) / bounded.speed) == pytest.approx(1.0)
    for _ in range(15):
        v, _ = limited_rates(np.zeros(3), q, v, bounded, DT)
    assert np.allclose(v, 0.0, atol=1e-12)


def test_a_time_to_stop_in_that_is_not_positive_is_refused():
    with pytest.raises(InputError, match="joint limits: the time to stop in must be positive, got 0 s"):
        LIMITS.stopping_within(0.0)


def test_inverted_limits_are_refused():
    with pytest.raises(InputError, match="lower must be below upper"):
        JointLimits(np.ones(2), -np.ones(2), np.ones(2), np.ones(2))
