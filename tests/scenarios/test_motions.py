"""Motions go out at the stated speed and come back to where they began."""

import numpy as np
import pytest

from vipr.scenarios.motions import out_and_back
from vipr.systems.errors import InputError


def test_out_and_back_returns_and_keeps_its_speed():
    start, velocity = np.array([0.1, 0.2, 0.3]), np.array([0.05, 0.0, -0.1])
    motion = out_and_back(start, velocity, begin=2.0, cruise=1.5)
    for time in (0.0, 2.0, motion.end_time()):
        assert np.allclose(motion.value(time).ravel(), start)
    assert np.allclose(motion.EvalDerivative(3.0, 1).ravel(), velocity)
    assert np.allclose(motion.EvalDerivative(motion.end_time(), 1), 0)


def test_impossible_times_are_refused():
    with pytest.raises(InputError, match="times must be positive"):
        out_and_back(np.zeros(1), np.ones(1), begin=0, cruise=-1)


def test_without_cruise_the_object_rests():
    motion = out_and_back(np.array([0.1, 0.2]), np.ones(2), begin=1.0, cruise=0)
    assert np.allclose(motion.value(0.5).ravel(), [0.1, 0.2]) and motion.end_time() == 1.0
