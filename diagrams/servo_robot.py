"""The workcell under visual servoing: a hand finds its place by sight, or brings what it holds to its place (paper III-D, III-F)."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from pydrake.systems.framework import Diagram, DiagramBuilder, LeafSystem

from vipr.diagrams.stages import Maker, Stages, connect
from vipr.diagrams.workcell import SET_POINTS, Workcell
from vipr.systems.arm.commander import ArmCommander
from vipr.systems.arm.limit_use import LimitUse
from vipr.systems.camera.lens import Lens
from vipr.systems.servo.controller import VisualServo, Workspace
from vipr.systems.servo.laws import ServoLaw
from vipr.systems.servo.pose_delay import PoseDelay
from vipr.systems.servo.position_based import PositionBased
from vipr.systems.servo.target_filter import TargetMotion
from vipr.systems.servo.tasks import Task
from vipr.systems.tracking.annotator import PoseAnnotator
from vipr.systems.tracking.cad_model import CadModel
from vipr.systems.tracking.known_view import KnownView
from vipr.systems.tracking.settings import TrackerSettings
from vipr.systems.tracking.tracker import ModelTracker
from vipr.systems.truth import TrackingError

STAGES: Mapping[str, Maker] = {"tracker": ModelTracker, "servo": VisualServo, "arm": ArmCommander}
# s, to bring the arm to rest in: its set-points stand within 80 ms of the first exposure that shows no target.
STOPPING_TIME = 0.05


@dataclass(frozen=True)
class Schedule:
    """Periods and offsets of the loop [s]; one camera tick every 40 ms."""

    camera: float = 0.04
    arm: float = SET_POINTS
    tracker_offset: float = 0.020
    delay_offset: float = 0.021
    delay_frames: int = 0  # by which poses come late, beyond the offsets
    servo_offset: float = 0.022
    arm_offset: float = 0.004
    witness_offset: float = 0.005
    judge_offset: float = 0.038

    def rows(self) -> dict[str, tuple[float, float]]:
        """(period, offset) [s] of each stage."""
        return {
            "workcell.camera": (self.camera, 0.0),
            "tracker": (self.camera, self.tracker_offset),
            "servo": (self.camera, self.servo_offset),
            "arm": (self.arm, self.arm_offset),
            "limit_use": (self.arm, self.witness_offset),
            "tracking_error": (self.camera, self.judge_offset),
        }

    @property
    def latency(self) -> float:
        """From the exposure to the servo's tick that answers it [s]."""
        return self.servo_offset + self.delay_frames * self.camera

    @property
    def exposure_to_command(self) -> float:
        """From the exposure to the first joint set-point that knows of it [s]."""
        ticks = np.ceil((self.servo_offset - self.arm_offset) / self.arm - 1e-9)
        return self.arm_offset + ticks * self.arm + self.delay_frames * self.camera


class ServoRobot(Diagram):
    """The workcell with a tracker, a visual servo and the arm's set-point generator closed around it.

    .. pydrake_system::

        name: ServoRobot
        input_ports:
        - stage_desired_state
        - motor_command
        output_ports:
        - picture
        - object_pose
        - V_WE_W
        - servo_error
        - servo_status
        - desired_state
        - limited_by
        - arm_status
        - limit_use
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
        tracker  |20  the frame of 0 is worked out (then held back by ``delay_frames`` frames, at 21, if the schedule says so)
        servo    |22  the pose is filtered, predicted to now, and the twist set
        arm      |4 14 24 34  set-points for the joint servo: the first that knows of the exposure is the one at 24
        truth    |0 keeps the truth of the exposure, 38 compares

    Frames: W world, C camera, O object, E hand (see ``Workcell``). ``task`` says what is to be done, with the camera where the robot
    believes it to be; ``lens`` is the lens it believes in (the real one if not given), ``views`` are pictures of the object whose poses it
    knows. The arm is never faster than it can stop in ``stopping_time`` [s]: when the target is lost, it begins to brake 2 ms after the
    servo's tick. ``judge`` compares with the truth: AlignmentError or PlacementError. ``tracking_error`` and ``alignment_error`` are
    against truth (see ``systems.truth``) and reach no controller. ``picture`` is the frame with the tracked edges drawn in. ``stages`` puts
    others in the place of some of ``STAGES``: makers called with the same arguments, whose systems have the same ports.
    """

    def __init__(
        self,
        workcell: Workcell,
        model: CadModel,
        X_CO_initial: np.ndarray,
        task: Task,
        judge: LeafSystem,
        *,
        lens: Lens | None = None,
        tracker: TrackerSettings = TrackerSettings(),
        views: tuple[KnownView, ...] = (),
        law: ServoLaw = PositionBased(),
        motion: TargetMotion = TargetMotion(),
        workspace: Workspace = Workspace(),
        stopping_time: float = STOPPING_TIME,
        schedule: Schedule = Schedule(),
        stages: Mapping[str, Maker] | None = None,
    ):
        super().__init__()
        config = workcell.config
        lens = config.lens if lens is None else lens
        self.schedule = schedule.rows()
        builder, made = DiagramBuilder(), Stages(STAGES, stages)
        add = builder.AddNamedSystem
        period = schedule.camera
        cell = add("workcell", workcell)
        tracker = made.add(
            builder,
            "tracker",
            model,
            lens,
            X_CO_initial=X_CO_initial,
            settings=tracker,
            **({"views": views} if views else {}),  # asked only of a tracker that has some to take
            period=period,
            offset=schedule.tracker_offset,
        )
        servo = made.add(
            builder,
            "servo",
            workcell.arm,
            task,
            law=law,
            motion=motion,
            workspace=workspace,
            patience=0.08 + schedule.delay_frames * period,
            period=period,
            offset=schedule.servo_offset,
        )
        limits = workcell.joint_limits
        arm = made.add(
            builder,
            "arm",
            workcell.arm,
            limits,
            config.q_initial,
            guard=workcell.guard,
            stopping_time=stopping_time,
            period=schedule.arm,
            offset=schedule.arm_offset,
        )
        witness = add("limit_use", LimitUse(limits, period=schedule.arm, offset=schedule.witness_offset))
        annotator = add("annotator", PoseAnnotator(model, lens))
        tracking_error = add("tracking_error", TrackingError(period=period, judge_offset=schedule.judge_offset))
        add("alignment_error", judge)
        wires = [
            (cell, "frame", tracker, "frame"),
            (cell, "joint_state", servo, "joint_state"),
            (cell, "frame", annotator, "frame"),
            (tracker, "object_pose", annotator, "object_pose"),
            (servo, "V_WE_W", arm, "V_WE_W"),
            (cell, "motor_position", arm, "motor_position"),
            (arm, "desired_state", cell, "arm_desired_state"),
            (arm, "desired_state", witness, "desired_state"),
            (cell, "X_CO_true", tracking_error, "X_CO_true"),
            (tracker, "object_pose", tracking_error, "object_pose"),
        ]
        if schedule.delay_frames:
            delay = add("delay", PoseDelay(schedule.delay_frames, period=period, offset=schedule.delay_offset))
            wires += [(tracker, "object_pose", delay, "object_pose"), (delay, "delayed_pose", servo, "object_pose")]
        else:
            wires += [(tracker, "object_pose", servo, "object_pose")]
        wires += [(cell, name, judge, name) for name in ("X_WO_true", "X_WE_true") if judge.HasInputPort(name)]
        connect(builder, wires)
        for name in ("stage_desired_state", "motor_command"):
            builder.ExportInput(cell.GetInputPort(name), name)
        for system, ports in (
            (annotator, {"picture": "picture"}),
            (tracker, {"object_pose": "object_pose"}),
            (servo, {"V_WE_W": "V_WE_W", "servo_error": "servo_error", "status": "servo_status"}),
            (arm, {"desired_state": "desired_state", "limited_by": "limited_by", "status": "arm_status"}),
            (witness, {"limit_use": "limit_use"}),
            (cell, {name: name for name in ("joint_state", "X_WO_true", "X_WE_true", "X_CO_true")}),
            (tracking_error, {"tracking_error": "tracking_error"}),
            (judge, {"alignment_error": "alignment_error"}),
        ):
            for port, name in ports.items():
                builder.ExportOutput(system.GetOutputPort(port), name)
        builder.BuildInto(self)
        self.set_name("servo_robot")
