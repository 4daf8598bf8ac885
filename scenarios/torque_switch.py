"""``torque_switch``: the hand alone wraps an object that its inner links meet first, and lifts it."""

from dataclasses import dataclass

import numpy as np
from pydrake.math import RigidTransform
from pydrake.systems.framework import Diagram, DiagramBuilder
from pydrake.systems.primitives import ConstantVectorSource, TrajectorySource
from pydrake.trajectories import PiecewisePolynomial

from vipr.diagrams.hand_bench import HandBench, HandBenchConfig
from vipr.models import model_path, object_names
from vipr.scenarios.scenario import Outcome, Scenario
from vipr.scenarios.settings import require_one_of, require_within
from vipr.systems import se3
from vipr.systems.camera.camera import Camera
from vipr.systems.camera.lens import Lens
from vipr.systems.camera.offscreen import add_renderer, colour_sensor, daylight
from vipr.systems.errors import InputError
from vipr.systems.grasping.candidates import Solid, candidates, resting_pose
from vipr.systems.hand import transmission
from vipr.systems.hand.torque_switch import Drives
from vipr.systems.hand.transmission import DISTAL, PROXIMAL
from vipr.systems.recording.channels import ImageChannel, JointChannel, PoseChannel, VectorChannel
from vipr.systems.recording.history import History
from vipr.systems.recording.plots import Line, Plot
from vipr.systems.tracking.cad_model import load_model

FINGERS = ("finger_1", "finger_2", "finger_3")
CLOSE_RATE = 0.8  # rad/s
BEGIN, CLOSED, LIFTED, END = 0.4, 2.0, 3.0, 4.0  # s: when the fingers begin, when the lift begins and ends, the end
LIFT = 0.10  # m
LENS = Lens(width=640, height=480, fx=1000.0, fy=1000.0, cx=319.5, cy=239.5)
EYE, TARGET = np.array([-0.35, -0.80, 0.42]), np.array([-0.03, 0.0, 0.16])  # m


@dataclass(frozen=True, kw_only=True)
class TorqueSwitchSettings:
    """What can be set with ``--set`` or in ``torque_switch.yaml``."""

    object: str = "milk_carton"
    break_away_nm: float = 1.0  # of the clutches; .inf: no TorqueSwitch
    torque_nm: float = 1.8  # at which the motors stop
    time_step_s: float = 0.002

    def __post_init__(self):
        require_one_of("object", self.object, object_names())
        require_within(self, time_step_s=(1e-4, 0.01))
        if not 0 < self.torque_nm <= 1.8:
            raise InputError(f"torque_switch: torque_nm must be above 0 and at most 1.8, got {self.torque_nm}")
        if not 0 < self.break_away_nm:
            raise InputError(f"torque_switch: break_away_nm must be positive, got {self.break_away_nm}")


class TorqueSwitch(Scenario):
    """The seed moves the hand by a few millimetres."""

    name = "torque_switch"
    summary = "the hand alone: clutches let go at the inner links, the outer links wrap around (paper III-C)"
    settings_type = TorqueSwitchSettings

    def __init__(self, settings: TorqueSwitchSettings, seed: int):
        super().__init__(settings, seed)
        solid, up = Solid.of(load_model(model_path(f"{settings.object}/model.yaml"))), np.array([0.0, 0.0, 1.0])
        wraps = [grasp for grasp in candidates(solid, up) if "wrap" in grasp.name]
        if not wraps:
            raise InputError(f"torque_switch: {settings.object} cannot be wrapped from the side")
        self._grasp, self._X_WO = wraps[0], resting_pose(solid, up)
        shift = np.random.default_rng(seed).uniform(-0.003, 0.003, 3)
        self._X_WE = self._X_WO @ self._grasp.X_OG
        self._X_WE = se3.pose(self._X_WE[:3, :3], self._X_WE[:3, 3] + shift * [1.0, 1.0, 0.0])

    @property
    def duration(self) -> float:
        return END

    def build(self) -> Diagram:
        s, grasp = self.settings, self._grasp
        builder = DiagramBuilder()
        config = HandBenchConfig(
            object=s.object,
            X_WO=self._X_WO,
            X_WE=self._X_WE,
            motors=np.append(grasp.preshape, grasp.spread),
            drives=Drives(break_away_torque=s.break_away_nm),
            time_step=s.time_step_s,
        )
        bench = builder.AddNamedSystem("bench", HandBench(config))
        fingers, lift = _motions(config.motors)
        command = builder.AddNamedSystem("fingers_close", TrajectorySource(fingers))
        carriage = builder.AddNamedSystem("lift", TrajectorySource(lift, output_derivative_order=1))
        limit = builder.AddNamedSystem("torque_limit", ConstantVectorSource([s.torque_nm] * 3 + [2.0]))
        add_renderer(bench.scene_graph, "vtk", daylight())
        sensor = builder.AddNamedSystem("sensor", colour_sensor(LENS, RigidTransform(_looking()), "vtk"))
        camera = builder.AddNamedSystem("camera", Camera(LENS.width, LENS.height, seed=self.seed))
        for writer, reader in (
            (command.get_output_port(), bench.GetInputPort("motor_command")),
            (limit.get_output_port(), bench.GetInputPort("torque_limit")),
            (carriage.get_output_port(), bench.GetInputPort("carriage_desired_state")),
            (bench.GetOutputPort("query_object"), sensor.query_object_input_port()),
            (sensor.color_image_output_port(), camera.GetInputPort("color_image")),
        ):
            builder.Connect(writer, reader)
        builder.ExportOutput(camera.GetOutputPort("frame"), "frame")
        for channel in self.channels()[1:]:
            builder.ExportOutput(bench.GetOutputPort(channel.name), channel.name)
        diagram = builder.Build()
        diagram.set_name(self.name)
        return diagram

    def channels(self):
        return [
            ImageChannel("frame", video=True),
            PoseChannel("X_WO_true", child="object_true"),
            PoseChannel("X_WE_true", child="hand_true"),
            JointChannel("joint_state", joints=transmission.JOINTS, velocities=True),
            VectorChannel("motor_position", names=transmission.MOTORS, units=("rad",) * 4),
            VectorChannel("motor_torque", names=transmission.MOTORS, units=("N m",) * 4),
            VectorChannel("finger_torque", names=FINGERS, units=("N m",) * 3),
            VectorChannel("clutch", names=FINGERS, units=("",) * 3),
        ]

    def plots(self):
        def lines(channel, names):
            return tuple(Line(f"{channel}.{name}", name) for name in names)

        inner, outer = (tuple(transmission.JOINTS[i] for i in places) for places in (PROXIMAL, DISTAL))
        return [
            Plot("Inner links", "angle", "deg", lines("joint_state", inner), scale=np.rad2deg(1.0)),
            Plot("Outer links", "angle", "deg", lines("joint_state", outer), scale=np.rad2deg(1.0)),
            Plot("Motor torques", "torque", "N m", lines("motor_torque", FINGERS)),
            Plot("Finger torques about the last joints", "torque", "N m", lines("finger_torque", FINGERS)),
            Plot("Clutches: 1 seated, 0 broken away", "clutch", "", lines("clutch", FINGERS)),
        ]

    def judge(self, history: History) -> Outcome:
        times, X_WO = history.times, history.poses("X_WO_true")
        X_EO = np.linalg.inv(history.poses("X_WE_true")) @ X_WO
        lifting = times > CLOSED
        q = np.array([history.numbers(f"joint_state.{name}")[-1] for name in transmission.JOINTS])
        seated = np.array([history.numbers(f"clutch.{name}")[-1] for name in FINGERS])
        raised = 1e3 * float(X_WO[-1, 2, 3] - X_WO[lifting][0, 2, 3])
        held = raised > 0.8e3 * LIFT
        slip = np.linalg.norm(X_EO[lifting][:, :3, 3] - X_EO[lifting][0, :3, 3], axis=1).max()
        tilt = max(se3.angle_between(X_EO[lifting][0], X) for X in X_EO[lifting])
        figures = {
            "clutches_open_count": float((seated < 0.5).sum()),
            "inner_links_deg": float(np.degrees(q[PROXIMAL].mean())),
            "outer_links_deg": float(np.degrees(q[DISTAL].mean())),
            "raised_mm": raised,
            "slip_mm": 1e3 * float(slip),
            "tilt_in_hand_deg": float(np.degrees(tilt)),
        }
        reason = f"{int(figures['clutches_open_count'])} of 3 clutches let go; the object is {'held' if held else 'not held'}"
        return Outcome(held, reason, figures)


def _motions(motors: np.ndarray) -> tuple[PiecewisePolynomial, PiecewisePolynomial]:
    """The fingers' command from their preshape towards their stops, and the carriage's shift."""
    last = np.append(np.minimum(motors[:3] + CLOSE_RATE * (END - BEGIN), transmission.MOTOR_UPPER[:3]), motors[3])
    fingers = PiecewisePolynomial.FirstOrderHold([0.0, BEGIN, END], np.column_stack([motors, motors, last]))
    low, high = np.zeros(3), np.array([0.0, 0.0, LIFT])
    rise = PiecewisePolynomial.CubicHermite(
        [0.0, CLOSED, LIFTED, END], np.column_stack([low, low, high, high]), np.zeros((3, 4))
    )
    return fingers, rise


def _looking() -> np.ndarray:
    """X_WC of a camera at EYE that looks at TARGET, level."""
    z = (TARGET - EYE) / np.linalg.norm(TARGET - EYE)
    x = np.cross(z, [0.0, 0.0, 1.0])
    x /= np.linalg.norm(x)
    return se3.pose(np.column_stack([x, np.cross(z, x), z]), EYE)
