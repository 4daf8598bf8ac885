"""Set-points in steps become a motion: through them all, its rates the derivative of its angles, its end exactly theirs."""

import numpy as np
import pytest
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder, LeafSystem

from vipr.systems.arm.set_points import SetPointInterpolator
from vipr.systems.errors import InputError

RATES = np.array([0.0, 0.1, 0.2, 0.3, 0.3, 0.3, 0.15, -0.1, 0.0, 0.0, 0.0])  # rad/s, one every PERIOD
PERIOD, STEP = 0.01, 0.002
Q0 = 0.7


class Steps(LeafSystem):
    """Set-points of one joint at the RATES, as the arm's controller gives them."""

    def __init__(self):
        super().__init__()
        self.DeclareVectorOutputPort("set_points", 2, self._calc)

    def _calc(self, context, output):
        k = min(int(context.get_time() / PERIOD + 1e-9), len(RATES) - 1)
        output.set_value([Q0 + PERIOD * RATES[: k + 1].sum(), RATES[k]])


@pytest.fixture(scope="module")
def motion():
    """Angles, rates and accelerations (K,) every STEP."""
    builder = DiagramBuilder()
    steps, dut = builder.AddSystem(Steps()), builder.AddSystem(SetPointInterpolator(np.array([Q0])))
    builder.Connect(steps.get_output_port(), dut.get_input_port())
    simulator = Simulator(builder.Build())
    context = dut.GetMyContextFromRoot(simulator.get_context())
    rows = []
    for k in range(round((len(RATES) + 2) * PERIOD / STEP)):
        simulator.AdvanceTo(k * STEP)  # the outputs of the tick itself: its update is not done yet
        state = dut.GetOutputPort("desired_state").Eval(context)
        rows.append([*state, *dut.GetOutputPort("desired_acceleration").Eval(context)])
    return np.array(rows).T


def test_angles_are_the_integral_of_the_rates_and_rates_of_the_acceleration(motion):
    q, v, a = motion
    assert np.allclose(np.diff(v), a[1:] * STEP, atol=1e-12)
    assert np.allclose(np.diff(q), v[1:] * STEP, atol=1e-12)


def test_rates_never_jump_and_reach_each_set_points_own(motion):
    _, v, a = motion
    assert np.abs(a).max() <= np.abs(np.diff(RATES)).max() / PERIOD + 1e-9
    per = round(PERIOD / STEP)
    for k, rate in enumerate(RATES):
        assert v[(k + 1) * per - 1] == pytest.approx(rate, abs=1e-12)


def test_the_motion_ends_at_the_last_set_point_a_period_after_it(motion):
    q, v, _ = motion
    end = int(np.flatnonzero(RATES)[-1]) + 1  # the first set-point at rest
    after = round((end + 1) * PERIOD / STEP)
    assert np.allclose(v[after:], 0.0, atol=1e-12)
    assert np.allclose(q[after:], Q0 + PERIOD * RATES.sum(), atol=1e-9)


def test_a_motion_without_steps_is_refused():
    with pytest.raises(InputError, match=r"need a period above 0 s and a step or more, got 0\.01 s and 0"):
        SetPointInterpolator(np.zeros(6), steps=0)
