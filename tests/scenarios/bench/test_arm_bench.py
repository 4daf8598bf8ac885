"""The arm's benchmark: its stop, whose set-points are known."""

import pytest

from vipr.diagrams.servo_robot import STOPPING_TIME
from vipr.scenarios.bench.arm_stop import STEP, WATCHED, stopping


def test_set_points_stand_in_the_stopping_time_and_the_arm_behind_them_soon_after():
    figures = {name: worst for name, _, worst in stopping(1, seed=3).rows}
    assert figures["speed of the hand before, mm/s"] > 20
    # The first of the steps that brake comes at once, the last a period before the stopping time is over.
    assert figures["set-points at rest, ms"] == pytest.approx(1e3 * (STOPPING_TIME - 0.01), abs=1e3 * STEP + 0.1)
    assert figures["set-points at rest, ms"] < figures["the hand turns, ms"] < 1e3 * WATCHED
    assert 0.0 < figures["swing, mm"] < 5.0
