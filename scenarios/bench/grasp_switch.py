"""What the TorqueSwitch is worth by how it is set: wraps and pinches of upright objects on the bench, with the hand alone."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from vipr.models import model_path, object_names
from vipr.scenarios.bench.tables import Table
from vipr.scenarios.teaching.teach import displaced
from vipr.scenarios.teaching.trial import Trial, attempt, fits
from vipr.systems.grasping.candidates import Solid, candidates, resting_pose
from vipr.systems.grasping.grasp import Grasp
from vipr.systems.hand.torque_switch import GRASPING
from vipr.systems.tracking.cad_model import load_model

SETTINGS = (0.5, 1.0, 1.5, float("inf"))  # N m
UP = np.array([0.0, 0.0, 1.0])
COLUMNS = ("grip", "break-away N m", "tries", "held %", "clutches let go", "epsilon", "slip mm", "worst", "turned deg")


def run(seed: int, progress: Callable[[str], None], objects: list[str] | None = None) -> Table:
    """Every side grasp of every object, where the hand should be and where it is when the pose is wrong, with each setting."""
    tasks = [task for name in objects or object_names() for task in _tasks(name, np.random.default_rng(seed))]
    table = Table("The TorqueSwitch by its setting: side grasps on the bench, closed, lifted, shaken", COLUMNS)
    for grip in ("wrap", "pinch"):
        some = [task for task in tasks if grip in task[1].name]
        for setting in SETTINGS:
            trials = []
            for name, grasp, X_WO, X_WG in some:
                trials.append(attempt(grasp, name, X_WO, X_WG, drives=replace(GRASPING, break_away_torque=setting)))
                progress(f"{grip} at {setting:g} N m: {len(trials)} of {len(some)}; {name} {grasp.name}")
            if trials:
                table.rows.append((grip, "none" if np.isinf(setting) else f"{setting:g}", *_summary(trials)))
    table.note = (
        "clutches let go: of three; epsilon and the rest: medians of those held; slip and turn while lifted and shaken"
    )
    return table


def _tasks(name: str, rng: np.random.Generator) -> list[tuple[str, Grasp, np.ndarray, np.ndarray]]:
    solid = Solid.of(load_model(model_path(f"{name}/model.yaml")))
    X_WO = resting_pose(solid, UP)
    sides = [g for g in candidates(solid, UP) if g.name.startswith("side") and not g.name.endswith("turned")]
    return [
        (name, grasp, X_WO, X_WG)
        for grasp in sides
        if fits(grasp, name, X_WO)
        for X_WG in (X_WO @ grasp.X_OG, *displaced(grasp, X_WO, rng))
    ]


def _summary(trials: list[Trial]) -> tuple:
    held = [t for t in trials if t.held]
    if not held:
        return len(trials), 0.0, *[float("nan")] * 5
    slips = 1e3 * np.array([t.slip for t in held])
    return (
        len(trials),
        100.0 * len(held) / len(trials),
        float(np.mean([t.let_go for t in held])),
        float(np.median([t.quality for t in held])),
        float(np.median(slips)),
        float(slips.max()),
        float(np.degrees(np.median([t.tilt for t in held]))),
    )
