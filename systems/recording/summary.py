"""``summary.json``: what a run was, how it ended and every figure, the same bytes for the same seed but for its timings."""

import json
import math
import platform
from collections.abc import Mapping
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path

import numpy as np

from vipr.systems.recording.files import write_whole

PACKAGES = ("vipr", "drake", "numpy", "opencv-python-headless", "av", "foxglove-sdk", "matplotlib")
DIGITS = 6  # significant ones of every number in the file


def versions() -> dict[str, str]:
    """Versions of Python and of the packages that a run's figures depend on; "absent" for one that is not installed."""
    found = {"python": platform.python_version()}
    for package in PACKAGES:
        try:
            found[package] = version(package)
        except PackageNotFoundError:
            found[package] = "absent"
    return found


def time_figures(wall_s: float, simulated_s: float, seconds: Mapping[str, float]) -> dict:
    """The ``time`` entry: wall and simulated time [s], their ratio, and each name's share of the wall time (``other``: the rest)."""
    wall = max(wall_s, 1e-9)
    share = {name: spent / wall for name, spent in sorted(seconds.items())}
    share["other"] = max(0.0, 1.0 - sum(share.values()))
    return {"wall_s": wall_s, "simulated_s": simulated_s, "real_time_factor": simulated_s / wall, "share": share}


def plain(value):
    """The value as JSON can hold it: floats of 6 significant digits, ``null`` for what is not finite, arrays as lists."""
    if isinstance(value, Mapping):
        return {str(key): plain(item) for key, item in value.items()}
    if isinstance(value, np.ndarray):
        return plain(value.tolist())
    if isinstance(value, list | tuple):
        return [plain(item) for item in value]
    if value is None or isinstance(value, bool | str):
        return value
    if isinstance(value, np.bool_):
        return bool(value)
    if isinstance(value, int | np.integer):
        return int(value)
    if isinstance(value, float | np.floating):
        return float(f"{float(value):.{DIGITS}g}") if math.isfinite(value) else None
    return str(value)


def make_summary(
    *, scenario: str, seed: int, success: bool, reason: str, figures: Mapping, time: Mapping, settings: Mapping
) -> dict:
    """The summary as plain values in the file's order of keys; figures carry their unit in the name."""
    given = {"scenario": scenario, "seed": seed, "success": bool(success), "reason": reason, "figures": figures}
    return plain(given | {"time": time, "settings": settings, "versions": versions()})


def write_summary(path: Path, **entries) -> dict:
    """Write `make_summary` of the entries, whole or not at all, and return it."""
    summary = make_summary(**entries)
    write_whole(Path(path), to_json(summary))
    return summary


def to_json(summary: Mapping) -> str:
    """The file's text."""
    return json.dumps(summary, indent=2, ensure_ascii=False, allow_nan=False) + "\n"


def without_time(path: Path) -> str:
    """Text of a summary file less its timings: equal texts, equal runs."""
    summary = json.loads(Path(path).read_text(encoding="utf-8"))
    summary.pop("time", None)
    return to_json(summary)
