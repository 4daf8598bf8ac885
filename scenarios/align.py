"""``align``: the hand finds its reference pose above an object by sight, then keeps it while the object moves (paper III-D, Fig. 9)."""

from dataclasses import dataclass
from typing import Annotated

import numpy as np
from pydrake.systems.framework import Diagram, DiagramBuilder
from pydrake.systems.primitives import ConstantVectorSource, TrajectorySource

from vipr.diagrams.align import AlignRobot, Schedule
from vipr.diagrams.workcell import Workcell, WorkcellConfig, fixed_camera, puma_with_hand, standing
from vipr.models import model_path, object_names
from vipr.scenarios.motions import out_and_back
from vipr.scenarios.scenario import Outcome, Scenario
from vipr.scenarios.settings import ONE_OF
from vipr.systems import se3
from vipr.systems.arm import puma560
from vipr.systems.camera.imperfections import Imperfection
from vipr.systems.errors import InputError
from vipr.systems.recording.channels import ImageChannel, JointChannel, PoseChannel, VectorChannel
from vipr.systems.recording.history import History
from vipr.systems.recording.plots import Line, Plot, PosePlot
from vipr.systems.servo.laws import ServoLaw
from vipr.systems.servo.position_based import PositionBased
from vipr.systems.servo.target_filter import TargetMotion
from vipr.systems.tracking.cad_model import load_model
from vipr.systems.tracking.model_tracking import TrackerSettings

AXES = ("rx", "ry", "rz", "x", "y", "z")
ERROR_UNITS = ("rad",) * 3 + ("m",) * 3
JOINTS = tuple(f"joint_{i}" for i in range(1, 7))


@dataclass(frozen=True, kw_only=True)
class AlignSettings:
    """What can be set with ``--set`` or in ``align.yaml``."""

    object: str = "milk_carton"
    approach_s: float = 6.0  # time for the hand to come to its place while the object rests
    settle_s: float = 2.0  # time after the object has come to rest again
    clearance_m: float = 0.06  # reference pose: the grasp centre so far above the object's top, palm down
    object_speed_m_s: float = 0.05
    object_turn_deg_s: float = 5.0
    cruise_s: float = 1.5  # at that speed, out and back
    initial_error_mm: float = 20.0  # of the pose that the tracker starts from
    initial_error_deg: float = 5.0
    start_offset_m: float = 0.12  # how far to the side of its goal the hand starts at most
    start_turn_deg: float = 20.0
    camera: Imperfection = Imperfection()
    supersampling: int = 2  # of the rendering, 1 to 4
    tracker: TrackerSettings = TrackerSettings()
    servo: Annotated[ServoLaw, ONE_OF] = PositionBased()
    target: TargetMotion = TargetMotion()
    max_error_mm: float = 2.0  # allowed at the end
    max_error_deg: float = 0.5
    max_following_error_mm: float = 10.0  # allowed while the object moves
    max_following_error_deg: float = 3.0

    def __post_init__(self):
        if self.object not in object_names():
            raise InputError(f"align: unknown object {self.object!r}; there are: {', '.join(object_names())}")
        if not 1 <= self.supersampling <= 4:
            raise InputError(f"align: supersampling must be 1 to 4, got {self.supersampling}")
        for name in ("approach_s", "settle_s"):
            if not 0.5 <= getattr(self, name) <= 600:
                raise InputError(f"align: {name} must be 0.5 to 600 s, got {getattr(self, name)}")
        for name, most in (
            ("object_speed_m_s", 0.4),
            ("object_turn_deg_s", 180),
            ("cruise_s", 60),
            ("start_turn_deg", 60),
        ):
            if not 0 <= getattr(self, name) <= most:
                raise InputError(f"align: {name} must be 0 to {most}, got {getattr(self, name)}")
        for name, most in (
            ("clearance_m", 0.3),
            ("initial_error_mm", 500),
            ("initial_error_deg", 180),
            ("start_offset_m", 0.3),
        ):
            if not 0 <= getattr(self, name) <= most:
                raise InputError(f"align: {name} must be 0 to {most}, got {getattr(self, name)}")


class Align(Scenario):
    """The seed chooses where the object stands and moves, where the hand starts, and the error of the initial pose."""

    name = "align"
    summary = "find a pose relative to an object by sight and keep it while the object moves (paper III-D)"
    settings_type = AlignSettings

    def __init__(self, settings: AlignSettings, seed: int):
        super().__init__(settings, seed)
        s, rng = settings, np.random.default_rng(seed)
        self._cad = load_model(model_path(f"{s.object}/model.yaml"))
        self._X_OG = reference_pose(self._cad.corners, s.clearance_m)
        stage = np.array([*rng.uniform(-0.03, 0.03, 2), np.deg2rad(rng.uniform(-30, 30))])
        heading, turn = rng.uniform(-np.pi, np.pi), rng.choice([-1.0, 1.0])
        rate = np.array([np.cos(heading), np.sin(heading), 0.0]) * s.object_speed_m_s
        rate[2] = turn * np.deg2rad(s.object_turn_deg_s)
        self._motion = out_and_back(stage, rate, begin=s.approach_s, cruise=s.cruise_s)
        X_WO, X_WC = standing(stage), fixed_camera()
        self._config = WorkcellConfig(
            object=s.object,
            stage_initial=tuple(stage),
            q_initial=self._start(X_WO @ self._X_OG, rng),
            X_WC=X_WC,
            imperfection=s.camera,
            supersampling=s.supersampling,
            seed=seed,
        )
        X_CO = se3.inverse(X_WC) @ X_WO
        R_error = se3.exp_so3(_direction(rng) * np.deg2rad(s.initial_error_deg))
        self._X_CO_initial = se3.pose(R_error @ X_CO[:3, :3], X_CO[:3, 3] + _direction(rng) * 1e-3 * s.initial_error_mm)

    def _start(self, X_WG: np.ndarray, rng: np.random.Generator) -> np.ndarray:
        """Joint angles from which the hand starts: aside and above its goal and turned, within the arm's reach."""
        s, X_E6, margin = self.settings, se3.inverse(puma_with_hand().X_6E), np.deg2rad(5.0)
        q_goal = puma560.inverse_near(X_WG @ X_E6, puma560.NAMED["nominal"], margin)
        for _ in range(100):
            aside = np.array([*rng.uniform(-s.start_offset_m, s.start_offset_m, 2), rng.uniform(0.02, 0.08)])
            R_turn = se3.exp_so3(_direction(rng) * np.deg2rad(s.start_turn_deg) * rng.uniform())
            X_WE = se3.pose(R_turn @ X_WG[:3, :3], X_WG[:3, 3] + aside)
            try:
                return puma560.inverse_near(X_WE @ X_E6, q_goal, margin)
            except InputError:
                continue
        raise InputError(
            f"align: no start within reach of the arm for clearance_m {s.clearance_m}, start_offset_m {s.start_offset_m}, "
            f"start_turn_deg {s.start_turn_deg}; take smaller ones"
        )

    @property
    def duration(self) -> float:
        return self._motion.end_time() + self.settings.settle_s

    def build(self) -> Diagram:
        s = self.settings
        builder = DiagramBuilder()
        robot = builder.AddNamedSystem(
            "robot",
            AlignRobot(
                Workcell(self._config),
                self._cad,
                self._X_CO_initial,
                self._X_OG,
                X_WC=self._config.X_WC,
                tracker=s.tracker,
                law=s.servo,
                motion=s.target,
            ),
        )
        stage = builder.AddNamedSystem(
            "stage_motion",
            TrajectorySource(self._motion, output_derivative_order=1, zero_derivatives_beyond_limits=True),
        )
        fingers = builder.AddNamedSystem("fingers_open", ConstantVectorSource(np.zeros(4)))
        builder.Connect(stage.get_output_port(), robot.GetInputPort("stage_desired_state"))
        builder.Connect(fingers.get_output_port(), robot.GetInputPort("motor_command"))
        for i in range(robot.num_output_ports()):
            port = robot.get_output_port(i)
            builder.ExportOutput(port, port.get_name())
        diagram = builder.Build()
        diagram.set_name(self.name)
        return diagram

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
        ]

    def frames(self):
        return {("world", "camera"): self._config.X_WC}

    def plots(self):
        position = tuple(Line(f"alignment_error.{axis}", axis) for axis in AXES[3:])
        rotation = tuple(Line(f"alignment_error.{axis}", axis) for axis in AXES[:3])
        return [
            Plot("Hand from its reference pose, against truth: position", "error", "mm", position, scale=1e3),
            Plot(
                "Hand from its reference pose, against truth: rotation", "error", "deg", rotation, scale=np.rad2deg(1.0)
            ),
            PosePlot("Object in the camera", "object_pose", "X_CO_true", error="tracking_error"),
            Plot(
                "Hand's commanded velocity",
                "velocity",
                "mm/s",
                tuple(Line(f"V_WE_W.{a}", a) for a in AXES[3:]),
                scale=1e3,
            ),
            Plot(
                "Joint angles",
                "angle",
                "deg",
                tuple(Line(f"joint_state.{j}", j) for j in JOINTS),
                scale=np.rad2deg(1.0),
            ),
        ]

    def judge(self, history: History) -> Outcome:
        s, t = self.settings, history.times
        mm, deg = history.error_norms("alignment_error")
        windows = {
            "final": t > self.duration - 0.5,
            "following": (t >= s.approach_s) & (t <= self._motion.end_time()) & (s.cruise_s > 0),
            "aligned": (t > s.approach_s - 0.5) & (t < s.approach_s),
        }
        figures = {}
        for name, window in windows.items():
            if window.any():
                figures[f"{name}_translation_error_mm"] = mm[window].max()
                figures[f"{name}_rotation_error_deg"] = deg[window].max()
        seen_mm, seen_deg = history.error_norms("tracking_error")
        found = np.isfinite(seen_mm)
        if found.any():
            figures["tracking_translation_rms_mm"] = np.sqrt(np.mean(seen_mm[found] ** 2))
            figures["tracking_rotation_rms_deg"] = np.sqrt(np.mean(seen_deg[found] ** 2))
        figures["frames_without_pose_count"] = int(np.count_nonzero(~found))
        figures["exposure_to_command_ms"] = 1e3 * Schedule().exposure_to_command
        limits = {name: limit for name, limit in self.limits().items() if name in figures}
        over = [
            f"{name} {figures[name]:.2f}, allowed {limit:g}"
            for name, limit in limits.items()
            if not figures[name] <= limit
        ]
        return Outcome(not over, "; ".join(over) or "the hand found its place and kept it", figures)

    def limits(self) -> dict[str, float]:
        s = self.settings
        return {
            "final_translation_error_mm": s.max_error_mm,
            "final_rotation_error_deg": s.max_error_deg,
            "following_translation_error_mm": s.max_following_error_mm,
            "following_rotation_error_deg": s.max_following_error_deg,
        }


def reference_pose(corners_O: np.ndarray, clearance: float) -> np.ndarray:
    """X_OG: palm down, the hand's grasp centre ``clearance`` [m] above the middle of the object's top."""
    low, high = corners_O.min(axis=0), corners_O.max(axis=0)
    middle = 0.5 * (low + high)
    return se3.pose(np.diag([1.0, -1.0, -1.0]), [middle[0], middle[1], high[2] + clearance])


def _direction(rng: np.random.Generator) -> np.ndarray:
    v = rng.normal(size=3)
    return v / np.linalg.norm(v)
