"""The pick as a stage: what is seen and felt in, motions of arm and fingers out."""

import numpy as np
from pydrake.common.value import Value
from pydrake.systems.framework import BasicVector, LeafSystem

from vipr.systems.grasping.pick import Picker
from vipr.systems.grasping.pick_state import WATCHING, PickState, Senses
from vipr.systems.signals import ObjectPose, Status
from vipr.systems.timing import LEDGER


class PickTask(LeafSystem):
    """Finds an object by sight, grasps it as it was taught to, lifts, carries and holds it, and tries again if that fails.

    .. pydrake_system::

        name: PickTask
        input_ports:
        - object_pose
        - joint_state
        - motor_position
        - motor_torque
        output_ports:
        - V_WE_W
        - motor_command
        - torque_limit
        - initial_pose
        - watching
        - phase
        - slip_seen

    Frames: W world = the arm's base, C camera, O object, E hand. ``object_pose`` (ObjectPose) is the tracker's, ``joint_state`` (2n) the
    arm encoders' [q; qdot], ``motor_position`` and ``motor_torque`` (4) the hand's [rad, N m]. Every ``period``: one step of
    ``systems.grasping.pick``. ``V_WE_W`` (6) is the twist (w, v) that walks the arm along its joint path [rad/s, m/s]; ``motor_command``
    (4) and ``torque_limit`` (4) go to the hand's driver. ``initial_pose`` (ObjectPose) tells the tracker where to look, anew at each look;
    ``watching`` (1) is 1 while the camera is needed. ``phase`` (Status) names the phase, with the reason where something failed.
    ``slip_seen`` (1) is how far the object was seen to slip in the hand [m], NaN before that. All are held between ticks; before the
    first the arm stands, the hand is sent to 0 and the tracker is told X_CO_initial.

    Source: paper III-E.
    """

    def __init__(self, picker: Picker, X_CO_initial: np.ndarray, *, period: float = 0.02, offset: float = 0.0):
        super().__init__()
        self._picker = picker
        n = len(picker.around.arm.d)
        self._n = n
        self._object_pose = self.DeclareAbstractInputPort("object_pose", Value(ObjectPose()))
        self._joint_state = self.DeclareVectorInputPort("joint_state", 2 * n)
        self._motors = self.DeclareVectorInputPort("motor_position", 4)
        self._torque = self.DeclareVectorInputPort("motor_torque", 4)
        self._state = self.DeclareAbstractState(Value(picker.start(X_CO_initial)))
        self._twist = self.DeclareDiscreteState(6)
        self.DeclarePeriodicUnrestrictedUpdateEvent(period, offset, self._update)
        held = {self.abstract_state_ticket(self._state)}
        twist = {self.discrete_state_ticket(self._twist)}
        self.DeclareVectorOutputPort("V_WE_W", BasicVector(6), self._calc_V_WE_W, twist)
        self.DeclareVectorOutputPort("motor_command", BasicVector(4), self._calc_motor_command, held)
        self.DeclareVectorOutputPort("torque_limit", BasicVector(4), self._calc_torque_limit, held)
        self.DeclareAbstractOutputPort("initial_pose", lambda: Value(ObjectPose()), self._calc_initial_pose, held)
        self.DeclareVectorOutputPort("watching", BasicVector(1), self._calc_watching, held)
        self.DeclareAbstractOutputPort("phase", lambda: Value(Status()), self._calc_phase, held)
        self.DeclareVectorOutputPort("slip_seen", BasicVector(1), self._calc_slip_seen, held)

    def _held(self, context) -> PickState:
        return context.get_abstract_state(int(self._state)).get_value()

    def _update(self, context, state):
        with LEDGER.charge("control"):
            senses = Senses(
                time=context.get_time(),
                q=self._joint_state.Eval(context)[: self._n].copy(),
                motors=self._motors.Eval(context).copy(),
                torque=self._torque.Eval(context).copy(),
                seen=self._object_pose.Eval(context),
            )
            new = self._picker.step(self._held(context), senses)
            _, J = self._picker.around.arm.tool_pose_and_jacobian(senses.q)
            state.get_mutable_abstract_state(int(self._state)).set_value(new)
            state.get_mutable_discrete_state(self._twist).set_value(J @ self._picker.rates(new, senses))

    def _calc_V_WE_W(self, context, output):
        output.set_value(context.get_discrete_state(self._twist).get_value())

    def _calc_motor_command(self, context, output):
        output.set_value(self._held(context).command)

    def _calc_torque_limit(self, context, output):
        output.set_value(self._held(context).limit)

    def _calc_initial_pose(self, context, output):
        output.set_value(self._held(context).initial)

    def _calc_watching(self, context, output):
        output.set_value([float(self._held(context).phase in WATCHING)])

    def _calc_phase(self, context, output):
        held = self._held(context)
        output.set_value(Status(held.text, held.level))

    def _calc_slip_seen(self, context, output):
        output.set_value([self._held(context).slip])
