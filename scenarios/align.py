"""``align`` and ``follow``: the hand finds its reference pose above an object by sight, then keeps it while the object moves.

Paper III-D, Fig. 9. ``follow`` is the same at higher speed, judged by how well the hand keeps up.
"""

from dataclasses import dataclass

import numpy as np

from vipr.diagrams.workcell import WorkcellConfig
from vipr.diagrams.workcell_layout import STAGE_TRAVEL, fixed_camera, standing
from vipr.scenarios.motions import out_and_back
from vipr.scenarios.servoing import ServoingSettings, ServoScenario, above, direction, joints_for
from vipr.scenarios.settings import require_within
from vipr.systems import se3
from vipr.systems.arm import puma560
from vipr.systems.errors import InputError
from vipr.systems.servo.tasks import Reach
from vipr.systems.truth import AlignmentError

RAMP = 0.5  # s in which the object reaches its speed


@dataclass(frozen=True, kw_only=True)
class AlignSettings(ServoingSettings):
    """What can be set with ``--set`` or in ``align.yaml``."""

    approach_s: float = 6.0  # time for the hand to come to its place while the object rests
    settle_s: float = 2.0  # time after the object has come to rest again
    clearance_m: float = 0.06  # reference pose: the grasp centre so far above the object's top, palm down
    object_speed_m_s: float = 0.05
    object_turn_deg_s: float = 5.0
    cruise_s: float = 1.5  # at that speed, out and back
    start_turn_deg: float = 20.0  # how far the hand is turned at the start at most
    max_following_error_mm: float = 10.0  # allowed while the object moves
    max_following_error_deg: float = 3.0

    def __post_init__(self):
        super().__post_init__()
        require_within(self, approach_s=(0.5, 600), settle_s=(0.5, 600), cruise_s=(0, 60), clearance_m=(0, 0.3))
        require_within(self, object_speed_m_s=(0, 0.4), object_turn_deg_s=(0, 180), start_turn_deg=(0, 60))


class Align(ServoScenario):
    """The seed chooses where the object stands and moves, where the hand starts, and the error of the initial pose."""

    name = "align"
    summary = "find a pose relative to an object by sight and keep it while the object moves (paper III-D)"
    settings_type = AlignSettings
    done = "the hand found its place and kept it"

    def _plan(self, rng):
        s = self.settings
        self.X_OG = above(self.cad.corners, s.clearance_m)
        stage = np.array([*rng.uniform(-0.03, 0.03, 2), np.deg2rad(rng.uniform(-30, 30))])
        heading, turn = rng.uniform(-np.pi, np.pi), rng.choice([-1.0, 1.0])
        rate = np.array([np.cos(heading), np.sin(heading), 0.0]) * s.object_speed_m_s
        rate[2] = turn * np.deg2rad(s.object_turn_deg_s)
        stage = self._begin(stage, rate)
        self.motion = out_and_back(stage, rate, begin=s.approach_s, cruise=s.cruise_s, ramp=RAMP)
        self._require_on_stage()
        X_WO, X_WC = standing(stage), fixed_camera()
        self.config = WorkcellConfig(
            object=s.object,
            stage_initial=tuple(stage),
            q_initial=self._start(X_WO @ self.X_OG, rng),
            X_WC=X_WC,
            imperfection=s.camera,
            supersampling=s.supersampling,
            seed=self.seed,
        )
        self.X_CO_start = se3.inverse(X_WC) @ X_WO
        self._require_reach()

    def _begin(self, stage: np.ndarray, rate: np.ndarray) -> np.ndarray:
        """Where the stage (x, y, yaw) rests before it moves at the given rate."""
        return stage

    def _start(self, X_WG: np.ndarray, rng: np.random.Generator) -> np.ndarray:
        """Joint angles from which the hand starts: aside and above its goal and turned, within the arm's reach."""
        s = self.settings
        q_goal = joints_for(X_WG, puma560.NAMED["nominal"])
        for _ in range(100):
            aside = np.array([*rng.uniform(-s.start_offset_m, s.start_offset_m, 2), rng.uniform(0.02, 0.08)])
            R_turn = se3.exp_so3(direction(rng) * np.deg2rad(s.start_turn_deg) * rng.uniform())
            try:
                return joints_for(se3.pose(R_turn @ X_WG[:3, :3], X_WG[:3, 3] + aside), q_goal)
            except InputError:
                continue
        raise InputError(
            f"{self.name}: no start within reach of the arm for clearance_m {s.clearance_m}, start_offset_m {s.start_offset_m}, "
            f"start_turn_deg {s.start_turn_deg}; take smaller ones"
        )

    def _require_on_stage(self) -> None:
        """InputError if the object leaves its stage."""
        if (np.abs(self._way()) > STAGE_TRAVEL).any():
            x, y, yaw = STAGE_TRAVEL * [1e3, 1e3, np.rad2deg(1.0)]
            raise InputError(
                f"{self.name}: the object leaves its stage, which moves by {x:.0f} mm in x, {y:.0f} mm in y and {yaw:.0f} deg: "
                "take a smaller object_speed_m_s, object_turn_deg_s or cruise_s"
            )

    def _require_reach(self) -> None:
        """InputError if the object carries the goal out of the arm's reach."""
        q = self.config.q_initial
        for stage in self._way():
            try:
                q = joints_for(standing(stage) @ self.X_OG, q)
            except InputError as error:
                raise InputError(f"{self.name}: the object carries the goal out of reach: {error}") from None

    def _way(self) -> np.ndarray:
        """(n, 3) places of the stage, x and y [m] and yaw [rad], from its start to its end."""
        return self.motion.vector_values(np.linspace(0.0, self.motion.end_time(), 30)).T

    def task(self):
        return Reach(self.X_WC, self.X_OG, self.cad.corners)

    def referee(self):
        return AlignmentError(self.X_OG)

    def body_and_goal(self, X_WO, X_WE):
        return X_WE, X_WO @ self.X_OG

    @property
    def duration(self) -> float:
        return self.motion.end_time() + self.settings.settle_s

    def windows(self, t):
        s = self.settings
        return {
            "final": t > self.duration - 0.5,
            "following": (t >= s.approach_s) & (t <= self.motion.end_time()) & (s.cruise_s > 0),
            "aligned": (t > s.approach_s - 0.5) & (t < s.approach_s),
        }

    def limits(self):
        s = self.settings
        return {
            **super().limits(),
            "following_translation_error_mm": s.max_following_error_mm,
            "following_rotation_error_deg": s.max_following_error_deg,
        }


@dataclass(frozen=True, kw_only=True)
class FollowSettings(AlignSettings):
    """What can be set with ``--set`` or in ``follow.yaml``."""

    approach_s: float = 4.0
    settle_s: float = 1.5
    start_offset_m: float = 0.05
    start_turn_deg: float = 10.0
    object_speed_m_s: float = 0.1
    object_turn_deg_s: float = 20.0
    cruise_s: float = 1.0
    max_following_error_mm: float = 15.0
    max_following_error_deg: float = 4.0
    max_following_rms_mm: float = 5.0
    max_following_rms_deg: float = 2.0


class Follow(Align):
    """As ``align``; the object's way is centred on the place where it stood, so that it may be longer."""

    name = "follow"
    summary = "keep a constant pose to an object that moves at 0.1 m/s and turns at 20 degrees/s (paper III-D)"
    settings_type = FollowSettings
    done = "the hand kept its place at the object"

    def _begin(self, stage, rate):
        return stage - 0.5 * rate * (self.settings.cruise_s + RAMP)

    def limits(self):
        s = self.settings
        return {
            **super().limits(),
            "following_translation_rms_mm": s.max_following_rms_mm,
            "following_rotation_rms_deg": s.max_following_rms_deg,
        }
