"""Examples of the arm's systems for the laws."""

import numpy as np

from vipr.systems import se3
from vipr.systems.arm.commander import ArmCommander
from vipr.systems.arm.encoders import JointEncoders
from vipr.systems.arm.limit_use import LimitUse
from vipr.systems.arm.puma560 import WRIST as ARM
from vipr.systems.arm.puma_body import hand_guard
from vipr.systems.arm.resolved_rate import JointLimits
from vipr.systems.arm.set_points import SetPointInterpolator
from vipr.systems.arm.shapes import box

LIMITS = JointLimits(lower=np.full(6, -3.0), upper=np.full(6, 3.0), speed=np.full(6, 1.5), acceleration=np.full(6, 8.0))
GUARD = hand_guard(ARM, (box("floor", (6, 6, 1), se3.pose(np.eye(3), [0, 0, -0.5])),))
Q = np.array([0.1, 0.8, -2.5, 0.1, 0.9, 0.2])


def commander():
    system = ArmCommander(ARM, LIMITS, Q, guard=GUARD)

    def fix(context, t):
        system.GetInputPort("V_WE_W").FixValue(context, [0.1, 0, 0.2, 0.1 * t, -0.05, 0.02])
        system.GetInputPort("motor_position").FixValue(context, np.full(4, 0.3 * t))

    return system, fix


def encoders():
    system = JointEncoders(np.full(6, 1e-4))
    return system, lambda context, t: system.get_input_port().FixValue(context, np.sin(np.arange(12) + t))


def limit_use():
    system = LimitUse(LIMITS)
    return system, lambda context, t: system.get_input_port().FixValue(context, 0.1 * np.sin(np.arange(12) + t))


def interpolator():
    system = SetPointInterpolator(Q)
    return system, lambda context, t: system.get_input_port().FixValue(context, 0.1 * np.sin(np.arange(12) + t))


EXAMPLES = {
    LimitUse: limit_use,
    ArmCommander: commander,
    JointEncoders: encoders,
    SetPointInterpolator: interpolator,
}
