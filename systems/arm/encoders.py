"""Joint encoders: the only way from the arm's true state to its controllers."""

import numpy as np
from pydrake.systems.framework import BasicVector, LeafSystem

from vipr.systems.errors import InputError


class JointEncoders(LeafSystem):
    """Measures joint angles in whole encoder counts.

    .. pydrake_system::

        name: JointEncoders
        input_ports:
        - state
        output_ports:
        - joint_state

    ``state`` (2n) is the true [q; qdot] of n joints [rad, rad/s]; ``joint_state`` (2n) the measured one: angles rounded to the
    resolution, rates to one count in ``rate_window`` seconds (as from counting pulses). Feedthrough, nothing is held.
    """

    def __init__(self, resolution: np.ndarray, rate_window: float = 0.01):
        super().__init__()
        self._resolution = np.asarray(resolution, float)
        if not (self._resolution > 0).all():
            raise InputError(f"encoders: resolution must be positive, got {self._resolution} rad")
        self._rate = self._resolution / rate_window
        n = 2 * len(self._resolution)
        self._true = self.DeclareVectorInputPort("state", n)
        self.DeclareVectorOutputPort("joint_state", BasicVector(n), self._calc_joint_state, {self._true.ticket()})

    def _calc_joint_state(self, context, output):
        state = self._true.Eval(context)
        steps = np.concatenate([self._resolution, self._rate])
        output.set_value(np.round(state / steps) * steps)
