"""``vipr bench calibration``: errors of simulated calibrations beside the standard errors that they told."""

import tempfile
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from vipr.models import model_path
from vipr.scenarios.bench.benchmark import Bench
from vipr.scenarios.bench.tables import Table
from vipr.scenarios.calibrating.estimate import calibrate_images, errors
from vipr.scenarios.calibrating.views import simulate_views
from vipr.systems.calibration.board import load_board

NAMES = ("fx px", "fy px", "cx px", "cy px", "x mm", "y mm", "z mm", "rx deg", "ry deg", "rz deg")
SEEDS, VIEWS = 16, 20
LEGEND = (
    "x, y, z: the camera's position along the world's axes; rx, ry, rz: its rotation about them; workspace: how far the calibrated "
    "camera puts points above the stage from where they are seen."
)


PARTS = {"errors": "over seeds, each with another camera", "views": "what more of them are worth"}
SEED = 1
NEEDS_DATA: dict[str, str] = {}


def tables(part: str, bench: Bench) -> Iterator[Table]:
    """The tables of one part."""
    return {"errors": _errors, "views": _views}[part](bench.seeds(SEEDS, 3), bench.progress)


def _errors(seeds: range, progress) -> Iterator[Table]:
    each = Table(
        f"Error against truth, {VIEWS} views", ("seed", *NAMES, "workspace px", "RMS px", "left out"), note=LEGEND
    )
    results = []
    for seed in seeds:
        wrong, told, together, found = _one(seed, VIEWS, progress)
        results.append((wrong, told, together))
        each.rows.append((seed, *wrong, together, found.rms_px, found.left_out))
    wrong, told, together = (np.array(rows) for rows in zip(*results, strict=True))
    total = Table(
        f"Errors and standard errors, {len(seeds)} seeds, {VIEWS} views",
        ("quantity", "RMS error", "largest error", "told (1 sigma, median)", "RMS of error / told"),
        note=LEGEND,
    )
    for k, name in enumerate(NAMES):
        e, sigma = wrong[:, k], told[:, k]
        total.rows.append((name, _rms(e), np.abs(e).max(), np.median(sigma), _rms(e / sigma)))
    total.rows.append(("workspace px", _rms(together), together.max(), float("nan"), float("nan")))
    yield total
    yield each


def _views(seeds: range, progress) -> Iterator[Table]:
    table = Table(
        "RMS error against the number of views",
        ("views", "fx px", "cx px", "position mm", "rotation deg", "workspace px"),
    )
    for count in (6, 10, 20, 40):
        results = [_one(seed, count, progress) for seed in seeds[:6]]
        wrong, together = np.array([r[0] for r in results]), np.array([r[2] for r in results])
        position, rotation = (np.linalg.norm(wrong[:, k : k + 3], axis=1) for k in (4, 7))
        table.rows.append((count, _rms(wrong[:, 0]), _rms(wrong[:, 2]), _rms(position), _rms(rotation), _rms(together)))
    yield table


def _one(seed: int, views: int, progress):
    """Errors and standard errors in the order of NAMES, their effect together, and the calibration, of one simulated workcell."""
    progress(f"bench calibration: seed {seed}, {views} views")
    board = load_board(model_path("calibration_board/board.yaml"))
    with tempfile.TemporaryDirectory() as folder:
        true = simulate_views(Path(folder), seed, views, other_camera=True)
        found, _ = calibrate_images(str(Path(folder) / "images"), Path(folder) / "poses.csv", board)
    e = errors(found, true)
    wrong = np.array([*(e[name] for name in ("fx", "fy", "cx", "cy")), *e["position_mm"], *e["rotation_deg"]])
    told = np.array([*found.intrinsics_error.values(), *found.position_error_mm, *found.rotation_error_deg])
    return wrong, told, e["workspace_px"], found


def _rms(values: np.ndarray) -> float:
    return float(np.sqrt(np.mean(values**2)))
