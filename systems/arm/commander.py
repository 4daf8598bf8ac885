"""The arm's set-point generator: twists of the tool in, joint set-points out."""

import numpy as np
from pydrake.systems.framework import BasicVector, LeafSystem

from vipr.systems.arm.kinematics import SerialArm
from vipr.systems.arm.resolved_rate import Damping, JointLimits, damped_rates, limited_rates
from vipr.systems.errors import InputError
from vipr.systems.timing import LEDGER


class ArmCommander(LeafSystem):
    """Turns a twist of the tool into joint set-points that respect every limit of the arm.

    .. pydrake_system::

        name: ArmCommander
        input_ports:
        - V_WE_W
        output_ports:
        - desired_state
        - limited_by

    Frames: W world, E tool. ``V_WE_W`` (6) is the wanted twist of E (w, v) [rad/s, m/s], held between its updates. Every ``period``
    the set-points q (n) [rad] move by limited joint rates; ``desired_state`` (2n) is [q; qdot] for the joint servo and ``limited_by``
    (1) tells what limited the last step: 0 nothing, 1 speed, 2 acceleration, 3 position, 4 a singularity. The state starts at
    ``q_initial`` at rest.

    Source: damped least squares as in ``resolved_rate``.
    """

    REASONS = ("", "speed", "acceleration", "position", "singularity")

    def __init__(
        self,
        arm: SerialArm,
        limits: JointLimits,
        q_initial: np.ndarray,
        *,
        X_WB: np.ndarray | None = None,
        damping: Damping = Damping(),
        period: float = 0.01,
        offset: float = 0.0,
    ):
        super().__init__()
        q_initial = np.asarray(q_initial, float)
        outside = (q_initial < limits.lower) | (q_initial > limits.upper)
        if outside.any():
            joint = int(np.argmax(outside))
            raise InputError(
                f"arm: joint {joint + 1} starts at {np.rad2deg(q_initial[joint]):.1f} deg, allowed are "
                f"{np.rad2deg(limits.lower[joint]):.1f} to {np.rad2deg(limits.upper[joint]):.1f} deg"
            )
        self._arm, self._limits, self._damping, self._period = arm, limits, damping, period
        self._X_WB = np.eye(4) if X_WB is None else X_WB
        self._n = n = len(q_initial)
        self._V = self.DeclareVectorInputPort("V_WE_W", 6)
        state = self.DeclareDiscreteState(np.concatenate([q_initial, np.zeros(n), [0.0]]))
        self.DeclarePeriodicDiscreteUpdateEvent(period, offset, self._update)
        ticket = {self.discrete_state_ticket(state)}
        self.DeclareVectorOutputPort("desired_state", BasicVector(2 * n), self._calc_desired_state, ticket)
        self.DeclareVectorOutputPort("limited_by", BasicVector(1), self._calc_limited_by, ticket)

    def _state(self, context) -> np.ndarray:
        return context.get_discrete_state_vector().CopyToVector()

    def _update(self, context, discrete_state):
        with LEDGER.charge("control"):
            state = self._state(context)
            q, rates = state[: self._n], state[self._n : -1]
            V_BE_B = self._V.Eval(context).copy()
            R_BW = self._X_WB[:3, :3].T
            V_BE_B[:3], V_BE_B[3:] = R_BW @ V_BE_B[:3], R_BW @ V_BE_B[3:]
            _, J = self._arm.tool_pose_and_jacobian(q)
            wanted, smallest = damped_rates(J, V_BE_B, self._damping)
            new, reason = limited_rates(wanted, q, rates, self._limits, self._period)
            if not reason and smallest < self._damping.threshold:
                reason = "singularity"
            q = np.clip(q + self._period * new, self._limits.lower, self._limits.upper)
            discrete_state.set_value(np.concatenate([q, new, [self.REASONS.index(reason)]]))

    def _calc_desired_state(self, context, output):
        output.set_value(self._state(context)[:-1])

    def _calc_limited_by(self, context, output):
        output.set_value(self._state(context)[-1:])
