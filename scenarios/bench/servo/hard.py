"""The classical hard cases, with a camera in the hand that looks at a square on the stage (eye-in-hand)."""

from collections.abc import Iterator

import numpy as np

from vipr.diagrams.workcell_layout import STAGE
from vipr.scenarios.bench.benchmark import Bench
from vipr.scenarios.bench.servo.trial import LAWS, Setting, fly
from vipr.scenarios.bench.tables import Table
from vipr.scenarios.motions import out_and_back
from vipr.scenarios.servoing import joints_for
from vipr.systems import se3
from vipr.systems.arm import puma560
from vipr.systems.camera.lens import Lens
from vipr.systems.errors import InputError
from vipr.systems.servo.tasks import Look

SQUARE = 0.04 * np.array([[-1.0, -1.0, 0.0], [1.0, -1.0, 0.0], [1.0, 1.0, 0.0], [-1.0, 1.0, 0.0]])  # m
WIDE = Lens(640, 480, 600.0, 600.0, 319.5, 239.5)
DISTANCE = 0.18  # m, of the camera from the square at the goal
X_WS = se3.pose(np.eye(3), STAGE)
X_EC = np.eye(4)  # the camera looks out of the palm
X_CO_GOAL = se3.pose(np.diag([1.0, -1.0, -1.0]), [0.0, 0.0, DISTANCE])
# Where the camera starts: turned about its optical axis [deg], round the square [deg], shifted in its own axes [m]; spread at random.
CASES = {
    "90 deg about the optical axis": (90.0, 0.0, (0.0, 0.0, 0.0)),
    "180 deg about the optical axis": (180.0, 0.0, (0.0, 0.0, 0.0)),
    "30 deg round the square": (0.0, 30.0, (0.0, 0.0, 0.0)),
    "far: 0.08 m aside, 0.12 m back, 30 deg": (30.0, 0.0, (-0.07, 0.03, -0.12)),
}
SPREAD_DEG, SPREAD_M = 4.0, 0.01


def run(bench: Bench) -> Iterator[Table]:
    columns = (
        "start",
        "law",
        "converged",
        "final mm",
        "time s",
        "path m",
        "farthest m",
        "in view",
        "stopped at a limit",
    )
    seeds = bench.seeds(10, 1)
    rows, kept = [], True
    for case, start in CASES.items():
        settings = [looking(start, seed) for seed in seeds]
        for name, law in LAWS.items():
            bench.progress(f"{case}: {name}")
            flights = [fly(setting, law) for setting in settings]
            count, kept = len(flights), kept and all(f.within_limits for f in flights)
            rows.append(
                (
                    case,
                    name,
                    f"{sum(f.converged for f in flights)} of {count}",
                    float(np.median([f.mm[-1] for f in flights])),
                    float(np.median([f.time for f in flights])),
                    float(np.median([f.path for f in flights])),
                    float(np.median([f.X_CO[:, 2, 3].max() for f in flights])),
                    f"{sum(f.in_view for f in flights)} of {count}",
                    f"{sum(f.stopped_at_a_limit for f in flights)} of {count}",
                )
            )
    yield Table(
        f"Hard cases, camera in the hand, a square of 80 mm at {DISTANCE:g} m, {len(seeds)} starts each, geometry",
        columns,
        rows,
        note="farthest: the camera from the square on its way; stopped at a limit: the arm stands at a joint's stop or before a collision. "
        f"Medians; converged as above. Every set-point of every run within the limits: {'yes' if kept else 'NO'}.",
    )


def looking(start: tuple[float, float, tuple], seed: int) -> Setting:
    """The square on the stage, the camera displaced from its goal as asked, within the arm's reach."""
    rng = np.random.default_rng([seed, 5])
    X_WC_goal = X_WS @ se3.inverse(X_CO_GOAL)
    q_goal = joints_for(X_WC_goal @ se3.inverse(X_EC), puma560.NAMED["nominal"])
    for _ in range(100):
        q = _displaced(start, X_WC_goal, q_goal, rng)
        if q is not None:
            break
    else:
        raise InputError("bench servo: no start of a hard case within the arm's reach")
    return Setting(
        q_initial=q,
        truth={"X_EC": X_EC},
        points_O=SQUARE,
        task=Look(X_EC, X_CO_GOAL, SQUARE),
        body_and_goal=lambda X_WO, X_WE: (X_WE, X_WO @ se3.inverse(X_CO_GOAL) @ se3.inverse(X_EC)),
        lens=WIDE,
        duration=8.0,
        motion=out_and_back(np.zeros(3), np.zeros(3), begin=1.0, cruise=0.0),
        X_WS=X_WS,
        seed=seed,
    )


def _displaced(start, X_WC_goal: np.ndarray, q_goal: np.ndarray, rng: np.random.Generator) -> np.ndarray | None:
    """Joint angles of one random start of the case, if within reach."""
    about, round_, shift = start
    angle = rng.uniform(-np.pi, np.pi)
    tilt = np.deg2rad(round_ + rng.uniform(-SPREAD_DEG, SPREAD_DEG)) * np.array([np.cos(angle), np.sin(angle), 0.0])
    turn = np.deg2rad(about + rng.uniform(-SPREAD_DEG, SPREAD_DEG))
    to_square = se3.pose(np.eye(3), [0.0, 0.0, DISTANCE])
    X = to_square @ se3.pose(se3.exp_so3(tilt), np.zeros(3)) @ se3.inverse(to_square)
    aside = np.asarray(shift) + rng.uniform(-SPREAD_M, SPREAD_M, 3)
    X = X @ se3.pose(se3.exp_so3(np.array([0.0, 0.0, turn])), aside)
    try:
        return joints_for(X_WC_goal @ X @ se3.inverse(X_EC), q_goal)
    except InputError:
        return None
