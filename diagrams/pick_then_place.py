"""The task of a robot that picks an object up and brings it to its place by sight: the pick, the servo, and who moves the arm."""

import numpy as np
from pydrake.systems.framework import Diagram, DiagramBuilder

from vipr.diagrams.stages import connect
from vipr.systems.grasping.hand_over import Arrival, HandOver
from vipr.systems.grasping.pick import Picker
from vipr.systems.grasping.task import PickTask
from vipr.systems.servo.controller import VisualServo, Workspace
from vipr.systems.servo.laws import ServoLaw
from vipr.systems.servo.position_based import PositionBased
from vipr.systems.servo.target_filter import TargetMotion
from vipr.systems.servo.tasks import Place


class PickThenPlace(Diagram):
    """Takes the place of ``PickTask`` in a ``PickRobot``: the same ports, and what is held is brought to where it was shown.

    .. pydrake_system::

        name: PickThenPlace
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

    ::

        motor_position, motor_torque ─▶ ┌──────┐ V_WE_W, phase, watching
        object_pose, joint_state ──┬──▶ │ pick │─────────────────────────┬──▶ ┌───────────┐ V_WE_W, phase, watching
                                   │    └──────┘                         └──▶ │ hand_over │────────────────────────▶
                                   └──▶ ┌───────┐ V_WE_W, servo_error, status │           │
                                        │ servo │────────────────────────────▶└───────────┘
                                        └───────┘

    Schedule: pick and hand-over every ``period`` from ``offset``, the servo every ``servo_period`` from ``servo_offset`` [s], after the
    tracker. Frames: W world, C camera, O object, E hand. ``place`` is where the object shall go; the servo takes the object to be in the
    hand from the first, which is true once it may move the arm. The hand goes on holding as the pick left it.
    """

    def __init__(
        self,
        picker: Picker,
        X_CO_initial: np.ndarray,
        *,
        place: Place,
        law: ServoLaw = PositionBased(),
        motion: TargetMotion = TargetMotion(),
        workspace: Workspace = Workspace(),
        arrival: Arrival = Arrival(),
        period: float = 0.02,
        offset: float = 0.0,
        servo_period: float = 0.04,
        servo_offset: float = 0.022,
    ):
        super().__init__()
        builder = DiagramBuilder()
        pick = builder.AddNamedSystem("pick", PickTask(picker, X_CO_initial, period=period, offset=offset))
        servo = builder.AddNamedSystem(
            "servo",
            VisualServo(
                picker.around.arm,
                place,
                law=law,
                motion=motion,
                workspace=workspace,
                period=servo_period,
                offset=servo_offset,
            ),
        )
        over = builder.AddNamedSystem("hand_over", HandOver(arrival=arrival, period=period, offset=offset))
        connect(
            builder,
            [
                (pick, "V_WE_W", over, "V_pick"),
                (pick, "phase", over, "pick_phase"),
                (pick, "watching", over, "pick_watching"),
                (servo, "V_WE_W", over, "V_place"),
                (servo, "servo_error", over, "servo_error"),
                (servo, "status", over, "servo_status"),
            ],
        )
        for name in ("object_pose", "joint_state"):
            builder.ConnectInput(builder.ExportInput(pick.GetInputPort(name), name), servo.GetInputPort(name))
        for name in ("motor_position", "motor_torque"):
            builder.ExportInput(pick.GetInputPort(name), name)
        for system, names in (
            (over, ("V_WE_W",)),
            (pick, ("motor_command", "torque_limit", "initial_pose")),
            (over, ("watching", "phase")),
            (pick, ("slip_seen",)),
        ):
            for name in names:
                builder.ExportOutput(system.GetOutputPort(name), name)
        builder.BuildInto(self)
        self.set_name("pick_then_place")
