"""Where an object is put for a pick, and how it lies: by the seed, within reach of the arm."""

from dataclasses import dataclass

import numpy as np

from vipr.diagrams.workcell_layout import STAGE, obstacles, puma_with_hand
from vipr.systems import se3
from vipr.systems.arm.resolved_rate import JointLimits
from vipr.systems.errors import InputError
from vipr.systems.grasping.candidates import Solid, resting_pose
from vipr.systems.grasping.grasp import GraspTable
from vipr.systems.grasping.planning import Errand, Surroundings, plan_grasp
from vipr.systems.grasping.support import Support
from vipr.systems.tracking.cad_model import CadModel

LOOKING = np.radians(
    [0.0, 110.0, -195.0, 0.0, 25.0, 0.0]
)  # the arm folded back, out of the camera's sight of the stage
LIES = ("standing", "lying", "any")


@dataclass(frozen=True, eq=False)
class Placement:
    """One object on the stage and the arm before it."""

    stage: np.ndarray  # (3,) x, y [m], yaw [rad]
    X_PO: np.ndarray  # on the plate
    q: np.ndarray  # (6,) rad, the arm before it begins

    @property
    def X_WO(self) -> np.ndarray:
        X_WP = se3.pose(se3.exp_so3(np.array([0.0, 0.0, self.stage[2]])), STAGE + [self.stage[0], self.stage[1], 0.0])
        return X_WP @ self.X_PO


def around(stage: np.ndarray, limits: JointLimits, model: CadModel) -> Surroundings:
    """What the arm must not touch while it picks this object from the stage at x, y, yaw."""
    solid = Solid.of(model)
    return Surroundings(puma_with_hand(), limits, obstacles(stage), Support(STAGE[2], solid.low, solid.high))


def ways_to_lie(table: GraspTable, model: CadModel, lie: str) -> list[np.ndarray]:
    """The axes of O that may point up, of those that grasps are taught for. Lying: its longest side is level."""
    if lie not in LIES:
        raise InputError(f"lie must be one of {', '.join(LIES)}, got {lie!r}")
    long = int(np.argmax(np.ptp(model.corners, axis=0)))
    taught = {tuple(np.round(grasp.up, 3)): grasp.up for grasp in table.grasps}
    ways = [up for up in taught.values() if lie == "any" or (abs(up[long]) > 0.5) == (lie == "standing")]
    if not ways:
        raise InputError(f"pick: no grasp is taught for a {lie} {table.object}; lie may be any")
    return ways


def random_placement(
    table: GraspTable, model: CadModel, limits: JointLimits, errand: Errand, lie: str, rng: np.random.Generator
) -> Placement:
    """A placement in reach: one for which at least one taught grasp can be carried out."""
    ways, solid = ways_to_lie(table, model, lie), Solid.of(model)
    for _ in range(60):
        up = ways[rng.integers(len(ways))]
        stage = np.array([rng.uniform(-0.10, 0.08), rng.uniform(-0.12, 0.12), rng.uniform(-np.pi, np.pi)])
        q = LOOKING + np.radians(rng.uniform(-8.0, 8.0, 6))
        placement = Placement(stage, resting_pose(solid, up), q)
        try:
            check(placement, table, model, limits, errand)
        except InputError:
            continue
        return placement
    raise InputError(f"pick: in 60 tries no place was found where a grasp of {table.object} could be carried out")


def check(placement: Placement, table: GraspTable, model: CadModel, limits: JointLimits, errand: Errand) -> None:
    """InputError if no taught grasp could be carried out, even if the object's pose were known exactly."""
    plan_grasp(table, placement.X_WO, placement.q, around(placement.stage, limits, model), errand)
