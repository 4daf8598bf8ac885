"""``vipr grasp teach``: search the grasps of an object on the bench, judge them, keep the best of each kind."""

from collections.abc import Callable, Iterator
from dataclasses import replace

import numpy as np
from pydrake.multibody.parsing import Parser
from pydrake.multibody.plant import MultibodyPlant

from vipr.models import model_path, object_names
from vipr.scenarios.teaching.trial import Trial, attempt, fits
from vipr.systems import se3
from vipr.systems.errors import InputError
from vipr.systems.grasping.candidates import Solid, candidates, resting_pose, rests, symmetry
from vipr.systems.grasping.grasp import Grasp, GraspTable
from vipr.systems.grasping.payload import DYNAMIC_LOAD, dynamic_load
from vipr.systems.tracking.cad_model import load_model

KEPT = 3  # grasps of each kind (from above, from the side) and way of resting
FINALISTS = 4  # of each kind, tried with errors of the pose
TRIES = 3  # of each finalist
LEAST_HELD = 0.75  # of all its tries, of a grasp that is kept
POSE_ERROR = (0.005, np.radians(4.0))  # m and rad, of these tries
# m: a grasp that slips so far, or moves the object so far in closing, is worth half.
SLIP_SCALE, MOVE_SCALE = 3e-4, 0.02


def teach(
    object_: str, *, seed: int = 1, lying: bool = True, tick: Callable[[str], None] = lambda text: None
) -> GraspTable:
    """The table of an object's grasps, by simulation; InputError if no grasp holds it. Without ``lying`` only with O's z up."""
    if object_ not in object_names():
        raise InputError(f"grasp teach: unknown object {object_!r}; there are: {', '.join(object_names())}")
    model, rng = load_model(model_path(f"{object_}/model.yaml")), np.random.default_rng(seed)
    solid, kept = Solid.of(model), []
    (mass, mass_centre), alike = mass_and_centre(object_), symmetry(model)
    for up in rests(model) if lying else rests(model)[:1]:
        X_WO = resting_pose(solid, up)
        light = [
            g for g in candidates(solid, up, mass_centre) if dynamic_load(g.X_OG, mass, alike.centre) <= DYNAMIC_LOAD
        ]
        fitting = [grasp for grasp in light if fits(grasp, object_, X_WO)]
        for kind in ("above", "side"):
            some = [grasp for grasp in fitting if grasp.name.startswith(kind)]
            kept += _best(some, object_, X_WO, rng, tick)
    if not kept:
        width = 1e3 * np.sort(solid.high - solid.low)[:2]
        raise InputError(
            f"grasp teach: nothing holds {object_}; it is {width[0]:.0f} x {width[1]:.0f} mm across at its narrowest"
        )
    grasps = tuple(sorted(kept, key=lambda grasp: -merit(grasp)))
    return GraspTable(object_, mass, alike, grasps)


def merit(grasp: Grasp) -> float:
    """What grasps are ranked by."""
    return grasp.held * grasp.quality


def mass_and_centre(object_: str) -> tuple[float, np.ndarray]:
    """Mass [kg] of an object's model and its centre (3,) in O."""
    plant = MultibodyPlant(0.0)
    Parser(plant).AddModels(str(model_path(f"{object_}/{object_}.sdf")))
    plant.Finalize()
    body = plant.GetBodyByName(object_)
    return float(body.default_mass()), np.array(body.default_com())


def _best(grasps: list[Grasp], object_: str, X_WO: np.ndarray, rng, tick) -> list[Grasp]:
    """The best few, with what they were taught: where the fingers close, quality, share held."""
    first = []
    for grasp in grasps:
        trial = attempt(grasp, object_, X_WO)
        tick(_line(object_, grasp, trial))
        if trial.held:
            first.append((_worth(trial), grasp, trial))
    first.sort(key=lambda row: -row[0])
    judged = []
    for _, grasp, trial in first[:FINALISTS]:
        tries = [trial, *(attempt(grasp, object_, X_WO, X_WG) for X_WG in displaced(grasp, X_WO, rng))]
        held = [t for t in tries if t.held]
        worth = len(held) / len(tries) * float(np.mean([_worth(t) for t in held]))
        taught = replace(grasp, closed=trial.closed, quality=worth, held=len(held) / len(tries))
        tick(f"{object_}: {grasp.name}: {len(held)} of {len(tries)} held with errors of the pose, quality {worth:.3f}")
        judged.append(taught)
    judged = [grasp for grasp in judged if grasp.held >= LEAST_HELD]
    return sorted(judged, key=lambda grasp: -merit(grasp))[:KEPT]


def _worth(trial: Trial) -> float:
    """Epsilon of the grasp, less where the object slips in it or is moved about before it is held."""
    return trial.quality / (1.0 + trial.slip / SLIP_SCALE) / (1.0 + trial.moved / MOVE_SCALE)


def displaced(grasp: Grasp, X_WO: np.ndarray, rng) -> Iterator[np.ndarray]:
    """X_WG for poses of the object that are wrong by POSE_ERROR: along the support and about the vertical, which way by chance."""
    metres, radians = POSE_ERROR
    for _ in range(TRIES):
        heading, turn = rng.uniform(-np.pi, np.pi), rng.choice([-1.0, 1.0])
        shift = metres * np.array([np.cos(heading), np.sin(heading), 0.0])
        R = se3.exp_so3(np.array([0.0, 0.0, turn * radians]))
        yield se3.pose(R @ X_WO[:3, :3], X_WO[:3, 3] + shift) @ grasp.X_OG


def _line(object_: str, grasp: Grasp, trial: Trial) -> str:
    text = f"{object_}: {grasp.name}: " + ("held" if trial.held else f"not held, {trial.why}")
    return text + (
        f", slip {1e3 * trial.slip:.2f} mm, moved {1e3 * trial.moved:.0f} mm, epsilon {trial.quality:.3f}"
        if trial.held
        else ""
    )
