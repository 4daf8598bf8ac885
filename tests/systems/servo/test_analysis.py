"""The sampled model of the loop: limits known in closed form, and what it says of the step."""

from dataclasses import replace

import numpy as np
import pytest

from vipr.systems.errors import InputError
from vipr.systems.servo.analysis import (
    ArmResponse,
    SampledLoop,
    behaviour,
    is_stable,
    largest_stable_gain,
    largest_stable_latency,
    poles,
    quickest_gain,
    step_response,
)

STIFF = ArmResponse.second_order(2e4, 1.0)  # follows at once
T = 0.04


@pytest.mark.parametrize("pictures, limit", [(0, 2.0), (1, 1.0), (2, 0.5 * (np.sqrt(5) - 1))])
def test_an_integrator_seen_so_many_periods_late_has_the_textbook_limit(pictures, limit):
    loop = SampledLoop(STIFF, latency=pictures * T, camera=T, arm=T, arm_offset=0.0)
    assert largest_stable_gain(loop) == pytest.approx(limit / T, rel=5e-3)


def test_without_delay_the_pole_is_that_of_the_sampled_exponential():
    loop = SampledLoop(STIFF, latency=0.0, camera=T, arm=T, arm_offset=0.0)
    assert poles(loop, 5.0)[0] == pytest.approx(1.0 - 5.0 * T, abs=1e-3)


def test_latency_costs_margin_unless_the_encoders_bridge_it():
    late = [SampledLoop(latency=latency) for latency in (0.02, 0.06, 0.1, 0.2)]
    limits = [largest_stable_gain(loop) for loop in late]
    assert (np.diff(limits) < 0).all()
    bridged = largest_stable_gain(SampledLoop(latency=0.2, use="predicted"))
    assert bridged > 4 * limits[-1]


def test_limits_of_gain_and_of_latency_agree():
    loop = SampledLoop(latency=0.1)
    gain = largest_stable_gain(loop)
    assert is_stable(loop, 0.99 * gain) and not is_stable(loop, 1.01 * gain)
    assert 0.1 <= largest_stable_latency(loop, gain) <= 0.105  # the arm's next set-point is at 104 ms
    assert largest_stable_latency(replace(loop, use="predicted"), 2.0) == 2.0


def test_the_step_decays_by_the_slowest_pole_and_settles_as_told():
    loop = SampledLoop(latency=0.022)
    times, places = step_response(loop, 2.0, 3.0)
    late = (times > 1.0) & (np.arange(len(times)) % 4 == 0)
    assert np.allclose(places[late][1:] / places[late][:-1], abs(poles(loop, 2.0)[0]), rtol=1e-3)
    told = behaviour(loop, 2.0)
    assert told.stable and told.margin > 5 and told.overshoot < 1e-3
    assert np.abs(places[times > told.settling]).max() <= 0.02 < np.abs(places[times < told.settling - 0.02]).min()


def test_the_quickest_gain_overshoots_as_much_as_allowed_and_an_unstable_one_is_told():
    loop = SampledLoop(latency=0.1)
    gain = quickest_gain(loop, overshoot=0.05)
    assert behaviour(loop, gain).overshoot == pytest.approx(0.05, abs=0.01)
    assert not behaviour(loop, 1.2 * largest_stable_gain(loop)).stable


@pytest.mark.parametrize(
    "change, said",
    [
        ({"latency": -0.01}, "latency must be 0 to 2000 ms, got -10 ms"),
        ({"latency": float("nan")}, "latency must be 0 to 2000 ms, got nan ms"),
        ({"arm": 0.03}, "the arm's period must divide the camera's, got 30 and 40 ms"),
        ({"use": "guessed"}, "use must be delayed or predicted, got 'guessed'"),
    ],
)
def test_impossible_clocks_are_refused(change, said):
    with pytest.raises(InputError, match=said):
        SampledLoop(**change)


def test_a_gain_of_zero_is_refused():
    with pytest.raises(InputError, match="gain must be above 0"):
        behaviour(SampledLoop(), 0.0)
