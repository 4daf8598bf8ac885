"""The witness of the arm's limits: the largest share of each, over the whole run."""

import numpy as np
from pydrake.systems.analysis import Simulator

from vipr.systems.arm.limit_use import LimitUse
from vipr.systems.arm.resolved_rate import JointLimits

LIMITS = JointLimits(
    lower=np.array([-1.0, -1.0]), upper=np.array([1.0, 3.0]), speed=np.full(2, 2.0), acceleration=np.full(2, 10.0)
)


def test_worst_joint_at_the_worst_moment_counts():
    dut = LimitUse(LIMITS)
    simulator = Simulator(dut)
    context = simulator.get_mutable_context()
    for k, desired in enumerate(([0.5, 1.0, 0.0, 0.0], [0.0, 2.0, 0.08, -0.02], [0.0, 1.0, 0.08, -0.02])):
        dut.get_input_port().FixValue(context, desired)
        simulator.AdvanceTo(0.01 * k)
        simulator.AdvancePendingEvents()
    assert np.allclose(dut.get_output_port().Eval(context), [0.5, 0.04, 0.8])


def test_a_broken_limit_shows_as_more_than_one():
    dut = LimitUse(LIMITS)
    simulator = Simulator(dut)
    context = simulator.get_mutable_context()
    dut.get_input_port().FixValue(context, [0.0, 3.1, 0.0, 2.5])
    simulator.AdvancePendingEvents()
    assert (dut.get_output_port().Eval(context)[:2] > 1.0).all()
