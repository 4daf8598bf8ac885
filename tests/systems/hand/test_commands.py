"""The hand in the words of its user."""

import numpy as np
import pytest

from vipr.systems.errors import InputError
from vipr.systems.hand import commands, transmission

NOW = np.array([0.4, 0.5, 0.6, 0.3])


def test_open_close_and_spread_leave_the_rest_as_it_is():
    np.testing.assert_array_equal(commands.open_fingers(NOW)[0], [0, 0, 0, 0.3])
    np.testing.assert_allclose(commands.close_fingers(NOW)[0], [*transmission.MOTOR_UPPER[:3], 0.3])
    np.testing.assert_array_equal(commands.spread_to(NOW, 1.0)[0], [0.4, 0.5, 0.6, 1.0])
    np.testing.assert_array_equal(commands.stop(NOW)[0], NOW)


def test_counts_are_those_of_the_manual():
    np.testing.assert_allclose(
        commands.go_to_counts(np.array([17500, 0, 8750, 3150]))[0], np.radians([140, 0, 70, 180])
    )


def test_a_grasp_lets_finger_3_stand_against_two():
    _, limit = commands.grasp(NOW, 5.0)
    np.testing.assert_allclose(limit[:3], [0.6, 0.6, 1.2])
    assert commands.grasp(NOW, 15.0)[1][2] == 1.8


@pytest.mark.parametrize(
    ("command", "message"),
    [
        (lambda: commands.grasp(NOW, 16.0), "at most 15 N at a tip, got 16 N"),
        (lambda: commands.spread_to(NOW, 4.0), "spread commanded to 229.2 deg, allowed 0 to 180 deg"),
        (lambda: commands.go_to_counts(np.array([20000, 0, 0, 0])), "finger_1 commanded to 160.0 deg"),
        (lambda: commands.go_to(np.zeros(3)), "a command has 4 angles"),
    ],
)
def test_what_the_hand_cannot_do_is_refused(command, message):
    with pytest.raises(InputError, match=message):
        command()
