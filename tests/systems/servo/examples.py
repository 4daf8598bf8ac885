"""Examples of the servo's systems for the laws."""

import numpy as np
from pydrake.common.value import Value

from vipr.systems import se3
from vipr.systems.arm.puma560 import WRIST as ARM
from vipr.systems.servo.controller import VisualServo
from vipr.systems.servo.image_based import ImageBased
from vipr.systems.servo.pose_delay import PoseDelay
from vipr.systems.servo.tasks import Reach
from vipr.systems.signals import ObjectPose

Q = np.array([0.1, 0.8, -2.5, 0.1, 0.9, 0.2])


def servo():
    X_OG = ARM.tool_pose(Q)  # with camera and object at the world's origin, the arm is at its goal
    corners = 0.1 * np.array([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)], float) + [0, 0, 1]
    system = VisualServo(ARM, Reach(np.eye(4), X_OG, corners), law=ImageBased(jacobian="estimated"))

    def fix(context, t):
        seen = ObjectPose(
            X_CO=se3.exp(np.array([0, 0, 0, 0.1 * t, 0, 0])), covariance=1e-6 * np.eye(6), state="tracking", time=t
        )
        system.GetInputPort("object_pose").FixValue(context, Value(seen))
        system.GetInputPort("joint_state").FixValue(context, np.concatenate([Q, np.zeros(6)]))

    return system, fix


def pose_delay():
    system = PoseDelay(2)

    def fix(context, t):
        system.get_input_port().FixValue(context, Value(ObjectPose(state="tracking", time=t)))

    return system, fix


EXAMPLES = {VisualServo: servo, PoseDelay: pose_delay}
