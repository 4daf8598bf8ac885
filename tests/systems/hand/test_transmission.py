"""The hand's gear trains."""

import numpy as np
import pytest

from vipr.systems.errors import InputError
from vipr.systems.hand import transmission
from vipr.systems.hand.transmission import DISTAL, PROXIMAL, SEATED, SPREAD

RNG = np.random.default_rng(8)
MOTOR = np.array([1.2, 0.8, 2.0, 0.7])
BROKEN = np.array([1.0, np.inf, 0.5])


def test_seated_outer_links_turn_a_third_as_far():
    q = transmission.joint_angles(MOTOR, SEATED)
    np.testing.assert_allclose(q[PROXIMAL], MOTOR[:3])
    np.testing.assert_allclose(q[DISTAL], MOTOR[:3] / 3)
    np.testing.assert_array_equal(q[SPREAD], MOTOR[3])


def test_the_outer_link_seen_from_the_palm_always_follows_the_motor():
    for break_away in (SEATED, BROKEN):
        q = transmission.joint_angles(MOTOR, break_away)
        np.testing.assert_allclose(q[PROXIMAL] + q[DISTAL], MOTOR[:3] * 125 / 93.75)
        np.testing.assert_allclose(transmission.motor_angles(q), MOTOR)


def test_broken_away_outer_links_are_four_times_as_fast():
    rates = [transmission.joint_rates(np.array([1, 1, 1, 2.0]), MOTOR, b) for b in (SEATED, BROKEN)]
    np.testing.assert_allclose(rates[1][DISTAL] / rates[0][DISTAL], [4, 1, 4])
    np.testing.assert_allclose(rates[1][PROXIMAL], [0, 1, 0])


def test_rates_are_the_derivative_of_the_angles():
    step, rate = 1e-6, np.array([1.0, -0.5, 0.3, 0.2])
    for break_away in (SEATED, BROKEN):
        ends = [transmission.joint_angles(MOTOR + s * step * rate, break_away) for s in (-1, 1)]
        v = transmission.joint_rates(rate, MOTOR, break_away)
        np.testing.assert_allclose((ends[1] - ends[0]) / (2 * step), v, atol=1e-8)


def test_motor_torques_do_the_work_of_the_joint_torques():
    torque = RNG.normal(size=8)
    for break_away in (SEATED, BROKEN):
        rate = RNG.normal(size=4)
        power = torque @ transmission.joint_rates(rate, MOTOR, break_away)
        motor = transmission.motor_torques(torque, np.isinf(break_away))
        assert motor @ rate == pytest.approx(power)


def test_a_force_on_the_inner_link_goes_through_the_clutch_and_one_on_the_wheel_past_it():
    inner_link_only = np.zeros(8)
    inner_link_only[PROXIMAL] = 0.4
    np.testing.assert_allclose(transmission.clutch_torques(inner_link_only), 0.4)
    couple_on_the_outer_link = np.zeros(8)
    couple_on_the_outer_link[PROXIMAL] = couple_on_the_outer_link[DISTAL] = 0.4
    np.testing.assert_allclose(transmission.clutch_torques(couple_on_the_outer_link), 0)


def test_the_encoders_count_what_the_manual_says():
    np.testing.assert_array_equal(transmission.counts(transmission.MOTOR_UPPER), [17500, 17500, 17500, 3150])
    np.testing.assert_allclose(transmission.from_counts(transmission.counts(MOTOR)), MOTOR, atol=5e-4)


def test_a_broken_away_finger_ends_at_its_outer_stop():
    upper = transmission.finger_upper(0.5)
    q = transmission.joint_angles(np.array([upper, 0, 0, 0]), np.array([0.5, np.inf, np.inf]))
    assert q[DISTAL[0]] == pytest.approx(np.radians(48))
    assert transmission.finger_upper(np.inf) == pytest.approx(np.radians(140))


@pytest.mark.parametrize(
    ("command", "message"),
    [
        ([2.6, 0, 0, 0], r"finger_1 commanded to 149.0 deg, allowed 0 to 140 deg"),
        ([0, 0, 0, -0.1], r"spread commanded to -5.7 deg, allowed 0 to 180 deg"),
        ([0, np.nan, 0, 0], r"finger_2 commanded to nan"),
        ([0, 0, 0], r"4 angles"),
    ],
)
def test_a_command_past_a_stop_is_refused(command, message):
    with pytest.raises(InputError, match=message):
        transmission.check_command(command)
