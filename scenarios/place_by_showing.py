"""``place_by_showing``: a held object is brought to where it was shown, by its corners in the image (paper III-F, Fig. 11)."""

from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder
from pydrake.systems.primitives import TrajectorySource
from pydrake.trajectories import PiecewisePolynomial

from vipr.diagrams.workcell import Workcell, WorkcellConfig
from vipr.diagrams.workcell_layout import STAGE, fixed_camera
from vipr.scenarios.motions import out_and_back
from vipr.scenarios.replacements import load_stages
from vipr.scenarios.servoing import (
    ServoingSettings,
    ServoScenario,
    above,
    direction,
    disturbed,
    joints_for,
    stage_and_fingers,
)
from vipr.scenarios.settings import require_within
from vipr.scenarios.shown_place import ShownPlace, load_shown_place
from vipr.systems import se3
from vipr.systems.arm import puma560
from vipr.systems.camera.lens import Lens
from vipr.systems.errors import InputError
from vipr.systems.tracking.tracker import ModelTracker
from vipr.systems.truth import PlacementError

BRINGING, SHOWING = 1.6, 0.8  # s in which the object is brought to the shown place, and that it is held still there
BROUGHT_M, BROUGHT_DEG = 0.04, 25.0  # from where: the tracker sees it from several sides, as it does when it is placed
LOOKS = 10  # frames at its end that are averaged, corners and picture
BORDER = 20  # px that the corners keep from the image's border


def in_view(points_C: np.ndarray, lens: Lens) -> bool:
    """Whether points (n, 3) [m] before the camera are in its image, ``BORDER`` away from the rim."""
    pixels = lens.project(points_C)
    return bool((pixels >= BORDER).all() and (pixels <= [lens.width - BORDER, lens.height - BORDER]).all())


@dataclass(frozen=True, kw_only=True)
class PlaceSettings(ServoingSettings):
    """What can be set with ``--set`` or in ``place_by_showing.yaml``."""

    duration_s: float = 8.0
    place: int = 1  # number of the shown place
    shown: str = ""  # file of ``vipr teach``; empty: the place is shown before the run
    by_picture: bool = True  # the tracker knows the picture of the shown place
    grip_m: float = 0.03  # the hand's grasp centre is so far below the object's top; more, and the palm hides its edges
    start_offset_m: float = 0.10
    start_turn_deg: float = 45.0  # turn about the camera's y axis at the start

    def __post_init__(self):
        super().__post_init__()
        require_within(self, duration_s=(1, 600), place=(0, 10**6), grip_m=(0, 0.1), start_turn_deg=(0, 120))


class PlaceByShowing(ServoScenario):
    """The number of the place chooses where the object was shown, the seed from where it is brought there.

    The object is fixed to the hand by a mount, as a tool would be. It starts turned about the camera's y axis and shifted; the fixed
    camera sees it all the way. The robot knows the shown place by the image positions of the object's corners alone.
    """

    name = "place_by_showing"
    summary = "bring a held object to where it was shown, by its corners in the image (paper III-F)"
    settings_type = PlaceSettings
    done = "the object is where it was shown"

    _fingers = (1.3, 1.3, 1.3, 0.0)  # closed until they touch

    def _plan(self, rng):
        s = self.settings
        X_WC = fixed_camera()
        taught = load_shown_place(Path(s.shown)) if s.shown else None
        if taught is not None and taught.object != s.object:
            raise InputError(
                f"{self.name}: {s.shown} shows the object {taught.object!r}, the setting object is {s.object!r}"
            )
        self.taught = taught
        self._X_EO = se3.inverse(above(self.cad.corners, -s.grip_m))
        self.X_WO_shown, self._q_shown = self._shown(taught.place if taught else s.place, X_WC)
        self.motion = out_and_back(np.zeros(3), np.zeros(3), begin=1.0, cruise=0.0)
        self.config = WorkcellConfig(
            object=s.object,
            X_EO_held=self._X_EO,
            q_initial=self._q_shown,
            X_WC=X_WC,
            imperfection=s.camera,
            supersampling=s.supersampling,
            seed=self.seed,
        )
        X_WO, q = self._start(rng)
        self.config = replace(self.config, q_initial=q)
        self.X_CO_start = se3.inverse(X_WC) @ X_WO

    def _shown(self, place: int, X_WC: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """X_WO and joint angles (6,) of the shown place: above the stage, upright."""
        rng = np.random.default_rng([place, 1])
        for _ in range(100):
            aside = np.array([*rng.uniform(-0.06, 0.06, 2), rng.uniform(0.06, 0.14)])
            X_WO = se3.pose(se3.exp_so3(np.array([0, 0, rng.uniform(-0.5, 0.5)])), STAGE + aside)
            try:
                return X_WO, joints_for(X_WO @ se3.inverse(self._X_EO), puma560.NAMED["nominal"])
            except InputError:
                continue
        raise InputError(f"{self.name}: no place within reach of the arm for the object {self.settings.object!r}")

    def _start(self, rng: np.random.Generator) -> tuple[np.ndarray, np.ndarray]:
        """X_WO and joint angles (6,) at the start, within the arm's reach and the camera's view."""
        s, X_WC, lens = self.settings, self.config.X_WC, self.config.lens
        for _ in range(200):
            x, y, z = s.start_offset_m * rng.uniform(-1.0, 1.0, 3)
            aside = np.array([x, y, 0.5 * z + 0.25 * s.start_offset_m])
            turn = np.deg2rad(s.start_turn_deg) * rng.choice([-1.0, 1.0]) * rng.uniform(0.5, 1.0)
            R = se3.exp_so3(turn * X_WC[:3, 1]) @ self.X_WO_shown[:3, :3]
            X_WO = se3.pose(R, self.X_WO_shown[:3, 3] + aside)
            X_CO = se3.inverse(X_WC) @ X_WO
            if not in_view(self.cad.corners @ X_CO[:3, :3].T + X_CO[:3, 3], lens):
                continue
            try:
                return X_WO, joints_for(X_WO @ se3.inverse(self._X_EO), self._q_shown)
            except InputError:
                continue
        raise InputError(
            f"{self.name}: no start within reach of the arm and view of the camera for start_offset_m {s.start_offset_m}, "
            f"start_turn_deg {s.start_turn_deg}; take smaller ones"
        )

    def _near(self, rng: np.random.Generator) -> tuple[np.ndarray, np.ndarray]:
        """X_WO and joint angles (6,) from where the object is brought to the shown place."""
        for _ in range(100):
            turn = np.deg2rad(BROUGHT_DEG) * rng.choice([-1.0, 1.0])
            R = se3.exp_so3(turn * self.config.X_WC[:3, 1]) @ self.X_WO_shown[:3, :3]
            X_WO = se3.pose(R, self.X_WO_shown[:3, 3] + BROUGHT_M * direction(rng))
            try:
                return X_WO, joints_for(X_WO @ se3.inverse(self._X_EO), self._q_shown)
            except InputError:
                continue
        raise InputError(f"{self.name}: the arm cannot bring the object to the shown place")

    def show(self) -> ShownPlace:
        """Bring the object to the place, hold it there for a moment, and keep the image positions of its corners and the picture."""
        s, rng = self.settings, np.random.default_rng([self.settings.place, 2])
        X_WO, q = self._near(rng)
        config = replace(self.config, q_initial=q)
        X_CO = se3.inverse(config.X_WC) @ X_WO
        builder = DiagramBuilder()
        cell = builder.AddSystem(Workcell(config))
        start = disturbed(X_CO, s.initial_error_mm, s.initial_error_deg, rng)
        make = load_stages(s.stages).get("tracker", ModelTracker)
        tracker = builder.AddSystem(
            make(self.cad, self.lens, X_CO_initial=start, settings=s.tracker, offset=self.schedule.tracker_offset)
        )
        builder.Connect(cell.GetOutputPort("frame"), tracker.GetInputPort("frame"))
        way = PiecewisePolynomial.CubicHermite([0.0, BRINGING], np.column_stack([q, self._q_shown]), np.zeros((6, 2)))
        arm = TrajectorySource(way, output_derivative_order=1, zero_derivatives_beyond_limits=True)
        for name, source in {**stage_and_fingers(self.motion, self._fingers), "arm_desired_state": arm}.items():
            builder.Connect(builder.AddSystem(source).get_output_port(), cell.GetInputPort(name))
        simulator = Simulator(builder.Build())
        pose, frame = tracker.GetOutputPort("object_pose"), cell.GetOutputPort("frame")
        pixels, pictures = [], []
        for k in range(LOOKS):
            simulator.AdvanceTo(BRINGING + SHOWING - (LOOKS - 1 - k) * self.schedule.camera)
            seen = pose.Eval(tracker.GetMyContextFromRoot(simulator.get_context()))
            if seen.state != "tracking":
                raise InputError(
                    f"{self.name}: the object is not seen at the shown place (the tracker says {seen.state})"
                )
            pixels.append(self.lens.project(self.cad.corners @ seen.X_CO[:3, :3].T + seen.X_CO[:3, 3]))
            taken = frame.Eval(cell.GetMyContextFromRoot(simulator.get_context()))
            pictures += [taken.image] if taken.arrived else []
        size = (config.lens.width, config.lens.height)
        X_WO = cell.GetOutputPort("X_WO_true").Eval(cell.GetMyContextFromRoot(simulator.get_context())).GetAsMatrix4()
        shown = ShownPlace(s.object, s.place, size, self.cad.corners, np.mean(pixels, axis=0), X_WO)
        return replace(shown, picture=np.round(np.mean(pictures, axis=0)).astype(np.uint8)) if pictures else shown

    def views(self):
        if not self.settings.by_picture:
            return ()
        self.taught = self.taught or self.show()
        return self.taught.views(self.lens)

    def task(self):
        self.taught = self.taught or self.show()
        if self.taught.X_WO_true is not None:
            # The arm gives way a little under the object: it stood there, not where the arm was sent.
            self.X_WO_shown = self.taught.X_WO_true
        return self.taught.task(self.lens, self.X_WC)

    def referee(self):
        return PlacementError(self.X_WO_shown)

    def body_and_goal(self, X_WO, X_WE):
        return X_WO, self.X_WO_shown

    @property
    def duration(self) -> float:
        return self.settings.duration_s

    def windows(self, t):
        return {"final": t > self.duration - 0.5}
