"""One run of a servo scenario with pictures and joint servo replaced by geometry, and what is measured of it."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder
from pydrake.trajectories import Trajectory

from vipr.diagrams.geometric_servo import GeometricServo
from vipr.diagrams.servo_robot import STOPPING_TIME
from vipr.diagrams.workcell_layout import JOINT_LIMITS, STAGE, collision_guard, puma_with_hand
from vipr.scenarios.servoing import WORKSPACE, ServoScenario, stage_and_fingers
from vipr.systems import se3
from vipr.systems.camera.lens import Lens
from vipr.systems.servo.hybrid import Hybrid
from vipr.systems.servo.image_based import ImageBased
from vipr.systems.servo.laws import ServoLaw
from vipr.systems.servo.position_based import PositionBased
from vipr.systems.servo.target_filter import TargetMotion
from vipr.systems.servo.tasks import Task
from vipr.systems.tracking.geometric_sight import GeometricSight, SightErrors
from vipr.systems.truth import KinematicTruth

# The tracker's errors against truth, RMS, measured in three runs of `follow` and `place_by_showing` with two pixels rendered for one: bias
# of an object at rest, noise of one that moves (at rest the noise is a fifth).
TRACKER = SightErrors(
    rotation_noise=5e-4,
    lateral_noise=5e-5,
    depth_noise=2.5e-4,
    rotation_bias=6e-4,
    lateral_bias=5e-5,
    depth_bias=4e-4,
)
# By how much the bias at a shown place differs from one look to the next, RMS: from where the tracker, which knows the picture of the
# place, sees the object there again in rendered runs of `place_by_showing` (four places).
AGAIN = SightErrors(rotation_bias=2e-4, lateral_bias=2e-5, depth_bias=1.3e-4)
GUARD = collision_guard()
CLOSE_MM, CLOSE_DEG = 1.0, 0.3  # from the goal: converged
LAST = 0.5  # s, the end of a run that is judged
TICK = 0.04  # s, from exposure to exposure

LAWS: dict[str, ServoLaw] = {
    "position-based": PositionBased(),
    "image-based, current L": ImageBased(jacobian="current"),
    "image-based, desired L": ImageBased(jacobian="desired"),
    "image-based, mean L": ImageBased(jacobian="mean"),
    "image-based, estimated depth": ImageBased(jacobian="estimated"),
    "2.5D": Hybrid(),
}


@dataclass(frozen=True, eq=False)
class Setting:
    """What is run: an arm with its hand at q, an object, a camera, a task; ``body_and_goal(X_WO, X_WE)`` gives the true X_WB and X_WG."""

    q_initial: np.ndarray
    truth: dict  # of KinematicTruth
    points_O: np.ndarray
    task: Task
    body_and_goal: Callable[[np.ndarray, np.ndarray], tuple[np.ndarray, np.ndarray]]
    lens: Lens
    duration: float
    motion: Trajectory  # of the stage
    X_WS: np.ndarray
    believed: Lens | None = None  # a wrong lens
    blind: tuple[float, float] = (np.inf, np.inf)  # s
    sight: SightErrors = TRACKER
    stopping_time: float = STOPPING_TIME
    seed: int = 0

    @classmethod
    def of(cls, scenario: ServoScenario) -> "Setting":
        """A scenario's, with what its robot believes."""
        config = scenario.config
        return cls(
            q_initial=config.q_initial,
            truth={"X_WC": config.X_WC, "X_EO_held": config.X_EO_held},
            points_O=scenario.cad.corners,
            task=scenario.task(),
            body_and_goal=scenario.body_and_goal,
            lens=config.lens,
            duration=scenario.duration,
            motion=scenario.motion,
            X_WS=se3.pose(np.eye(3), STAGE),
            stopping_time=scenario.settings.stopping_time_s,
            believed=None if scenario.lens == config.lens else scenario.lens,
            seed=scenario.seed,
        )


@dataclass(frozen=True, eq=False)
class Flight:
    """What happened: one row a camera tick."""

    setting: Setting
    t: np.ndarray  # (n,) s
    X_WB: np.ndarray  # (n, 4, 4) the true body
    X_WG: np.ndarray  # (n, 4, 4) its true goal
    q: np.ndarray  # (n, 6) rad, of the set-points
    rates: np.ndarray  # (n, 6) rad/s
    V: np.ndarray  # (n, 6) commanded twist of the hand
    servo_error: np.ndarray  # (n, 6) the error that the servo believes in
    X_WO: np.ndarray  # (n, 4, 4)
    X_WE: np.ndarray  # (n, 4, 4)
    X_CO: np.ndarray  # (n, 4, 4)
    limit_use: np.ndarray  # (3,) shares of position, speed and acceleration limits, on every set-point
    status: str  # at the end

    @cached_property
    def error(self) -> np.ndarray:
        """(n, 6) rotation vector [rad] and translation [m] from the body to its goal, against truth."""
        return np.array([se3.difference(B, G) for B, G in zip(self.X_WB, self.X_WG, strict=True)])

    @cached_property
    def mm(self) -> np.ndarray:
        return 1e3 * np.linalg.norm(self.error[:, 3:], axis=1)

    @cached_property
    def deg(self) -> np.ndarray:
        return np.rad2deg(np.linalg.norm(self.error[:, :3], axis=1))

    @property
    def last(self) -> np.ndarray:
        """Ticks (n,) of the end that is judged."""
        return self.t > self.t[-1] - LAST

    @property
    def close(self) -> np.ndarray:
        """Ticks (n,) at the goal."""
        return (self.mm < CLOSE_MM) & (self.deg < CLOSE_DEG)

    @property
    def converged(self) -> bool:
        return bool(self.close[self.last].all())

    @property
    def time(self) -> float:
        """When it came to its goal for good [s]; NaN if it did not."""
        if not self.close[-1]:
            return float("nan")
        away = np.flatnonzero(~self.close)
        return float(self.t[away[-1] + 1]) if len(away) else float(self.t[0])

    @property
    def path(self) -> float:
        """Way of the hand [m]."""
        return float(np.linalg.norm(np.diff(self.X_WE[:, :3, 3], axis=0), axis=1).sum())

    @cached_property
    def pixels(self) -> np.ndarray:
        """(n, m, 2) of the features where they truly are; NaN behind the camera."""
        p = self.setting.points_O @ np.swapaxes(self.X_CO[:, :3, :3], 1, 2) + self.X_CO[:, None, :3, 3]
        p[p[..., 2] <= 0] = np.nan
        return self.setting.lens.project(p)

    @property
    def final_px(self) -> float:
        """Distance of the features from their goal in the image, as the servo believes: mean of the features, RMS of the end [px]."""
        p, lens = self.setting.task.points_B, self.setting.lens
        errors = []
        for k in np.flatnonzero(self.last):
            X_CW, X_WB, e = self.X_CO[k] @ se3.inverse(self.X_WO[k]), self.X_WB[k], self.servo_error[k]
            X_WG = se3.pose(se3.exp_so3(e[:3]) @ X_WB[:3, :3], X_WB[:3, 3] + e[3:])
            here, there = (lens.project(p @ X[:3, :3].T + X[:3, 3]) for X in (X_CW @ X_WB, X_CW @ X_WG))
            errors.append(np.linalg.norm(here - there, axis=1).mean())
        return float(np.sqrt(np.mean(np.square(errors))))

    @property
    def in_view(self) -> bool:
        """Whether every feature was in the picture all the time."""
        u, v = self.pixels[..., 0], self.pixels[..., 1]
        lens = self.setting.lens
        return bool(((u > -0.5) & (u < lens.width - 0.5) & (v > -0.5) & (v < lens.height - 0.5)).all())

    @property
    def stopped_at_a_limit(self) -> bool:
        """Whether the arm stands although the servo asks for motion."""
        return bool(np.abs(self.V[-1]).max() > 1e-2 and np.abs(self.rates[-1]).max() < 1e-4)

    @property
    def within_limits(self) -> bool:
        """Whether every set-point kept the joints' limits and hand and arm kept their distance from everything."""
        return bool((self.limit_use <= 1.0001).all()) and self.clearance > 0

    @cached_property
    def clearance(self) -> float:
        """Least gap between the arm with its hand and the workcell, or itself [m]."""
        return float(GUARD.body.clearance(self.q, GUARD.obstacles)[0].min())


def fly(
    setting: Setting,
    law: ServoLaw,
    *,
    see_hand: bool = False,
    motion: TargetMotion = TargetMotion(),
    step: float = TICK,
) -> Flight:
    """Run it, and look at it every ``step`` seconds, a millisecond before the exposures."""
    arm = puma_with_hand()
    lenses = {} if setting.believed is None else {"lens": setting.lens, "believed": setting.believed}
    hand_points = setting.task.points_B if see_hand else None
    sight = GeometricSight(
        setting.points_O, setting.sight, hand_points=hand_points, blind=setting.blind, seed=setting.seed, **lenses
    )
    builder = DiagramBuilder()
    robot = builder.AddNamedSystem(
        "robot",
        GeometricServo(
            arm,
            JOINT_LIMITS,
            setting.q_initial,
            KinematicTruth(arm, setting.X_WS, **setting.truth),
            sight,
            setting.task,
            law,
            see_hand=see_hand,
            guard=GUARD,
            motion=motion,
            workspace=WORKSPACE,
            stopping_time=setting.stopping_time,
        ),
    )
    stage = builder.AddSystem(stage_and_fingers(setting.motion)["stage_desired_state"])
    builder.Connect(stage.get_output_port(), robot.GetInputPort("stage_desired_state"))
    simulator = Simulator(builder.Build())
    context = robot.GetMyContextFromRoot(simulator.get_context())
    rows = {name: [] for name in ("desired_state", "V_WE_W", "servo_error", "X_WO_true", "X_WE_true", "X_CO_true")}
    times = np.arange(1, round(setting.duration / step) + 1) * step - 0.001
    for t in times:
        simulator.AdvanceTo(t)
        for name, row in rows.items():
            value = robot.GetOutputPort(name).Eval(context)
            row.append(value.GetAsMatrix4() if name.startswith("X_") else np.array(value))
    kept = {name: np.array(row) for name, row in rows.items()}
    X_WO, X_WE = kept["X_WO_true"], kept["X_WE_true"]
    X_WB, X_WG = zip(*map(setting.body_and_goal, X_WO, X_WE), strict=True)
    return Flight(
        setting,
        t=times,
        X_WB=np.array(X_WB),
        X_WG=np.array(X_WG),
        q=kept["desired_state"][:, :6],
        rates=kept["desired_state"][:, 6:],
        V=kept["V_WE_W"],
        servo_error=kept["servo_error"],
        X_WO=X_WO,
        X_WE=X_WE,
        X_CO=kept["X_CO_true"],
        limit_use=robot.GetOutputPort("limit_use").Eval(context).copy(),
        status=robot.GetOutputPort("servo_status").Eval(context).text,
    )
