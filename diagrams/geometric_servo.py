"""The servo loop without pictures and without dynamics: for measuring laws in thousands of runs."""

import numpy as np
from pydrake.systems.framework import Diagram, DiagramBuilder

from vipr.diagrams.servo_robot import STOPPING_TIME, Schedule
from vipr.diagrams.workcell import ARM_COUNT
from vipr.systems.arm.commander import ArmCommander
from vipr.systems.arm.encoders import JointEncoders
from vipr.systems.arm.guard import CollisionGuard
from vipr.systems.arm.kinematics import SerialArm
from vipr.systems.arm.limit_use import LimitUse
from vipr.systems.arm.resolved_rate import JointLimits
from vipr.systems.servo.controller import VisualServo, Workspace
from vipr.systems.servo.laws import ServoLaw
from vipr.systems.servo.target_filter import TargetMotion
from vipr.systems.servo.tasks import Task
from vipr.systems.tracking.geometric_sight import GeometricSight
from vipr.systems.truth import KinematicTruth


class GeometricServo(Diagram):
    """The visual servo and the arm's real set-point generator around an arm that is where it is told to be, seen by ``GeometricSight``.

    .. pydrake_system::

        name: GeometricServo
        input_ports:
        - stage_desired_state
        output_ports:
        - V_WE_W
        - servo_error
        - servo_status
        - desired_state
        - limited_by
        - limit_use
        - X_WO_true
        - X_WE_true
        - X_CO_true

    ::

                      X_CO_true              object_pose
        stage ─▶ ┌───────┐ X_CE_true ┌───────┐ hand_pose ┌───────┐ V_WE_W ┌─────┐ desired_state
                 │ truth │──────────▶│ sight │──────────▶│ servo │───────▶│ arm │──┬──▶ encoders ─▶ servo
              ┌─▶└───────┘           └───────┘           └───────┘        └─────┘  │
              └────────────────────────────────────────────────────────────────────┘

    Schedule as ``ServoRobot``: exposure at 0, pose at 20, servo at 22, set-points at 4, 14, 24, 34 ms. The joint servo is left out: the arm
    is at its set-points. ``see_hand`` connects ``hand_pose``, which makes ``Reach`` endpoint closed-loop.
    """

    def __init__(
        self,
        arm: SerialArm,
        limits: JointLimits,
        q_initial: np.ndarray,
        truth: KinematicTruth,
        sight: GeometricSight,
        task: Task,
        law: ServoLaw,
        *,
        see_hand: bool = False,
        guard: CollisionGuard | None = None,
        motion: TargetMotion = TargetMotion(),
        workspace: Workspace = Workspace(),
        stopping_time: float = STOPPING_TIME,
        schedule: Schedule = Schedule(),
    ):
        super().__init__()
        builder = DiagramBuilder()
        add = builder.AddNamedSystem
        truth, sight = add("truth", truth), add("sight", sight)
        encoders = add("encoders", JointEncoders(ARM_COUNT))
        servo = add(
            "servo",
            VisualServo(
                arm,
                task,
                law=law,
                motion=motion,
                workspace=workspace,
                period=schedule.camera,
                offset=schedule.servo_offset,
            ),
        )
        commander = add(
            "arm",
            ArmCommander(
                arm,
                limits,
                q_initial,
                guard=guard,
                stopping_time=stopping_time,
                period=schedule.arm,
                offset=schedule.arm_offset,
            ),
        )
        witness = add("limit_use", LimitUse(limits, period=schedule.arm, offset=schedule.witness_offset))
        wires = [
            (truth, "X_CO_true", sight, "X_CO_true"),
            (truth, "X_CE_true", sight, "X_CE_true"),
            (sight, "object_pose", servo, "object_pose"),
            (encoders, "joint_state", servo, "joint_state"),
            (servo, "V_WE_W", commander, "V_WE_W"),
            (commander, "desired_state", witness, "desired_state"),
            (commander, "desired_state", encoders, "state"),
            (commander, "desired_state", truth, "joint_state"),
        ]
        if see_hand:
            wires.append((sight, "hand_pose", servo, "hand_pose"))
        for writer, output, reader, input_ in wires:
            builder.Connect(writer.GetOutputPort(output), reader.GetInputPort(input_))
        builder.ExportInput(truth.GetInputPort("stage_desired_state"), "stage_desired_state")
        for system, ports in (
            (servo, {"V_WE_W": "V_WE_W", "servo_error": "servo_error", "status": "servo_status"}),
            (commander, {"desired_state": "desired_state", "limited_by": "limited_by"}),
            (witness, {"limit_use": "limit_use"}),
            (truth, {name: name for name in ("X_WO_true", "X_WE_true", "X_CO_true")}),
        ):
            for port, name in ports.items():
                builder.ExportOutput(system.GetOutputPort(port), name)
        builder.BuildInto(self)
        self.set_name("geometric_servo")
