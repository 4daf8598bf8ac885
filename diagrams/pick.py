"""A robot that finds an object by sight and picks it up as it was taught (paper III-E, Fig. 10)."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from pydrake.systems.framework import Diagram, DiagramBuilder

from vipr.diagrams.stages import Maker, Stages, connect
from vipr.diagrams.workcell import SET_POINTS, Workcell
from vipr.systems.arm.commander import ArmCommander
from vipr.systems.camera.lens import Lens
from vipr.systems.grasping.pick import Picker
from vipr.systems.grasping.task import PickTask
from vipr.systems.tracking.annotator import PoseAnnotator
from vipr.systems.tracking.cad_model import CadModel
from vipr.systems.tracking.settings import TrackerSettings
from vipr.systems.tracking.tracker import ModelTracker
from vipr.systems.truth import TrackingError

STAGES: Mapping[str, Maker] = {"tracker": ModelTracker, "task": PickTask, "arm": ArmCommander}


@dataclass(frozen=True)
class Schedule:
    """Periods and offsets [s]; one camera tick every 40 ms."""

    camera: float = 0.04
    arm: float = SET_POINTS
    task: float = 0.02
    tracker_offset: float = 0.020
    task_offset: float = 0.003
    arm_offset: float = 0.004
    judge_offset: float = 0.038

    def rows(self) -> dict[str, tuple[float, float]]:
        """(period, offset) [s] of each stage."""
        return {
            "workcell.camera": (self.camera, 0.0),
            "tracker": (self.camera, self.tracker_offset),
            "task": (self.task, self.task_offset),
            "arm": (self.arm, self.arm_offset),
            "tracking_error": (self.camera, self.judge_offset),
        }


class PickRobot(Diagram):
    """The workcell with a tracker and the pick's state machine, which moves arm and fingers.

    .. pydrake_system::

        name: PickRobot
        input_ports:
        - stage_desired_state
        output_ports:
        - picture
        - object_pose
        - phase
        - slip_seen
        - motor_command
        - motor_position
        - motor_torque
        - finger_torque
        - clutch
        - joint_state
        - limited_by
        - X_WO_true
        - X_WE_true
        - X_CO_true
        - tracking_error

    ::

                  ┌──────────┐ frame ┌─────────┐ object_pose ┌──────┐ V_WE_W ┌─────┐ desired_state
        stage ──▶ │ workcell │──────▶│ tracker │────────────▶│ task │───────▶│ arm │──┐
              ┌──▶└──────────┘       └─────────┘             └──────┘        └─────┘  │
              │     ▲  │                  ▲── initial_pose ────┘│ ▲                   │
              │     │  └── joint_state, motor_position, motor_torque                  │
              │     └────── motor_command, torque_limit, watching                     │
              └───────────────────────────────────────────────────────────────────────┘

    Schedule (ms; the camera's period is 40):

        camera   |0   exposure, while the task watches (always, with ``film``)
        tracker  |20  the frame of 0 is worked out
        task     |3 23        senses in, twist and motor commands out
        arm      |4 14 24 34  set-points for the joint servo
        truth    |0 keeps the truth of the exposure, 38 compares

    Frames: W world, C camera, O object, E hand (see ``Workcell``). The arm's way is checked against collisions when it is planned; the
    commander keeps the joint limits. ``lens`` is the lens that the robot believes in (the real one if not given). ``tracking_error`` is
    against truth and reaches no controller. ``stages`` puts others in the place of some of ``STAGES``: makers called with the same
    arguments, whose systems have the same ports.
    """

    def __init__(
        self,
        workcell: Workcell,
        model: CadModel,
        picker: Picker,
        X_CO_initial: np.ndarray,
        *,
        lens: Lens | None = None,
        film: bool = True,
        tracker: TrackerSettings = TrackerSettings(),
        schedule: Schedule = Schedule(),
        stages: Mapping[str, Maker] | None = None,
    ):
        super().__init__()
        config = workcell.config
        lens = config.lens if lens is None else lens
        self.schedule = schedule.rows()
        builder, made = DiagramBuilder(), Stages(STAGES, stages)
        cell = builder.AddNamedSystem("workcell", workcell)
        seeing = made.add(
            builder, "tracker", model, lens, settings=tracker, period=schedule.camera, offset=schedule.tracker_offset
        )
        task = made.add(builder, "task", picker, X_CO_initial, period=schedule.task, offset=schedule.task_offset)
        arm = made.add(
            builder,
            "arm",
            workcell.arm,
            workcell.joint_limits,
            config.q_initial,
            period=schedule.arm,
            offset=schedule.arm_offset,
        )
        annotator = builder.AddNamedSystem("annotator", PoseAnnotator(model, lens))
        error = builder.AddNamedSystem(
            "tracking_error", TrackingError(period=schedule.camera, judge_offset=schedule.judge_offset)
        )
        wires = [
            (cell, "frame", seeing, "frame"),
            (task, "initial_pose", seeing, "initial_pose"),
            (seeing, "object_pose", task, "object_pose"),
            (cell, "joint_state", task, "joint_state"),
            (cell, "motor_position", task, "motor_position"),
            (cell, "motor_torque", task, "motor_torque"),
            (task, "V_WE_W", arm, "V_WE_W"),
            (arm, "desired_state", cell, "arm_desired_state"),
            (task, "motor_command", cell, "motor_command"),
            (task, "torque_limit", cell, "torque_limit"),
            (cell, "frame", annotator, "frame"),
            (seeing, "object_pose", annotator, "object_pose"),
            (cell, "X_CO_true", error, "X_CO_true"),
            (seeing, "object_pose", error, "object_pose"),
        ]
        if not film:
            wires.append((task, "watching", cell, "watching"))
        connect(builder, wires)
        builder.ExportInput(cell.GetInputPort("stage_desired_state"), "stage_desired_state")
        for system, names in (
            (annotator, ("picture",)),
            (seeing, ("object_pose",)),
            (task, ("phase", "slip_seen", "motor_command")),
            (cell, ("motor_position", "motor_torque", "finger_torque", "clutch", "joint_state")),
            (arm, ("limited_by",)),
            (cell, ("X_WO_true", "X_WE_true", "X_CO_true")),
            (error, ("tracking_error",)),
        ):
            for name in names:
                builder.ExportOutput(system.GetOutputPort(name), name)
        builder.BuildInto(self)
        self.set_name("pick")
