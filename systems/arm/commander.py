"""The arm's set-point generator: twists of the tool in, joint set-points out."""

import numpy as np
from pydrake.common.value import Value
from pydrake.systems.framework import BasicVector, LeafSystem

from vipr.systems.arm.guard import CollisionGuard, guarded_rates
from vipr.systems.arm.kinematics import SerialArm
from vipr.systems.arm.resolved_rate import Damping, JointLimits, damped_rates, limited_rates
from vipr.systems.errors import InputError
from vipr.systems.signals import Status
from vipr.systems.timing import LEDGER

HAND_MOVED = 0.01  # rad, of a motor's angle, by which the gaps of the fingers are looked at anew
LOST = 0.01  # share of the twist that a singularity must take away to be named


class ArmCommander(LeafSystem):
    """Turns a twist of the tool into joint set-points that respect every limit of the arm and touch nothing.

    .. pydrake_system::

        name: ArmCommander
        input_ports:
        - V_WE_W
        - motor_position
        output_ports:
        - desired_state
        - limited_by
        - status

    Frames: W world, E tool. ``V_WE_W`` (6) is the wanted twist of E (w, v) [rad/s, m/s], held between its updates. Every ``period``
    the set-points q (n) [rad] move by limited joint rates; ``desired_state`` (2n) is [q; qdot] for the joint servo. Limits keep the
    direction of the motion: they make it slower, to a halt if need be. ``limited_by`` (1) tells what limited the last step: 0 nothing,
    1 speed, 2 acceleration, 3 position, 4 a singularity, 5 a collision; ``status`` (Status) says it in words, for a collision with the
    two shapes that came near each other. Without a ``guard`` nothing is kept from colliding. ``motor_position`` (4), the motor angles of
    the hand [rad], tells the guard where the fingers are; left unconnected, they are where the guard's body has them. The state starts
    at ``q_initial`` at rest. No joint moves faster than it can be brought to rest within ``stopping_time`` seconds: once a zero twist
    is asked for, the set-points stand after that time.

    Source: damped least squares as in ``resolved_rate``; collisions as in ``guard``.
    """

    REASONS = ("", "speed", "acceleration", "position", "singularity", "collision")

    def __init__(
        self,
        arm: SerialArm,
        limits: JointLimits,
        q_initial: np.ndarray,
        *,
        X_WB: np.ndarray | None = None,
        damping: Damping = Damping(),
        guard: CollisionGuard | None = None,
        stopping_time: float = np.inf,
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
        self._arm, self._damping, self._guard, self._period = arm, damping, guard, period
        self._limits = limits.stopping_within(stopping_time)
        self._R_BW = np.eye(3) if X_WB is None else np.asarray(X_WB)[:3, :3].T
        self._n = n = len(q_initial)
        self._require_clear(q_initial)
        unknown = np.full(0 if guard is None else len(guard.names), -np.inf)  # gaps of the watched pairs
        self._V = self.DeclareVectorInputPort("V_WE_W", 6)
        self._motor = self.DeclareVectorInputPort("motor_position", 4)
        state = self.DeclareDiscreteState(
            np.concatenate([q_initial, np.zeros(n), [0.0, -1.0], np.full(4, np.nan), unknown])
        )
        self.DeclarePeriodicDiscreteUpdateEvent(period, offset, self._update)
        ticket = {self.discrete_state_ticket(state)}
        self.DeclareVectorOutputPort("desired_state", BasicVector(2 * n), self._calc_desired_state, ticket)
        self.DeclareVectorOutputPort("limited_by", BasicVector(1), self._calc_limited_by, ticket)
        self.DeclareAbstractOutputPort("status", lambda: Value(Status()), self._calc_status, ticket)

    def _require_clear(self, q: np.ndarray) -> None:
        if self._guard is None:
            return
        gap, pair = self._guard.body.clearance(q, self._guard.obstacles)
        if gap < 0:
            raise InputError(f"arm: starts with {pair[0]} {-1e3 * gap:.0f} mm deep in {pair[1]}")

    def _parts(self, context) -> list[np.ndarray]:
        """Set-points, rates, (reason, pair) of the last step; the gaps known, after the motors that they are for (NaN: never told)."""
        n = self._n
        return np.split(context.get_discrete_state_vector().CopyToVector(), [n, 2 * n, 2 * n + 2, 2 * n + 6])

    def _update(self, context, discrete_state):
        with LEDGER.charge("control"):
            q, previous, _, motor, gaps = self._parts(context)
            if self._motor.HasValue(context):
                told = self._motor.Eval(context)
                if not np.abs(told - motor).max() <= HAND_MOVED:  # or told for the first time
                    motor, gaps = told, np.full_like(gaps, -np.inf)
            V_BE_B = (self._R_BW @ self._V.Eval(context).reshape(2, 3).T).T.ravel()
            rates, reason, pair, gaps = self._step(q, previous, gaps, motor, V_BE_B)
            why = [self.REASONS.index(reason), pair]
            discrete_state.set_value(np.concatenate([q + self._period * rates, rates, why, motor, gaps]))

    def _step(self, q: np.ndarray, previous: np.ndarray, gaps: np.ndarray, motor: np.ndarray, V_BE_B: np.ndarray):
        """Rates, what limited them, the pair of shapes that did, and the gaps that are certain after the step."""
        _, J = self._arm.tool_pose_and_jacobian(q)
        wanted, lost = damped_rates(J, V_BE_B, self._damping)
        rates, reason = limited_rates(wanted, q, previous, self._limits, self._period)
        if lost > LOST and reason != "position":
            reason = "singularity"
        if self._guard is None:
            return rates, reason, -1, gaps
        known = None if np.isnan(motor).any() else motor
        held = guarded_rates(self._guard, rates, q, previous, gaps, self._limits, self._period, known)
        return held.rates, reason if held.pair < 0 else "collision", held.pair, held.gaps

    def _calc_desired_state(self, context, output):
        output.set_value(np.concatenate(self._parts(context)[:2]))

    def _calc_limited_by(self, context, output):
        output.set_value(self._parts(context)[2][:1])

    def _calc_status(self, context, output):
        reason, pair = self._parts(context)[2].astype(int)
        reason = self.REASONS[reason]
        if reason == "collision":
            output.set_value(Status(f"held off: {' near '.join(self._guard.names[pair])}", "warning"))
        elif reason in ("position", "singularity"):
            output.set_value(Status(f"limited by {reason}", "warning"))
        else:
            output.set_value(Status())
