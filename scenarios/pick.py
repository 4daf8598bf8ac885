"""``pick``: an object is found by sight, grasped as it was taught, lifted, carried and held (paper III-E, Fig. 10)."""

from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np
from pydrake.systems.framework import Context, Diagram
from pydrake.systems.primitives import ConstantVectorSource

from vipr.diagrams.pick import PickRobot
from vipr.diagrams.stages import Maker
from vipr.diagrams.workcell import Workcell, WorkcellConfig
from vipr.diagrams.workcell_layout import JOINT_LIMITS, fixed_camera
from vipr.models import model_path, object_names
from vipr.scenarios.camera_knowledge import CameraKnowledge
from vipr.scenarios.placements import LIES, LOOKING, Placement, around, check, random_placement, ways_to_lie
from vipr.scenarios.replacements import load_stages
from vipr.scenarios.scenario import Outcome, Scenario
from vipr.scenarios.settings import require_one_of, require_within
from vipr.systems import se3
from vipr.systems.camera.imperfections import Imperfection
from vipr.systems.errors import InputError
from vipr.systems.grasping.candidates import Solid, resting_pose
from vipr.systems.grasping.grasp import best_only, load_grasps
from vipr.systems.grasping.pick import Picker
from vipr.systems.grasping.pick_state import ENDS, PickSettings
from vipr.systems.hand.torque_switch import GRASPING, Drives
from vipr.systems.recording.channels import ImageChannel, JointChannel, PoseChannel, StatusChannel, VectorChannel
from vipr.systems.recording.history import History
from vipr.systems.recording.plots import Line, Plot, PosePlot
from vipr.systems.tracking.cad_model import load_model
from vipr.systems.tracking.settings import TrackerSettings

JOINTS = tuple(f"joint_{i}" for i in range(1, 7))
FINGERS = ("finger_1", "finger_2", "finger_3")
MOTORS = (*FINGERS, "spread")
KNOCKED_OVER = np.radians(25.0)


POSE_ERRORS = ("seen", "believed")
CONTACT_MODELS = ("hydroelastic_with_fallback", "point")


@dataclass(frozen=True, kw_only=True)
class PickScenarioSettings:
    """What can be set with ``--set`` or in ``pick.yaml``."""

    object: str = "rice_box"
    lie: str = "any"  # standing, lying, any: the seed chooses
    place_m: tuple[float, float] | None = None  # x, y of the stage; None: the seed chooses
    yaw_deg: float | None = None  # of the stage; None: the seed chooses
    grasps: str = ""  # a file of grasps; empty: the object's own
    one_grasp: bool = False  # the robot knows the best grasp of each way to lie only
    ballast_kg: float = 0.0  # packed into the object
    initial_error_mm: float = 20.0  # of the pose that the tracker starts from
    initial_error_deg: float = 5.0
    pose_error_mm: float = 0.0  # added to what the tracker sees before the grasp is planned: for measuring
    pose_error_deg: float = 0.0
    pose_error_in: str = POSE_ERRORS[0]  # seen: the support corrects what it can; believed: added after that
    duration_s: float = 45.0  # at most
    film: bool = True  # the camera runs all the time; else only while the task looks
    camera: Imperfection = Imperfection()
    supersampling: int = 1  # of the rendering, 1 to 4
    tracker: TrackerSettings = TrackerSettings()
    calibration: CameraKnowledge = CameraKnowledge()  # what the robot believes of its camera
    pick: PickSettings = PickSettings()
    hand: Drives = GRASPING
    stages: dict[str, str] = field(default_factory=dict)  # others in the place of tracker, task or arm: FILE.py:CLASS
    contact_model: str = CONTACT_MODELS[0]
    time_step_s: float = 0.005

    def __post_init__(self):
        require_one_of("object", self.object, object_names())
        require_one_of("lie", self.lie, LIES)
        require_one_of("pose_error_in", self.pose_error_in, POSE_ERRORS)
        require_one_of("contact_model", self.contact_model, CONTACT_MODELS)
        require_within(self, supersampling=(1, 4), ballast_kg=(0, 100), duration_s=(1, 600), time_step_s=(1e-4, 0.01))
        require_within(self, initial_error_mm=(0, 500), initial_error_deg=(0, 180))
        require_within(self, pose_error_mm=(0, 100), pose_error_deg=(0, 90))


class Pick(Scenario):
    """The seed chooses where the object is put and how it lies, where the arm starts, and the error of the initial pose."""

    name = "pick"
    summary = "find an object by sight, grasp it as taught, lift, carry and hold it (paper III-E)"
    settings_type = PickScenarioSettings

    def __init__(self, settings: PickScenarioSettings, seed: int):
        super().__init__(settings, seed)
        s, rng = settings, np.random.default_rng(seed)
        self._cad = load_model(model_path(f"{s.object}/model.yaml"))
        path = Path(s.grasps) if s.grasps else model_path(f"{s.object}/model.yaml").with_name("grasps.yaml")
        self._table = load_grasps(path)
        mass = self._table.mass + s.ballast_kg
        self._table = replace(self._table.check(mass), mass=mass)
        self.placement = self._place(rng)
        X_WC = fixed_camera()
        self._config = WorkcellConfig(
            object=s.object,
            stage_initial=tuple(self.placement.stage),
            X_PO=self.placement.X_PO,
            ballast=s.ballast_kg,
            drives=s.hand,
            contact_model=s.contact_model,
            q_initial=self.placement.q,
            X_WC=X_WC,
            imperfection=s.camera,
            supersampling=s.supersampling,
            seed=seed,
            time_step=s.time_step_s,
        )
        self._lens, self._X_WC = s.calibration.believed(self._config.lens, X_WC, seed)
        X_CO = se3.inverse(X_WC) @ self.placement.X_WO
        R_error = se3.exp_so3(_direction(rng) * np.deg2rad(s.initial_error_deg))
        error = np.r_[np.deg2rad(s.pose_error_deg) * _direction(rng), 1e-3 * s.pose_error_mm * _direction(rng)]
        self._pose_error = error
        self._X_CO_initial = se3.pose(R_error @ X_CO[:3, :3], X_CO[:3, 3] + _direction(rng) * 1e-3 * s.initial_error_mm)

    @property
    def place_given(self) -> bool:
        """Whether the settings say where the object is put; else the seed chooses."""
        return self.settings.place_m is not None or self.settings.yaw_deg is not None

    def _place(self, rng: np.random.Generator) -> Placement:
        s, errand = self.settings, self.settings.pick.errand
        if not self.place_given:
            return random_placement(self._table, self._cad, JOINT_LIMITS, errand, s.lie, rng)
        up = ways_to_lie(self._table, self._cad, s.lie)[0]
        x, y = s.place_m or (0.0, 0.0)
        stage = np.array([x, y, np.deg2rad(s.yaw_deg or 0.0)])
        if not (abs(x) <= 0.20 and abs(y) <= 0.15):
            raise InputError(f"pick: place_m must be within 0.20 and 0.15 m of the stage's middle, got {x:g}, {y:g}")
        placement = Placement(stage, resting_pose(Solid.of(self._cad), up), LOOKING)
        check(placement, self._table, self._cad, JOINT_LIMITS, errand)
        return placement

    @property
    def duration(self) -> float:
        return self.settings.duration_s

    def over(self, robot: Diagram, context: Context) -> bool:
        return robot.GetOutputPort("phase").Eval(context).text.startswith(ENDS)

    def build(self) -> Diagram:
        s = self.settings
        surroundings = around(self.placement.stage, JOINT_LIMITS, self._cad)
        table = best_only(self._table) if s.one_grasp else self._table
        believed = s.pose_error_in == "believed"
        picker = Picker(table, surroundings, self._X_WC, s.pick, self._pose_error, error_believed=believed)
        robot = PickRobot(
            Workcell(self._config),
            self._cad,
            picker,
            self._X_CO_initial,
            lens=self._lens,
            film=s.film,
            tracker=s.tracker,
            stages=self.stages(),
        )
        rest = np.r_[self.placement.stage, np.zeros(3)]
        return self.fed(robot, {"stage_desired_state": ConstantVectorSource(rest)})

    def stages(self) -> dict[str, Maker]:
        """What takes the place of some of the robot's stages."""
        return load_stages(self.settings.stages)

    def channels(self):
        return [
            ImageChannel("picture", video=True),
            PoseChannel("object_pose", parent="camera", child="object", tracked=True),
            StatusChannel("phase"),
            PoseChannel("X_CO_true", parent="camera", child="object_true"),
            PoseChannel("X_WO_true", child="object_world_true"),
            PoseChannel("X_WE_true", child="hand_true"),
            JointChannel("joint_state", joints=JOINTS, velocities=True),
            VectorChannel("motor_position", names=MOTORS, units=("rad",) * 4),
            VectorChannel("motor_torque", names=MOTORS, units=("N m",) * 4),
            VectorChannel("finger_torque", names=FINGERS, units=("N m",) * 3),
            VectorChannel("clutch", names=FINGERS, units=("",) * 3),
            VectorChannel("slip_seen", names=("slip",), units=("m",)),
            VectorChannel("limited_by", names=("reason",), units=("",)),
        ]

    def frames(self):
        return {("world", "camera"): self._config.X_WC}

    def plots(self):
        def lines(channel, names):
            return tuple(Line(f"{channel}.{name}", name) for name in names)

        return [
            Plot("Hand: motor positions", "angle", "deg", lines("motor_position", MOTORS), scale=np.rad2deg(1.0)),
            Plot("Hand: motor torques", "torque", "N m", lines("motor_torque", FINGERS)),
            Plot("Hand: finger torques about the last joints", "torque", "N m", lines("finger_torque", FINGERS)),
            PosePlot("Object in the camera", "object_pose", "X_CO_true", limits=None),
            Plot("Joint angles", "angle", "deg", lines("joint_state", JOINTS), scale=np.rad2deg(1.0)),
        ]

    def judge(self, history: History) -> Outcome:
        phases = [(e.time, e.text) for e in history.events if e.source == "phase"]
        X_WO, X_WE = history.poses("X_WO_true"), history.poses("X_WE_true")
        return judge_pick(history.times, X_WO, X_WE, phases, self.settings.pick.errand.lift)


def judge_pick(
    times: np.ndarray, X_WO: np.ndarray, X_WE: np.ndarray, phases: list[tuple[float, str]], lift: float
) -> Outcome:
    """Whether the object was held, against truth, and whether the robot knew.

    X_WO, X_WE (n, 4, 4) true poses at ``times`` (n,) [s]; phases: (time, text) of the task's status as it changed.
    """
    names = [text for _, text in phases]
    said = names[-1] if names else ""
    claims = said.startswith("held")
    attempts = sum(text.startswith("reach") for text in names)
    lifts = [time for time, text in phases if text == "lift"]
    figures = {"attempts": attempts, "time_s": phases[-1][0] if phases else np.nan}
    up = X_WO[:, :3, :3].transpose(0, 2, 1) @ np.array([0.0, 0.0, 1.0])
    tilt = np.arccos(np.clip(up @ up[0], -1.0, 1.0))
    raised = float(X_WO[-1, 2, 3] - X_WO[0, 2, 3])
    X_EO = np.linalg.inv(X_WE) @ X_WO
    held = bool(lifts and raised > 0.8 * lift)
    slip, later_slip = farthest_in_hand(X_EO[times >= lifts[-1]]) if lifts else np.nan, np.nan
    lifted = [time for time, text in phases if text == "check"]
    if held and lifted:
        later_slip = farthest_in_hand(X_EO[times >= lifted[-1]])
        held = slip < 0.03
    figures |= {
        "held": float(held),
        "slip_mm": 1e3 * slip,
        "slip_after_lift_mm": 1e3 * later_slip,
        "object_tilt_deg": float(np.degrees(tilt[-1])),
        "most_tilt_deg": float(np.degrees(tilt.max())),
        "raised_mm": 1e3 * raised,
        "knocked_over": float(tilt.max() > KNOCKED_OVER),
        "unnoticed": float(claims != held),
    }
    reason = said or "nothing was done"
    if claims and not held:
        reason = f"the robot says {said!r}, but the object is not in its hand"
    return Outcome(held and claims, reason, figures)


def farthest_in_hand(X_EO: np.ndarray) -> float:
    """The farthest that the object came in the hand [m] from where it was at first."""
    return float(np.linalg.norm(X_EO[:, :3, 3] - X_EO[0, :3, 3], axis=1).max())


def _direction(rng: np.random.Generator) -> np.ndarray:
    v = rng.normal(size=3)
    return v / np.linalg.norm(v)
