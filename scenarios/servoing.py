"""What ``align``, ``follow`` and ``place_by_showing`` share: settings, robot, channels, plots and judgement by the same figures."""

from abc import abstractmethod
from dataclasses import dataclass, field
from typing import Annotated, ClassVar

import numpy as np
from pydrake.systems.framework import Diagram, LeafSystem
from pydrake.systems.primitives import ConstantVectorSource, TrajectorySource
from pydrake.trajectories import Trajectory

from vipr.diagrams.servo_loop import workcell_loop
from vipr.diagrams.servo_robot import STOPPING_TIME, Schedule, ServoRobot
from vipr.diagrams.workcell import Workcell, WorkcellConfig
from vipr.diagrams.workcell_layout import puma_with_hand
from vipr.models import model_path, object_names
from vipr.scenarios.camera_knowledge import CameraKnowledge
from vipr.scenarios.replacements import load_stages
from vipr.scenarios.scenario import Outcome, Scenario
from vipr.scenarios.settings import ONE_OF, require_one_of, require_within
from vipr.systems import se3
from vipr.systems.arm import puma560
from vipr.systems.camera.imperfections import Imperfection
from vipr.systems.camera.lens import Lens
from vipr.systems.errors import InputError
from vipr.systems.recording.channels import ImageChannel, JointChannel, PoseChannel, StatusChannel, VectorChannel
from vipr.systems.recording.history import History
from vipr.systems.recording.plots import Line, Plot, PosePlot
from vipr.systems.servo.analysis import largest_stable_gain
from vipr.systems.servo.controller import Workspace
from vipr.systems.servo.gain import largest_gain
from vipr.systems.servo.laws import ServoLaw
from vipr.systems.servo.position_based import PositionBased
from vipr.systems.servo.target_filter import TargetMotion
from vipr.systems.servo.tasks import Task
from vipr.systems.tracking.cad_model import load_model
from vipr.systems.tracking.known_view import KnownView
from vipr.systems.tracking.settings import TrackerSettings

AXES = ("rx", "ry", "rz", "x", "y", "z")
ERROR_UNITS = ("rad",) * 3 + ("m",) * 3
JOINTS = tuple(f"joint_{i}" for i in range(1, 7))
LIMITS = ("joint_position", "joint_speed", "joint_acceleration")
# From the shoulder to the hand: upper arm 432, forearm 432, hand 191 mm, and the shoulder's offset.
WORKSPACE = Workspace(centre=(0.0, 0.0, float(puma560.D[0])), radius=1.10)  # m, W
MARGIN = np.deg2rad(5.0)  # from the joints' stops, of every pose that a scenario chooses


@dataclass(frozen=True, kw_only=True)
class ServoingSettings:
    """Settings that all of them have."""

    object: str = "milk_carton"
    start_offset_m: float = 0.12  # how far to the side of its goal the hand starts at most
    initial_error_mm: float = 20.0  # of the pose that the tracker starts from
    initial_error_deg: float = 5.0
    delay_frames: int = 0  # by which the tracker's poses come late, as from a slow computer
    camera: Imperfection = Imperfection()
    calibration: CameraKnowledge = CameraKnowledge()  # what the robot believes of its camera
    supersampling: int = 2  # of the rendering, 1 to 4
    tracker: TrackerSettings = TrackerSettings()
    servo: Annotated[ServoLaw, ONE_OF] = PositionBased()
    target: TargetMotion = TargetMotion()
    stopping_time_s: float = STOPPING_TIME  # the arm is never faster than it can be brought to rest in this time
    stages: dict[str, str] = field(default_factory=dict)  # others in the place of tracker, servo or arm: FILE.py:CLASS
    max_error_mm: float = 2.0  # allowed at the end
    max_error_deg: float = 0.5

    def __post_init__(self):
        require_one_of("object", self.object, object_names())
        require_within(
            self, supersampling=(1, 4), delay_frames=(0, 25), start_offset_m=(0, 0.3), initial_error_mm=(0, 500)
        )
        require_within(self, initial_error_deg=(0, 180), max_error_mm=(0, 1000), max_error_deg=(0, 180))
        require_within(self, stopping_time_s=(0.01, 2.0))


class ServoScenario(Scenario):
    """A robot under visual servoing; the seed chooses places, starts and errors."""

    done: ClassVar[str]  # what a success is called

    # What a subclass's ``_plan`` settles.
    config: WorkcellConfig
    motion: Trajectory  # of the stage: x, y [m], yaw [rad]
    _fingers: tuple[float, ...] = (0.0, 0.0, 0.0, 0.0)  # rad, commands of the hand's motors: open
    X_CO_start: np.ndarray  # (4, 4) where the object truly is at the start
    lens: Lens  # what the robot believes of its camera
    X_WC: np.ndarray

    def __init__(self, settings: ServoingSettings, seed: int):
        super().__init__(settings, seed)
        self.cad = load_model(model_path(f"{settings.object}/model.yaml"))
        self.schedule = Schedule(delay_frames=settings.delay_frames)
        rng = np.random.default_rng(seed)
        self._plan(rng)
        self.lens, self.X_WC = settings.calibration.believed(self.config.lens, self.config.X_WC, seed)
        self.X_CO_initial = disturbed(self.X_CO_start, settings.initial_error_mm, settings.initial_error_deg, rng)

    @abstractmethod
    def _plan(self, rng: np.random.Generator) -> None:
        """Choose what stands where and how it moves."""

    @abstractmethod
    def task(self) -> Task:
        """What the robot is to do, by what it believes."""

    def views(self) -> tuple[KnownView, ...]:
        """Pictures of the object whose poses the robot knows."""
        return ()

    @abstractmethod
    def referee(self) -> LeafSystem:
        """The system that compares it with the truth: its output is ``alignment_error``."""

    @abstractmethod
    def body_and_goal(self, X_WO: np.ndarray, X_WE: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """X_WB and X_WG (4, 4) by the true poses of object and hand: what the referee compares."""

    @abstractmethod
    def windows(self, t: np.ndarray) -> dict[str, np.ndarray]:
        """Ticks (n,) of each window of time, by the name that its figures begin with."""

    def require_stable(self) -> None:
        """InputError if the loop cannot be stable with this gain and latency."""
        gain = largest_gain(self.settings.servo.gain)
        limit = largest_stable_gain(workcell_loop(self.config.q_initial, schedule=self.schedule))
        if gain >= limit:
            raise InputError(
                f"{self.name}: servo.gain must be below {limit:.1f} 1/s, where the loop begins to oscillate at a latency of "
                f"{1e3 * self.schedule.latency:.0f} ms, got {gain:g} 1/s"
            )

    def build(self) -> Diagram:
        s = self.settings
        self.require_stable()
        robot = ServoRobot(
            Workcell(self.config),
            self.cad,
            self.X_CO_initial,
            self.task(),
            self.referee(),
            lens=self.lens,
            tracker=s.tracker,
            views=self.views(),
            law=s.servo,
            motion=s.target,
            workspace=WORKSPACE,
            stopping_time=s.stopping_time_s,
            schedule=self.schedule,
            stages=load_stages(s.stages),
        )
        return self.fed(robot, stage_and_fingers(self.motion, self._fingers))

    def channels(self):
        return [
            ImageChannel("picture", video=True),
            PoseChannel("object_pose", parent="camera", child="object", tracked=True),
            PoseChannel("X_CO_true", parent="camera", child="object_true"),
            PoseChannel("X_WO_true", child="object_world_true"),
            PoseChannel("X_WE_true", child="hand_true"),
            JointChannel("joint_state", joints=JOINTS, velocities=True),
            VectorChannel("alignment_error", names=AXES, units=ERROR_UNITS),
            VectorChannel("tracking_error", names=AXES, units=ERROR_UNITS),
            VectorChannel("servo_error", names=AXES, units=ERROR_UNITS),
            VectorChannel("V_WE_W", names=AXES, units=("rad/s",) * 3 + ("m/s",) * 3),
            VectorChannel("limited_by", names=("reason",), units=("",)),
            VectorChannel("limit_use", names=LIMITS, units=("",) * 3),
            StatusChannel("servo_status"),
            StatusChannel("arm_status"),
        ]

    def frames(self):
        return {("world", "camera"): self.config.X_WC}

    def plots(self):
        def axes(channel, some):
            return tuple(Line(f"{channel}.{axis}", axis) for axis in some)

        rad = np.rad2deg(1.0)
        joints = tuple(Line(f"joint_state.{j}", j) for j in JOINTS)
        return [
            Plot("From the goal, against truth: position", "error", "mm", axes("alignment_error", AXES[3:]), scale=1e3),
            Plot(
                "From the goal, against truth: rotation", "error", "deg", axes("alignment_error", AXES[:3]), scale=rad
            ),
            PosePlot("Object in the camera", "object_pose", "X_CO_true", error="tracking_error"),
            Plot("Hand's commanded velocity", "velocity", "mm/s", axes("V_WE_W", AXES[3:]), scale=1e3),
            Plot("Joint angles", "angle", "deg", joints, scale=rad),
        ]

    def judge(self, history: History) -> Outcome:
        mm, deg = history.error_norms("alignment_error")
        figures = {}
        for name, window in self.windows(history.times).items():
            if window.any():
                for kind, error in (("translation", mm[window]), ("rotation", deg[window])):
                    unit = "mm" if kind == "translation" else "deg"
                    figures[f"{name}_{kind}_error_{unit}"] = error.max()
                    figures[f"{name}_{kind}_rms_{unit}"] = np.sqrt(np.mean(error**2))
        seen_mm, seen_deg = history.error_norms("tracking_error")
        found = np.isfinite(seen_mm)
        if found.any():
            figures["tracking_translation_rms_mm"] = np.sqrt(np.mean(seen_mm[found] ** 2))
            figures["tracking_rotation_rms_deg"] = np.sqrt(np.mean(seen_deg[found] ** 2))
        figures["frames_without_pose_count"] = int(np.count_nonzero(~found))
        figures["exposure_to_command_ms"] = 1e3 * self.schedule.exposure_to_command
        for name in LIMITS:
            figures[f"{name}_used_percent"] = 100.0 * history.numbers(f"limit_use.{name}").max()
        over = [
            f"{name} {figures[name]:.2f}, allowed {limit:g}"
            for name, limit in self.limits().items()
            if name in figures and not figures[name] <= limit
        ]
        over += [f"at the end: {event.text}" for event in history.events[-1:] if event.level == "error"]
        return Outcome(not over, "; ".join(over) or self.done, figures)

    def limits(self) -> dict[str, float]:
        s = self.settings
        return {
            "final_translation_error_mm": s.max_error_mm,
            "final_rotation_error_deg": s.max_error_deg,
            **{f"{name}_used_percent": 100.01 for name in LIMITS},
        }


def stage_and_fingers(motion: Trajectory, fingers: tuple[float, ...] = (0.0, 0.0, 0.0, 0.0)) -> dict[str, LeafSystem]:
    """Sources of the workcell's other inputs: the stage that moves as given, the hand told to take the given angles [rad] (open)."""
    return {
        "stage_desired_state": TrajectorySource(motion, output_derivative_order=1, zero_derivatives_beyond_limits=True),
        "motor_command": ConstantVectorSource(fingers),
    }


def above(corners_O: np.ndarray, clearance: float) -> np.ndarray:
    """X_OE: palm down, the hand's grasp centre ``clearance`` [m] above the middle of the object's top (below it if negative)."""
    low, high = corners_O.min(axis=0), corners_O.max(axis=0)
    middle = 0.5 * (low + high)
    return se3.pose(np.diag([1.0, -1.0, -1.0]), [middle[0], middle[1], high[2] + clearance])


def joints_for(X_WE: np.ndarray, near: np.ndarray) -> np.ndarray:
    """Joint angles (6,) [rad] that bring the hand to X_WE, the solution closest to ``near``; InputError where out of reach."""
    return puma560.inverse_near(X_WE @ se3.inverse(puma_with_hand().X_6E), near, MARGIN)


def disturbed(X: np.ndarray, mm: float, deg: float, rng: np.random.Generator) -> np.ndarray:
    """The pose with an error of the given size in a random direction."""
    R = se3.exp_so3(direction(rng) * np.deg2rad(deg))
    return se3.pose(R @ X[:3, :3], X[:3, 3] + direction(rng) * 1e-3 * mm)


def direction(rng: np.random.Generator) -> np.ndarray:
    """A random unit vector (3,)."""
    v = rng.normal(size=3)
    return v / np.linalg.norm(v)
