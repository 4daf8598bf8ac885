"""Ground truth beside the estimates: for logs, errors and figures, never for a controller (``tests/laws.py`` proves it)."""

import numpy as np
from pydrake.common.value import Value
from pydrake.math import RigidTransform
from pydrake.systems.framework import BasicVector, LeafSystem

from vipr.systems import se3
from vipr.systems.arm.kinematics import SerialArm
from vipr.systems.errors import InputError
from vipr.systems.signals import ObjectPose


class PoseTruth(LeafSystem):
    """The true poses of object and hand.

    .. pydrake_system::

        name: PoseTruth
        input_ports:
        - body_poses
        output_ports:
        - X_WO_true
        - X_WE_true
        - X_CO_true

    Frames: W world, O object, E hand, C camera. ``body_poses`` is a MultibodyPlant's; the outputs are RigidTransform values.
    """

    def __init__(self, object_index: int, hand_index: int, X_HE: np.ndarray, X_WC: np.ndarray):
        super().__init__()
        self._object, self._hand = int(object_index), int(hand_index)
        self._X_HE, self._X_CW = RigidTransform(X_HE), RigidTransform(se3.inverse(X_WC))
        self._poses = self.DeclareAbstractInputPort("body_poses", Value[list[RigidTransform]]())
        ticket = {self._poses.ticket()}
        for name in ("X_WO_true", "X_WE_true", "X_CO_true"):
            calc = getattr(self, f"_calc_{name}")
            self.DeclareAbstractOutputPort(name, lambda: Value(RigidTransform()), calc, ticket)

    def _calc_X_WO_true(self, context, output):
        output.set_value(self._poses.Eval(context)[self._object])

    def _calc_X_WE_true(self, context, output):
        output.set_value(self._poses.Eval(context)[self._hand] @ self._X_HE)

    def _calc_X_CO_true(self, context, output):
        output.set_value(self._X_CW @ self._poses.Eval(context)[self._object])


class KinematicTruth(LeafSystem):
    """The true poses where the arm is wherever its joints are, and the object on its stage or in the hand: geometry, no dynamics.

    .. pydrake_system::

        name: KinematicTruth
        input_ports:
        - joint_state
        - stage_desired_state
        output_ports:
        - X_WO_true
        - X_WE_true
        - X_CO_true
        - X_CE_true

    ``joint_state`` (2n) is [q; qdot] of the arm, ``stage_desired_state`` (6) [x, y, yaw; rates] of the stage, whose plate is at ``X_WS``
    when they are zero. The object stands in the middle of the plate, or is held at ``X_EO_held``. The camera stands at ``X_WC``, or is
    on the hand at ``X_EC``. Feedthrough.
    """

    def __init__(
        self,
        arm: SerialArm,
        X_WS: np.ndarray,
        *,
        X_WC: np.ndarray | None = None,
        X_EC: np.ndarray | None = None,
        X_EO_held: np.ndarray | None = None,
    ):
        super().__init__()
        if (X_WC is None) == (X_EC is None):
            raise InputError("kinematic truth: give X_WC of a fixed camera or X_EC of one on the hand")
        self._arm, self._X_WS, self._X_WC, self._X_EC, self._X_EO = arm, X_WS, X_WC, X_EC, X_EO_held
        self._joints = self.DeclareVectorInputPort("joint_state", 2 * len(arm.d))
        self._stage = self.DeclareVectorInputPort("stage_desired_state", 6)
        ticket = {self._joints.ticket(), self._stage.ticket()}
        for name in ("X_WO_true", "X_WE_true", "X_CO_true", "X_CE_true"):
            calc = getattr(self, f"_calc_{name}")
            self.DeclareAbstractOutputPort(name, lambda: Value(RigidTransform()), calc, ticket)

    def _poses(self, context) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """X_WO, X_WE and X_CW (4, 4)."""
        X_WE = self._arm.tool_pose(self._joints.Eval(context)[: len(self._arm.d)])
        if self._X_EO is None:
            x, y, yaw = self._stage.Eval(context)[:3]
            X_WO = self._X_WS @ se3.pose(se3.exp_so3(np.array([0.0, 0.0, yaw])), [x, y, 0.0])
        else:
            X_WO = X_WE @ self._X_EO
        return X_WO, X_WE, se3.inverse(X_WE @ self._X_EC if self._X_WC is None else self._X_WC)

    def _calc_X_WO_true(self, context, output):
        output.set_value(RigidTransform(self._poses(context)[0]))

    def _calc_X_WE_true(self, context, output):
        output.set_value(RigidTransform(self._poses(context)[1]))

    def _calc_X_CO_true(self, context, output):
        X_WO, _, X_CW = self._poses(context)
        output.set_value(RigidTransform(X_CW @ X_WO))

    def _calc_X_CE_true(self, context, output):
        _, X_WE, X_CW = self._poses(context)
        output.set_value(RigidTransform(X_CW @ X_WE))


class TrackingError(LeafSystem):
    """How far a tracker's estimate is from the truth at the exposure it speaks of.

    .. pydrake_system::

        name: TrackingError
        input_ports:
        - X_CO_true
        - object_pose
        output_ports:
        - tracking_error

    The truth is kept at each camera tick (``period``, ``exposure_offset``); once the estimate of that tick is there (``judge_offset``),
    ``tracking_error`` (6) becomes (rotation vector [rad], translation [m]) from truth to estimate in C, and is held; a dropped frame
    leaves it. NaN before the first estimate and while the tracker is lost.
    """

    def __init__(self, *, period: float = 0.04, exposure_offset: float = 0.0, judge_offset: float = 0.039):
        super().__init__()
        self._X_CO = self.DeclareAbstractInputPort("X_CO_true", Value(RigidTransform()))
        self._estimate = self.DeclareAbstractInputPort("object_pose", Value(ObjectPose()))
        truth = self.DeclareDiscreteState(17)  # X_CO row by row, time of exposure
        error = self.DeclareDiscreteState(np.full(6, np.nan))
        self._truth, self._error = truth, error
        self.DeclarePeriodicDiscreteUpdateEvent(period, exposure_offset, self._expose)
        self.DeclarePeriodicDiscreteUpdateEvent(period, judge_offset, self._judge)
        self.DeclareVectorOutputPort(
            "tracking_error", BasicVector(6), self._calc_tracking_error, {self.discrete_state_ticket(error)}
        )

    def _expose(self, context, discrete_state):
        X_CO = self._X_CO.Eval(context).GetAsMatrix4()
        discrete_state.set_value(self._truth, np.append(X_CO.ravel(), context.get_time()))

    def _judge(self, context, discrete_state):
        estimate = self._estimate.Eval(context)
        *X_CO, time = context.get_discrete_state(self._truth).CopyToVector()
        if estimate.state == "lost":
            discrete_state.set_value(self._error, np.full(6, np.nan))
        elif abs(estimate.time - time) < 1e-9:
            discrete_state.set_value(self._error, se3.difference(np.reshape(X_CO, (4, 4)), estimate.X_CO))

    def _calc_tracking_error(self, context, output):
        output.set_value(context.get_discrete_state(self._error).CopyToVector())


class AlignmentError(LeafSystem):
    """How far the hand truly is from its reference pose relative to the object.

    .. pydrake_system::

        name: AlignmentError
        input_ports:
        - X_WO_true
        - X_WE_true
        output_ports:
        - alignment_error

    ``alignment_error`` (6) is (rotation vector [rad], translation [m]) from the hand E to its goal G, expressed in W; X_OG is the reference
    pose. Feedthrough.
    """

    def __init__(self, X_OG: np.ndarray):
        super().__init__()
        self._X_OG = RigidTransform(X_OG)
        self._X_WO = self.DeclareAbstractInputPort("X_WO_true", Value(RigidTransform()))
        self._X_WE = self.DeclareAbstractInputPort("X_WE_true", Value(RigidTransform()))
        ticket = {self._X_WO.ticket(), self._X_WE.ticket()}
        self.DeclareVectorOutputPort("alignment_error", BasicVector(6), self._calc_alignment_error, ticket)

    def _calc_alignment_error(self, context, output):
        X_WG = self._X_WO.Eval(context) @ self._X_OG
        output.set_value(se3.difference(self._X_WE.Eval(context).GetAsMatrix4(), X_WG.GetAsMatrix4()))


class PlacementError(LeafSystem):
    """How far an object truly is from where it is to be placed.

    .. pydrake_system::

        name: PlacementError
        input_ports:
        - X_WO_true
        output_ports:
        - alignment_error

    ``alignment_error`` (6) is (rotation vector [rad], translation [m]) from the object's pose X_WO to its place ``X_WO_goal``, in W.
    """

    def __init__(self, X_WO_goal: np.ndarray):
        super().__init__()
        self._X_WO_goal = np.asarray(X_WO_goal, float)
        self._X_WO = self.DeclareAbstractInputPort("X_WO_true", Value(RigidTransform()))
        self.DeclareVectorOutputPort(
            "alignment_error", BasicVector(6), self._calc_alignment_error, {self._X_WO.ticket()}
        )

    def _calc_alignment_error(self, context, output):
        output.set_value(se3.difference(self._X_WO.Eval(context).GetAsMatrix4(), self._X_WO_goal))
