"""Example of the pick for the laws."""

import numpy as np
from pick_doubles import X_WO, picker, sighting

from vipr.diagrams.workcell_layout import fixed_camera
from vipr.systems import se3
from vipr.systems.arm import puma560
from vipr.systems.grasping.hand_over import Arrival, HandOver
from vipr.systems.grasping.task import PickTask
from vipr.systems.signals import Status


def pick_task():
    """An object is seen, reached for and lost sight of."""
    system = PickTask(picker(), se3.inverse(fixed_camera()) @ X_WO)

    def fix(context, t):
        state = np.concatenate([puma560.NAMED["nominal"], np.zeros(6)])
        system.GetInputPort("object_pose").FixValue(context, sighting(t, state="tracking" if t < 0.25 else "lost"))
        system.GetInputPort("joint_state").FixValue(context, state)
        system.GetInputPort("motor_position").FixValue(context, [0.1, 0.1, 0.1, 0.0])
        system.GetInputPort("motor_torque").FixValue(context, [0.0, 0.0, t, 0.0])

    return system, fix


def hand_over():
    """The pick ends, and the object comes to its place."""
    system = HandOver(arrival=Arrival(stay_s=0.1))

    def fix(context, t):
        system.GetInputPort("V_pick").FixValue(context, np.full(6, 0.1))
        system.GetInputPort("pick_phase").FixValue(context, Status("held" if t > 0.1 else "lift"))
        system.GetInputPort("pick_watching").FixValue(context, [0.0])
        system.GetInputPort("V_place").FixValue(context, np.full(6, 0.2))
        system.GetInputPort("servo_error").FixValue(context, np.full(6, max(0.3 - t, 0.0)))
        system.GetInputPort("servo_status").FixValue(context, Status("servoing"))

    return system, fix


EXAMPLES = {PickTask: pick_task, HandOver: hand_over}
