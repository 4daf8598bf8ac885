"""A hand that finds its place relative to an object by sight, and keeps it (paper III-D, Fig. 9)."""

from dataclasses import dataclass

import numpy as np
from pydrake.systems.framework import Diagram, DiagramBuilder

from vipr.diagrams.workcell import Workcell
from vipr.systems.arm.commander import ArmCommander
from vipr.systems.servo.controller import VisualServo
from vipr.systems.servo.laws import ServoLaw
from vipr.systems.servo.position_based import PositionBased
from vipr.systems.servo.target_filter import TargetMotion
from vipr.systems.servo.tasks import Reach
from vipr.systems.tracking.annotator import PoseAnnotator
from vipr.systems.tracking.cad_model import CadModel
from vipr.systems.tracking.model_tracking import TrackerSettings
from vipr.systems.tracking.tracker import ModelTracker
from vipr.systems.truth import AlignmentError, TrackingError


@dataclass(frozen=True)
class Schedule:
    """Periods and offsets of the loop [s]; one camera tick every 40 ms."""

    camera: float = 0.04
    arm: float = 0.01
    tracker_offset: float = 0.020
    servo_offset: float = 0.022
    arm_offset: float = 0.004
    judge_offset: float = 0.038

    def rows(self) -> dict[str, tuple[float, float]]:
        """(period, offset) [s] of each stage."""
        return {
            "workcell.camera": (self.camera, 0.0),
            "tracker": (self.camera, self.tracker_offset),
            "servo": (self.camera, self.servo_offset),
            "arm": (self.arm, self.arm_offset),
            "tracking_error": (self.camera, self.judge_offset),
        }

    @property
    def exposure_to_command(self) -> float:
        """From the exposure to the first joint set-point that knows of it [s]."""
        ticks = np.ceil((self.servo_offset - self.arm_offset) / self.arm - 1e-9)
        return self.arm_offset + ticks * self.arm


class AlignRobot(Diagram):
    """The workcell with a tracker, a position-based servo law and the arm's set-point generator closed around it.

    .. pydrake_system::

        name: AlignRobot
        input_ports:
        - stage_desired_state
        - motor_command
        output_ports:
        - picture
        - object_pose
        - V_WE_W
        - servo_error
        - desired_state
        - limited_by
        - joint_state
        - X_WO_true
        - X_WE_true
        - X_CO_true
        - tracking_error
        - alignment_error

    ::

        stage ──▶ ┌──────────┐ frame ┌─────────┐ object_pose ┌───────┐ V_WE_W ┌─────┐ desired_state
        fingers ▶ │ workcell │──────▶│ tracker │────────────▶│ servo │───────▶│ arm │──┐
               ┌─▶└──────────┘       └─────────┘             └───────┘        └─────┘  │
               │        └───────────────── joint_state ──────────▲                     │
               └───────────────────────────────────────────────────────────────────────┘

    Schedule (ms; the camera's period is 40):

        camera   |0   exposure
        tracker  |20  the frame of 0 is worked out
        servo    |22  the pose is filtered, predicted to now, and the twist set
        arm      |4 14 24 34  set-points for the joint servo: the first that knows of the exposure is the one at 24
        truth    |0 keeps the truth of the exposure, 38 compares

    Frames: W world, C camera, O object, E hand (see ``Workcell``), G = its reference pose X_OG. ``tracking_error`` and ``alignment_error``
    are against truth (see ``systems.truth``) and reach no controller. ``picture`` is the frame with the tracked edges drawn in.
    """

    def __init__(
        self,
        workcell: Workcell,
        model: CadModel,
        X_CO_initial: np.ndarray,
        X_OG: np.ndarray,
        *,
        X_WC: np.ndarray,
        tracker: TrackerSettings = TrackerSettings(),
        law: ServoLaw = PositionBased(),
        motion: TargetMotion = TargetMotion(),
        schedule: Schedule = Schedule(),
    ):
        super().__init__()
        config = workcell.config
        self.schedule = schedule.rows()
        builder = DiagramBuilder()
        period = schedule.camera
        cell = builder.AddNamedSystem("workcell", workcell)
        tracker = builder.AddNamedSystem(
            "tracker",
            ModelTracker(
                model,
                config.lens,
                X_CO_initial=X_CO_initial,
                settings=tracker,
                period=period,
                offset=schedule.tracker_offset,
            ),
        )
        servo = builder.AddNamedSystem(
            "servo",
            VisualServo(
                workcell.arm,
                Reach(X_WC, X_OG, model.corners),
                law=law,
                motion=motion,
                period=period,
                offset=schedule.servo_offset,
            ),
        )
        arm = builder.AddNamedSystem(
            "arm",
            ArmCommander(
                workcell.arm,
                workcell.joint_limits,
                config.q_initial,
                guard=workcell.guard,
                period=schedule.arm,
                offset=schedule.arm_offset,
            ),
        )
        annotator = builder.AddNamedSystem("annotator", PoseAnnotator(model, config.lens))
        tracking_error = builder.AddNamedSystem(
            "tracking_error", TrackingError(period=period, judge_offset=schedule.judge_offset)
        )
        alignment_error = builder.AddNamedSystem("alignment_error", AlignmentError(X_OG))

        wires = [
            (cell, "frame", tracker, "frame"),
            (tracker, "object_pose", servo, "object_pose"),
            (cell, "joint_state", servo, "joint_state"),
            (cell, "frame", annotator, "frame"),
            (tracker, "object_pose", annotator, "object_pose"),
            (servo, "V_WE_W", arm, "V_WE_W"),
            (arm, "desired_state", cell, "arm_desired_state"),
            (cell, "X_CO_true", tracking_error, "X_CO_true"),
            (tracker, "object_pose", tracking_error, "object_pose"),
            (cell, "X_WO_true", alignment_error, "X_WO_true"),
            (cell, "X_WE_true", alignment_error, "X_WE_true"),
        ]
        for writer, output, reader, input_ in wires:
            builder.Connect(writer.GetOutputPort(output), reader.GetInputPort(input_))
        for name in ("stage_desired_state", "motor_command"):
            builder.ExportInput(cell.GetInputPort(name), name)
        for system, names in (
            (annotator, ("picture",)),
            (tracker, ("object_pose",)),
            (servo, ("V_WE_W", "servo_error")),
            (arm, ("desired_state", "limited_by")),
            (cell, ("joint_state", "X_WO_true", "X_WE_true", "X_CO_true")),
            (tracking_error, ("tracking_error",)),
            (alignment_error, ("alignment_error",)),
        ):
            for name in names:
                builder.ExportOutput(system.GetOutputPort(name), name)
        builder.BuildInto(self)
        self.set_name("align")
