"""A slow vision chain: poses come out a whole number of frames later, with the time of their exposure."""

import pytest
from pydrake.common.value import Value
from pydrake.systems.analysis import Simulator

from vipr.systems.errors import InputError
from vipr.systems.servo.pose_delay import PoseDelay
from vipr.systems.signals import ObjectPose


def test_poses_come_two_frames_late():
    dut = PoseDelay(2)
    simulator = Simulator(dut)
    context, out = simulator.get_mutable_context(), []
    for k in range(4):
        dut.GetInputPort("object_pose").FixValue(context, Value(ObjectPose(state="tracking", time=0.04 * k)))
        simulator.AdvanceTo(0.04 * k)
        simulator.AdvancePendingEvents()
        out.append(dut.GetOutputPort("delayed_pose").Eval(context))
    assert [pose.state for pose in out] == ["lost", "lost", "tracking", "tracking"]
    assert [pose.time for pose in out[2:]] == [0.0, 0.04]


def test_no_delay_is_no_delay_system():
    with pytest.raises(InputError, match="frames must be 1 or more, got 0"):
        PoseDelay(0)
