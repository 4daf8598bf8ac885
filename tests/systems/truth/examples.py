"""Examples of the truth systems for the laws."""

import numpy as np
from pydrake.common.value import Value
from pydrake.math import RigidTransform

from vipr.systems import se3
from vipr.systems.arm.puma560 import WRIST as ARM
from vipr.systems.signals import ObjectPose
from vipr.systems.truth import AlignmentError, KinematicTruth, PlacementError, PoseTruth, TrackingError


def moved(t):
    return RigidTransform(se3.exp(np.array([0.1 * t, 0.2, 0, 0.3, t, 0.4])))


def pose_truth():
    system = PoseTruth(1, 2, np.eye(4), moved(3).GetAsMatrix4())
    poses = Value[list[RigidTransform]]

    def fix(context, t):
        system.get_input_port().FixValue(context, poses([RigidTransform(), moved(t), moved(2 * t)]))

    return system, fix


def tracking_error():
    system = TrackingError()

    def fix(context, t):
        estimate = ObjectPose(X_CO=moved(t + 0.1).GetAsMatrix4(), state="tracking" if t > 0.1 else "lost")
        system.GetInputPort("X_CO_true").FixValue(context, Value(moved(t)))
        system.GetInputPort("object_pose").FixValue(context, Value(estimate))

    return system, fix


def alignment_error():
    system = AlignmentError(moved(1).GetAsMatrix4())

    def fix(context, t):
        system.GetInputPort("X_WO_true").FixValue(context, Value(moved(t)))
        system.GetInputPort("X_WE_true").FixValue(context, Value(moved(t + 0.5)))

    return system, fix


def kinematic_truth():
    system = KinematicTruth(ARM, np.eye(4), X_EC=moved(2).GetAsMatrix4())

    def fix(context, t):
        system.GetInputPort("joint_state").FixValue(context, 0.3 * np.sin(np.arange(12) + t))
        system.GetInputPort("stage_desired_state").FixValue(context, 0.1 * np.cos(np.arange(6) + t))

    return system, fix


def placement_error():
    system = PlacementError(moved(1).GetAsMatrix4())
    return system, lambda context, t: system.get_input_port().FixValue(context, Value(moved(t)))


EXAMPLES = {
    PoseTruth: pose_truth,
    KinematicTruth: kinematic_truth,
    TrackingError: tracking_error,
    AlignmentError: alignment_error,
    PlacementError: placement_error,
}
