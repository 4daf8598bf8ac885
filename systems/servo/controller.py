"""The servo as a stage: an object's pose in the camera in, a twist of the hand out."""

from dataclasses import dataclass, field

import numpy as np
from pydrake.common.value import Value
from pydrake.systems.framework import BasicVector, LeafSystem

from vipr.systems import se3
from vipr.systems.arm.kinematics import SerialArm
from vipr.systems.errors import InputError
from vipr.systems.servo.position_based import PositionBased, carried_twist, servo_twist
from vipr.systems.servo.target_filter import TargetBelief, TargetMotion, predict_pose, update
from vipr.systems.signals import ObjectPose, Signal
from vipr.systems.timing import LEDGER


@dataclass(frozen=True, eq=False)
class ServoState(Signal):
    """What the servo holds between its ticks."""

    target: TargetBelief = TargetBelief()
    V_WE: np.ndarray = field(default_factory=lambda: np.zeros(6))
    error: np.ndarray = field(default_factory=lambda: np.full(6, np.nan))


class PositionBasedServo(LeafSystem):
    """Drives the hand to a pose relative to the object that a tracker sees, and keeps it there while the object moves.

    .. pydrake_system::

        name: PositionBasedServo
        input_ports:
        - object_pose
        - joint_state
        output_ports:
        - V_WE_W
        - servo_error

    Frames: W world, C the fixed camera (calibrated pose X_WC), O object, E hand, G its goal, X_OG the reference pose. ``object_pose``
    (ObjectPose) is the tracker's; ``joint_state`` (2n) the encoders' [q; qdot]. Every ``period``: a Kalman filter takes in the newest
    pose if it is *tracking*, predicts the object to the present, and the law gives ``V_WE_W`` (6), (w, v) [rad/s, m/s]. ``servo_error``
    (6) is (theta u, t) of E to G in W [rad, m], by the servo's own belief; NaN before the first pose. The hand holds still (zero twist)
    before the first pose and when the last good one is older than ``patience`` seconds.

    Source: paper III-D; endpoint open-loop, position-based (Hutchinson, Hager, Corke 1996).
    """

    def __init__(
        self,
        arm: SerialArm,
        X_WC: np.ndarray,
        X_OG: np.ndarray,
        *,
        law: PositionBased = PositionBased(),
        motion: TargetMotion = TargetMotion(),
        patience: float = 0.08,
        period: float = 0.04,
        offset: float = 0.0,
    ):
        super().__init__()
        for name, X in (("X_WC", X_WC), ("X_OG", X_OG)):
            if not se3.is_pose(X):
                raise InputError(
                    f"servo: {name} must be a rigid 4x4 pose, got {np.array2string(np.asarray(X), precision=3)}"
                )
        self._arm, self._X_WC, self._X_OG = arm, np.asarray(X_WC, float), np.asarray(X_OG, float)
        self._law, self._motion, self._patience = law, motion, patience
        self._n = len(arm.d)
        self._object_pose = self.DeclareAbstractInputPort("object_pose", Value(ObjectPose()))
        self._joint_state = self.DeclareVectorInputPort("joint_state", 2 * self._n)
        self._state = self.DeclareAbstractState(Value(ServoState()))
        self.DeclarePeriodicUnrestrictedUpdateEvent(period, offset, self._update)
        ticket = {self.abstract_state_ticket(self._state)}
        self.DeclareVectorOutputPort("V_WE_W", BasicVector(6), self._calc_V_WE_W, ticket)
        self.DeclareVectorOutputPort("servo_error", BasicVector(6), self._calc_servo_error, ticket)

    def _held(self, context) -> ServoState:
        return context.get_abstract_state(int(self._state)).get_value()

    def _update(self, context, state):
        with LEDGER.charge("control"):
            q = self._joint_state.Eval(context)[: self._n]
            new = self._next(self._held(context), self._object_pose.Eval(context), q, context.get_time())
            state.get_mutable_abstract_state(int(self._state)).set_value(new)

    def _next(self, held: ServoState, seen: ObjectPose, q: np.ndarray, now: float) -> ServoState:
        target = held.target
        if seen.state == "tracking" and not seen.time <= target.time:
            R_WC = np.kron(np.eye(2), self._X_WC[:3, :3])
            target = update(target, self._X_WC @ seen.X_CO, R_WC @ seen.covariance @ R_WC.T, seen.time, self._motion)
        if not target.known:
            return held
        X_WO = predict_pose(target, now)
        X_WG = X_WO @ self._X_OG
        error = se3.difference(self._arm.tool_pose(q), X_WG)
        V_WE = np.zeros(6)
        if now - target.time <= self._patience:
            V_WE = servo_twist(error, carried_twist(target.V_WO, X_WG[:3, 3] - X_WO[:3, 3]), self._law)
        return ServoState(target, V_WE, error)

    def _calc_V_WE_W(self, context, output):
        output.set_value(self._held(context).V_WE)

    def _calc_servo_error(self, context, output):
        output.set_value(self._held(context).error)
