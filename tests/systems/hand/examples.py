"""Examples of the hand's systems for the laws."""

import numpy as np

from vipr.systems.hand import transmission
from vipr.systems.hand.driver import HandDriver


def driver():
    """Fingers that follow for 0.1 s, are then blocked, and are opened at 0.2 s."""
    system = HandDriver()

    def fix_inputs(context, t):
        angle = 2.0 * min(t, 0.1)
        q = transmission.joint_angles(np.array([angle, angle, angle, 0.3]), transmission.SEATED)
        v = np.full(8, 2.0 if t < 0.1 else 0.0)
        torque = np.zeros(8) if t < 0.1 else np.array([0, 0.7, 0.1, 0, 0.3, 0.1, 0.9, 0.05])
        system.GetInputPort("motor_command").FixValue(context, [2, 2, 2, 0.5] if t < 0.2 else [0, 0, 0, 0])
        system.GetInputPort("hand_state").FixValue(context, np.concatenate([q, v]))
        system.GetInputPort("joint_torque").FixValue(context, torque)
        system.GetInputPort("torque_limit").FixValue(context, [0.8, 0.8, 1.6, 2.0])

    return system, fix_inputs


EXAMPLES = {HandDriver: driver}
