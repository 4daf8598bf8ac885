"""The servo as a system: still before it sees, driven while it sees, stopped when the target is lost."""

import numpy as np
import pytest
from pydrake.common.value import Value
from pydrake.systems.analysis import Simulator

from vipr.systems import se3
from vipr.systems.arm.puma560 import WRIST as ARM
from vipr.systems.errors import InputError
from vipr.systems.servo.controller import PositionBasedServo
from vipr.systems.signals import ObjectPose

Q = np.array([0.1, 0.8, -2.5, 0.1, 0.9, 0.2])
SHIFT = np.array([0.02, -0.01, 0.03])


@pytest.fixture
def rig():
    dut = PositionBasedServo(ARM, np.eye(4), ARM.tool_pose(Q))
    simulator = Simulator(dut)
    context = simulator.get_mutable_context()
    dut.GetInputPort("joint_state").FixValue(context, np.concatenate([Q, np.zeros(6)]))

    def tick(time, seen):
        dut.GetInputPort("object_pose").FixValue(context, Value(seen))
        simulator.AdvanceTo(time)
        simulator.AdvancePendingEvents()
        return dut.GetOutputPort("V_WE_W").Eval(context), dut.GetOutputPort("servo_error").Eval(context)

    return tick


def seen(time, state="tracking"):
    return ObjectPose(X_CO=se3.pose(np.eye(3), SHIFT), covariance=1e-8 * np.eye(6), state=state, time=time)


def test_hand_holds_still_before_the_first_pose(rig):
    V, error = rig(0.0, ObjectPose())
    assert np.array_equal(V, np.zeros(6))
    assert np.isnan(error).all()


def test_hand_goes_where_the_object_went(rig):
    V, error = rig(0.0, seen(0.0))
    assert np.allclose(error[3:], SHIFT, atol=1e-6)
    assert np.allclose(V[3:], 2.0 * SHIFT, atol=1e-6)


def test_hand_stops_within_80_ms_of_losing_the_target(rig):
    rig(0.0, seen(0.0))
    V, _ = rig(0.08, seen(0.08, state="lost"))
    assert np.linalg.norm(V) > 0
    V, _ = rig(0.12, seen(0.08, state="lost"))
    assert np.array_equal(V, np.zeros(6))


def test_uncertain_poses_do_not_move_the_hand(rig):
    V, _ = rig(0.0, seen(0.0, state="uncertain"))
    assert np.array_equal(V, np.zeros(6))


def test_a_goal_that_is_no_pose_is_refused():
    with pytest.raises(InputError, match="X_OG must be a rigid 4x4 pose"):
        PositionBasedServo(ARM, np.eye(4), np.full((4, 4), np.nan))
