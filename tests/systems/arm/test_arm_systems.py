"""The arm's systems: set-points follow a twist, encoders count."""

import numpy as np
import pytest
from pydrake.systems.analysis import Simulator

from vipr.systems.arm.commander import ArmCommander
from vipr.systems.arm.encoders import JointEncoders
from vipr.systems.arm.puma560 import WRIST as ARM
from vipr.systems.arm.resolved_rate import JointLimits
from vipr.systems.errors import InputError

LIMITS = JointLimits(lower=np.full(6, -3.0), upper=np.full(6, 3.0), speed=np.full(6, 1.5), acceleration=np.full(6, 8.0))
Q = np.array([0.1, 0.8, -2.5, 0.1, 0.9, 0.2])


def test_set_points_move_the_tool_by_the_twist():
    V = np.array([0.0, 0.1, 0.0, 0.05, 0.0, -0.05])
    dut = ArmCommander(ARM, LIMITS, Q)
    simulator = Simulator(dut)
    context = simulator.get_mutable_context()
    dut.GetInputPort("V_WE_W").FixValue(context, V)
    simulator.AdvanceTo(1.005)
    X_before, X = ARM.tool_pose(Q), ARM.tool_pose(dut.GetOutputPort("desired_state").Eval(context)[:6])
    assert np.allclose(X[:3, 3] - X_before[:3, 3], V[3:], atol=2e-3)  # less the smooth start
    assert dut.GetOutputPort("limited_by").Eval(context)[0] == 0


def test_start_outside_the_limits_is_refused_with_the_joint_named():
    with pytest.raises(InputError, match=r"joint 2 starts at 229\.2 deg, allowed are -171\.9 to 171\.9 deg"):
        ArmCommander(ARM, LIMITS, np.array([0, 4.0, 0, 0, 0, 0]))


def test_encoders_round_to_whole_counts():
    dut = JointEncoders([0.1, 0.1], rate_window=0.5)
    context = dut.CreateDefaultContext()
    dut.get_input_port().FixValue(context, [0.26, -0.26, 0.31, 0.0])
    assert np.allclose(dut.get_output_port().Eval(context), [0.3, -0.3, 0.4, 0.0])
