"""The servo as a system: still before it sees, driven while it sees, stopped when the target is lost or the goal out of reach."""

import re

import numpy as np
import pytest
from pydrake.common.value import Value
from pydrake.systems.analysis import Simulator

from vipr.systems import se3
from vipr.systems.arm.puma560 import WRIST as ARM
from vipr.systems.errors import InputError
from vipr.systems.servo.controller import VisualServo, Workspace
from vipr.systems.servo.image_based import ImageBased
from vipr.systems.servo.tasks import Reach
from vipr.systems.signals import ObjectPose

Q = np.array([0.1, 0.8, -2.5, 0.1, 0.9, 0.2])
SHIFT = np.array([0.02, -0.01, 0.03])
CORNERS = 0.1 * np.array([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)], float)
HERE = Reach(np.eye(4), ARM.tool_pose(Q), CORNERS)


def rig(task=HERE, **settings):
    """``tick(time, object_pose)`` gives V_WE_W, servo_error and status after the servo's update at that time."""
    dut = VisualServo(ARM, task, **settings)
    simulator = Simulator(dut)
    context = simulator.get_mutable_context()
    dut.GetInputPort("joint_state").FixValue(context, np.concatenate([Q, np.zeros(6)]))

    def tick(time, seen):
        dut.GetInputPort("object_pose").FixValue(context, Value(seen))
        simulator.AdvanceTo(time)
        simulator.AdvancePendingEvents()
        return [dut.GetOutputPort(name).Eval(context) for name in ("V_WE_W", "servo_error", "status")]

    return tick


def seen(time, state="tracking", shift=SHIFT):
    return ObjectPose(X_CO=se3.pose(np.eye(3), shift), covariance=1e-8 * np.eye(6), state=state, time=time)


def test_hand_holds_still_before_the_first_pose():
    V, error, status = rig()(0.0, ObjectPose())
    assert np.array_equal(V, np.zeros(6))
    assert np.isnan(error).all() and status.text == ""


def test_hand_goes_where_the_object_went():
    V, error, status = rig()(0.0, seen(0.0))
    assert np.allclose(error[3:], SHIFT, atol=1e-6)
    assert np.allclose(V[3:], 2.0 * SHIFT, atol=1e-6)
    assert status.text == "servoing"


def test_hand_is_told_to_stop_at_the_first_tick_after_the_tracker_says_lost_and_goes_on_when_it_sees_again():
    tick = rig(report_after=0.3)
    V, *_ = tick(0.0, seen(0.0))
    assert np.linalg.norm(V) > 0
    V, _, status = tick(0.04, seen(0.04, state="lost"))
    assert np.array_equal(V, np.zeros(6))
    assert (status.level, status.text) == ("warning", "target lost: holding still")
    V, _, status = tick(0.40, seen(0.40, state="lost"))
    assert status.level == "error" and "more than 0.3 s" in status.text
    V, _, status = tick(0.44, seen(0.44))
    assert np.linalg.norm(V) > 0 and status.text == "servoing"


def test_uncertain_poses_are_not_taken_in_and_stop_the_hand_within_80_ms():
    tick = rig()
    V, *_ = tick(0.0, seen(0.0))
    still, *_ = tick(0.08, seen(0.08, state="uncertain", shift=2 * SHIFT))
    assert np.allclose(still, V, atol=1e-6)
    still, *_ = tick(0.12, seen(0.12, state="uncertain", shift=2 * SHIFT))
    assert np.array_equal(still, np.zeros(6))


def test_a_target_seen_again_after_long_is_not_taken_for_a_fast_one():
    tick = rig()
    tick(0.0, seen(0.0))
    V, error, _ = tick(2.0, seen(2.0, shift=2 * SHIFT))
    assert np.allclose(error[3:], 2 * SHIFT, atol=1e-6) and np.allclose(V[3:], 4 * SHIFT, atol=1e-5)


@pytest.mark.parametrize(
    ("workspace", "reason"),
    [
        (Workspace(radius=0.5), r"goal out of reach: \d\.\d\d m from the shoulder, at most 0.50 m"),
        (Workspace(lowest=2.0), r"goal out of reach: \d\.\d\d m high, at least 2.00 m"),
    ],
)
def test_a_goal_out_of_reach_stops_the_hand_with_the_reason(workspace, reason):
    V, _, status = rig(workspace=workspace)(0.0, seen(0.0))
    assert np.array_equal(V, np.zeros(6)) and status.level == "error"
    assert re.search(reason, status.text)


def test_a_feature_behind_the_camera_stops_the_hand_with_the_reason():
    V, _, status = rig(law=ImageBased())(0.0, seen(0.0, shift=[0.0, 0.0, -0.05]))
    assert np.array_equal(V, np.zeros(6))
    assert "depths must be positive" in status.text and status.level == "error"


def test_what_cannot_be_servoed_is_refused():
    with pytest.raises(InputError, match="X_OG must be a rigid 4x4 pose"):
        Reach(np.eye(4), np.full((4, 4), np.nan), CORNERS)
    with pytest.raises(InputError, match="3 feature points are needed, got 2"):
        VisualServo(ARM, Reach(np.eye(4), np.eye(4), CORNERS[:2]), law=ImageBased())
    with pytest.raises(InputError, match="patience must be positive, got 0 s"):
        VisualServo(ARM, HERE, patience=0)
