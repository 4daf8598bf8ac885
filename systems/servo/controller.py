"""The servo as a stage: an object's pose in the camera in, a twist of the hand out."""

from dataclasses import dataclass, field, replace

import numpy as np
from pydrake.common.value import Value
from pydrake.systems.framework import BasicVector, LeafSystem

from vipr.systems import se3
from vipr.systems.arm.kinematics import SerialArm
from vipr.systems.errors import InputError
from vipr.systems.servo.depth import DepthBelief
from vipr.systems.servo.law import limited_sum
from vipr.systems.servo.laws import ServoLaw, check_features, correction
from vipr.systems.servo.position_based import PositionBased
from vipr.systems.servo.target_filter import TargetBelief, TargetMotion, update
from vipr.systems.servo.tasks import Hand, Task
from vipr.systems.signals import ObjectPose, Signal, Status
from vipr.systems.timing import LEDGER

FORGET = 0.5  # s without a pose after which the target's motion is learnt anew


@dataclass(frozen=True)
class Workspace:
    """Where the hand may be sent: a ball around the arm's shoulder, above a plane."""

    centre: tuple[float, float, float] = (0.0, 0.0, 0.0)  # m, W
    radius: float = float("inf")  # m, from the centre to E
    lowest: float = -float("inf")  # m, least height of E

    def complaint(self, p_WE: np.ndarray) -> str:
        """Why a hand position (3,) [m] is out of reach; nothing if it is not."""
        away = float(np.linalg.norm(p_WE - self.centre))
        if away > self.radius:
            return f"goal out of reach: {away:.2f} m from the shoulder, at most {self.radius:.2f} m"
        if p_WE[2] < self.lowest:
            return f"goal out of reach: {p_WE[2]:.2f} m high, at least {self.lowest:.2f} m"
        return ""


@dataclass(frozen=True, eq=False)
class ServoState(Signal):
    """What the servo holds between its ticks."""

    target: TargetBelief = TargetBelief()
    hand: TargetBelief = TargetBelief()  # the hand as it is seen, in E as the encoders have it
    memory: DepthBelief = DepthBelief()
    V_WE: np.ndarray = field(default_factory=lambda: np.zeros(6))
    error: np.ndarray = field(default_factory=lambda: np.full(6, np.nan))
    status: Status = Status()


class VisualServo(LeafSystem):
    """Does a task of ``servo.tasks`` by a law of ``servo.laws``: brings a hand, or what it holds, or a camera in it, to its place by sight.

    .. pydrake_system::

        name: VisualServo
        input_ports:
        - object_pose
        - hand_pose
        - joint_state
        output_ports:
        - V_WE_W
        - servo_error
        - status

    Frames: W world, C camera, O object, E hand, B the body that is moved and G its goal (see ``tasks``). ``object_pose`` (ObjectPose)
    is the tracker's; ``hand_pose`` (ObjectPose of E in C, may be left unconnected) makes ``Reach`` endpoint closed-loop; ``joint_state``
    (2n) is the encoders' [q; qdot]. Every ``period``: a Kalman filter takes in the newest pose if it is *tracking*, predicts it to the
    present, and the law gives ``V_WE_W`` (6), (w, v) [rad/s, m/s]. ``servo_error`` (6) is (theta u, t) from B to G in W [rad, m], by the
    servo's own belief; NaN before the first pose.

    The hand holds still (zero twist) before the first pose; at once when the tracker says *lost*; when the last good pose is older than
    ``patience`` seconds; while the goal is outside the ``workspace``; and while the law has no answer. It goes on when the reason is gone.
    ``status`` says which, an error once it has lasted for ``report_after`` seconds.

    Source: paper III-D and III-F; Hutchinson, Hager, Corke 1996.
    """

    def __init__(
        self,
        arm: SerialArm,
        task: Task,
        *,
        law: ServoLaw = PositionBased(),
        motion: TargetMotion = TargetMotion(),
        workspace: Workspace = Workspace(),
        patience: float = 0.08,
        report_after: float = 1.0,
        period: float = 0.04,
        offset: float = 0.0,
    ):
        super().__init__()
        if not patience > 0:
            raise InputError(f"servo: patience must be positive, got {patience} s")
        check_features(law, task.points_B)
        self._arm, self._task, self._law, self._motion = arm, task, law, motion
        self._workspace, self._patience, self._report_after = workspace, patience, report_after
        self._n = len(arm.d)
        self._object_pose = self.DeclareAbstractInputPort("object_pose", Value(ObjectPose()))
        self._hand_pose = self.DeclareAbstractInputPort("hand_pose", Value(ObjectPose()))
        self._joint_state = self.DeclareVectorInputPort("joint_state", 2 * self._n)
        self._state = self.DeclareAbstractState(Value(ServoState()))
        self.DeclarePeriodicUnrestrictedUpdateEvent(period, offset, self._update)
        ticket = {self.abstract_state_ticket(self._state)}
        self.DeclareVectorOutputPort("V_WE_W", BasicVector(6), self._calc_V_WE_W, ticket)
        self.DeclareVectorOutputPort("servo_error", BasicVector(6), self._calc_servo_error, ticket)
        self.DeclareAbstractOutputPort("status", lambda: Value(Status()), self._calc_status, ticket)

    def _held(self, context) -> ServoState:
        return context.get_abstract_state(int(self._state)).get_value()

    def _update(self, context, state):
        with LEDGER.charge("control"):
            q, rates = np.split(self._joint_state.Eval(context), 2)
            X_WE, J = self._arm.tool_pose_and_jacobian(q)
            hand = Hand(X_WE, J @ rates, context.get_time())
            seen = self._object_pose.Eval(context)
            seen_hand = self._hand_pose.Eval(context) if self._hand_pose.HasValue(context) else ObjectPose()
            new = self._next(self._held(context), seen, seen_hand, hand)
            state.get_mutable_abstract_state(int(self._state)).set_value(new)

    def _next(self, held: ServoState, seen: ObjectPose, seen_hand: ObjectPose, hand: Hand) -> ServoState:
        task, now = self._task, hand.time
        target = _taken_in(held.target, seen, task.camera_in_still_frame(hand, seen.time), self._motion)
        X_EC = se3.inverse(hand.pose_at(seen_hand.time)) @ task.X_WC_at(hand.X_WE)
        hand_belief = _taken_in(held.hand, seen_hand, X_EC, self._motion)
        held = replace(held, target=target, hand=hand_belief, V_WE=np.zeros(6))
        if not target.known:
            return held
        try:
            situation = task.situation(target, hand_belief, hand)
            error = se3.rotate(task.X_WC_at(hand.X_WE)[:3, :3], situation.pose_error)
            held = replace(held, error=error)
            age = now - target.time
            if seen.state == "lost" or age > self._patience:
                return replace(held, status=self._lost(age))
            complaint = self._workspace.complaint(task.goal_of_hand(situation, hand)[:3, 3])
            if complaint:
                return replace(held, status=Status(f"holding still, {complaint}", "error"))
            V_B, memory = correction(situation, self._law, held.memory)
        except InputError as refused:
            return replace(held, status=Status(f"holding still, {refused}", "error"))
        V_WE = limited_sum(task.hand_twist(V_B, hand), task.hand_twist(situation.V_G, hand), self._law)
        return replace(held, memory=memory, V_WE=V_WE, status=Status("servoing"))

    def _lost(self, age: float) -> Status:
        if age > self._report_after:
            return Status(f"target lost for more than {self._report_after:g} s: holding still", "error")
        return Status("target lost: holding still", "warning")

    def _calc_V_WE_W(self, context, output):
        output.set_value(self._held(context).V_WE)

    def _calc_servo_error(self, context, output):
        output.set_value(self._held(context).error)

    def _calc_status(self, context, output):
        output.set_value(self._held(context).status)


def _taken_in(belief: TargetBelief, seen: ObjectPose, X_FC: np.ndarray, motion: TargetMotion) -> TargetBelief:
    """The belief of a body in F after a tracker's pose, taken from X_FC; as it was if the pose is old or not trusted."""
    if seen.state != "tracking" or seen.time <= belief.time:
        return belief
    if seen.time - belief.time > FORGET:
        belief = TargetBelief()
    R = np.kron(np.eye(2), X_FC[:3, :3])
    return update(belief, X_FC @ seen.X_CO, R @ seen.covariance @ R.T, seen.time, motion)
