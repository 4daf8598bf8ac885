"""The tracker as a system: what its ports do."""

import numpy as np
from drawn_objects import LENS, box, picture, pose_at
from pydrake.systems.analysis import Simulator

from vipr.systems.signals import CameraFrame, ObjectPose
from vipr.systems.tracking.tracker import ModelTracker


def frame(t, number, pose=None):
    return CameraFrame(picture(box(), pose_at(0.0) if pose is None else pose), t, number)


def run(system, context, until):
    simulator = Simulator(system, context)
    simulator.Initialize()
    simulator.AdvanceTo(until)
    return system.GetOutputPort("object_pose").Eval(context)


def test_before_the_first_frame_the_object_is_lost():
    system = ModelTracker(box(), LENS, X_CO_initial=pose_at(0.0))
    assert not system.HasAnyDirectFeedthrough()
    context = system.CreateDefaultContext()
    system.GetInputPort("frame").FixValue(context, CameraFrame())
    assert system.GetOutputPort("object_pose").Eval(context).state == "lost"


def test_a_frame_is_taken_up_at_the_tick_and_says_when_it_was_seen():
    system = ModelTracker(box(), LENS, X_CO_initial=pose_at(0.0), offset=0.01)
    context = system.CreateDefaultContext()
    system.GetInputPort("frame").FixValue(context, frame(0.005, 7))
    pose = run(system, context, 0.02)
    assert (pose.state, pose.time, pose.number) == ("tracking", 0.005, 7)
    assert np.allclose(pose.X_CO, pose_at(0.0), atol=0.01)
    assert pose.nodes > 20 and 0 < pose.residual_px < 1 and 0.5 < pose.score <= 1


def test_a_pose_from_outside_starts_it_afresh_once():
    system = ModelTracker(box(), LENS)
    context = system.CreateDefaultContext()
    system.GetInputPort("frame").FixValue(context, frame(0.0, 0))
    assert run(system, context, 0.02).state == "lost"  # nobody has said where the object is
    system.GetInputPort("initial_pose").FixValue(context, ObjectPose(X_CO=pose_at(0.0), state="tracking", time=0.03))
    system.GetInputPort("frame").FixValue(context, frame(0.04, 1))
    simulator = Simulator(system, context)
    simulator.Initialize()
    simulator.AdvanceTo(0.05)
    assert system.GetOutputPort("object_pose").Eval(context).state == "tracking"
    system.GetInputPort("frame").FixValue(context, frame(0.08, 2, pose_at(0.1)))
    simulator.AdvanceTo(0.09)
    moved = system.GetOutputPort("object_pose").Eval(context)
    assert moved.state == "tracking" and np.allclose(moved.X_CO, pose_at(0.1), atol=0.01)
