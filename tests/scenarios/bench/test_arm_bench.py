"""The arm's benchmark: its stop, whose set-points are known."""

import pytest

from vipr.diagrams.servo_robot import STOPPING_TIME, Schedule
from vipr.scenarios.bench.arm_stop import STEP, stopping


def test_set_points_stand_in_the_stopping_time_and_the_arm_a_period_later():
    figures = {name: worst for name, _, worst in stopping(1, seed=3).rows}
    assert figures["speed of the hand before, mm/s"] > 20
    # The first of the steps that brake comes at once, the last a period before the stopping time is over.
    rest = 1e3 * (STOPPING_TIME - Schedule().arm)
    assert figures["set-points at rest, ms"] == pytest.approx(rest, abs=1e3 * STEP + 0.1)
    assert 0.5 * rest < figures["the hand stands, ms"] < rest + 1e3 * (Schedule().arm + 2 * STEP)
    assert 0.0 < figures["swing, mm"] < 0.5
