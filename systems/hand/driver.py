"""The Barrett Hand's controller box: from motor commands to the set-points of eight joints."""

import numpy as np
from pydrake.systems.framework import BasicVector, LeafSystem

from vipr.systems.errors import InputError
from vipr.systems.hand import transmission
from vipr.systems.hand.torque_switch import Drives, Loads, Motors, advance
from vipr.systems.timing import LEDGER


class HandDriver(LeafSystem):
    """Drives the hand's four motors to commanded angles through worms, clutches and torque limits.

    .. pydrake_system::

        name: HandDriver
        input_ports:
        - motor_command
        - torque_limit
        - hand_state
        - joint_torque
        output_ports:
        - desired_state
        - motor_position
        - motor_count
        - motor_torque
        - clutch
        - finger_torque

    Joints are in the order of ``transmission.JOINTS``, motors in that of ``transmission.MOTORS``. ``motor_command`` (4): where the motors
    shall go: finger angles (the inner link's angle while its clutch is seated, 0 open to 140 degrees) and spread angle (0 to 180
    degrees) [rad]; beyond a stop the motor goes to the stop. ``torque_limit`` (4): the torques at which they stop [N m]; unconnected, that
    of ``drives``. ``hand_state`` (16): [q; v] of the joints by their encoders; ``joint_torque`` (8): what their servos spend, as from motor
    currents [N m].

    ``desired_state`` (16): [q; v] for the PD controllers of the plant's joints; between two ticks it goes on at the tick's rates.
    ``motor_position`` (4): where the motors are, in the units of the command; ``motor_count`` (4): the same in counts of their
    encoders; ``motor_torque`` (4): what they bear [N m]; ``clutch`` (3):
    1 seated, 0 broken away; ``finger_torque`` (3): torque about each finger's last joint, as by its strain gauge, positive when the tip
    is pushed open [N m]. These are of the last tick and held; before the first tick: the initial angles, no torque, clutches seated.

    A motor that has met its limit stays where it is and goes on if the resistance falls; command its ``motor_position`` to stop it
    for good, as one does after a grasp. Period 5 ms. Method: :mod:`vipr.systems.hand.torque_switch`.
    """

    def __init__(
        self, drives: Drives = Drives(), initial: np.ndarray = np.zeros(4), period: float = 0.005, offset: float = 0.0
    ):
        super().__init__()
        if not period > 0:
            raise InputError(f"hand driver: period must be positive, got {period} s")
        self._drives, self._period = drives, period
        start = _pack(Motors(angle=transmission.check_command(initial)), np.zeros(7), 0.0)
        self._state = self.DeclareDiscreteState(start)
        self._command = self.DeclareVectorInputPort("motor_command", 4)
        self._limit = self.DeclareVectorInputPort("torque_limit", 4)
        self._measured = self.DeclareVectorInputPort("hand_state", 16)
        self._torque = self.DeclareVectorInputPort("joint_torque", 8)
        held = {self.discrete_state_ticket(self._state)}
        self.DeclareVectorOutputPort(
            "desired_state", BasicVector(16), self._calc_desired_state, held | {self.time_ticket()}
        )
        self.DeclareVectorOutputPort("motor_position", BasicVector(4), self._calc_motor_position, held)
        self.DeclareVectorOutputPort("motor_count", BasicVector(4), self._calc_motor_count, held)
        self.DeclareVectorOutputPort("motor_torque", BasicVector(4), self._calc_motor_torque, held)
        self.DeclareVectorOutputPort("clutch", BasicVector(3), self._calc_clutch, held)
        self.DeclareVectorOutputPort("finger_torque", BasicVector(3), self._calc_finger_torque, held)
        self.DeclarePeriodicDiscreteUpdateEvent(period, offset, self._update)

    def _update(self, context, discrete_state):
        with LEDGER.charge("hand"):
            motors = _motors(context.get_discrete_state(self._state).get_value())
            rate, torque = self._measured.Eval(context)[8:], self._torque.Eval(context)
            limit = self._limit.Eval(context) if self._limit.HasValue(context) else np.array(self._drives.torque_limit)
            loads = Loads.measure(self._drives, motors, rate, torque)
            motors = advance(self._drives, motors, self._command.Eval(context), limit, rate, loads, self._period)
            packed = _pack(motors, np.concatenate([loads.motor, loads.strain]), context.get_time())
            discrete_state.set_value(self._state, packed)

    def _calc_desired_state(self, context, output):
        with LEDGER.charge("hand"):
            state = context.get_discrete_state(self._state).get_value()
            setpoints = np.array(state[_SETPOINTS])
            elapsed = min(max(context.get_time() - state[_TIME], 0.0), self._period)
            setpoints[:8] += elapsed * setpoints[8:]
            output.set_value(setpoints)

    def _calc_motor_position(self, context, output):
        output.set_value(context.get_discrete_state(self._state).get_value()[_ANGLE])

    def _calc_motor_count(self, context, output):
        angles = context.get_discrete_state(self._state).get_value()[_ANGLE]
        output.set_value(transmission.counts(angles).astype(float))

    def _calc_motor_torque(self, context, output):
        output.set_value(context.get_discrete_state(self._state).get_value()[_MOTOR_TORQUE])

    def _calc_clutch(self, context, output):
        output.set_value(np.isinf(context.get_discrete_state(self._state).get_value()[_BREAK_AWAY]).astype(float))

    def _calc_finger_torque(self, context, output):
        output.set_value(context.get_discrete_state(self._state).get_value()[_STRAIN])


# Places in the discrete state
_ANGLE, _RATE, _BREAK_AWAY = slice(0, 4), slice(4, 8), slice(8, 11)
_MOTOR_TORQUE, _STRAIN, _TIME, _SETPOINTS = slice(11, 15), slice(15, 18), 18, slice(19, 35)


def _pack(motors: Motors, torques: np.ndarray, time: float) -> np.ndarray:
    """Discrete state (35): motor angles, rates, break-away angles, motor and strain-gauge torques, time of the tick, set-points."""
    return np.concatenate([motors.angle, motors.rate, motors.break_away, torques, [time], motors.setpoints()])


def _motors(state: np.ndarray) -> Motors:
    state = np.array(state)
    return Motors(state[_ANGLE], state[_RATE], state[_BREAK_AWAY])
