"""``vipr bench tracking``: the model-based tracker on rendered sequences with truth and on recordings.

One module a part; each has ``run(bench) -> Iterator[Table]``. See `PARTS` for their names.
"""

import importlib
from collections.abc import Iterator
from functools import cache

from vipr.scenarios.bench.benchmark import Bench
from vipr.scenarios.bench.tables import Table
from vipr.scenarios.bench.tracking.workbench import Workbench

PARTS = {
    "accuracy": "errors beside the Cramer-Rao bound",
    "rounds": "printed can, mug and bottle from starts that are wrong",
    "fig11": "full turns and lateral motion, survived or not",
    "parts": "what is followed with each part of the method switched off",
    "handheld": "carried and shaken by hand before clutter",
    "disturbance": "occlusion, clutter, light, blur, dropped frames",
    "loss": "forced losses detected, false alarms",
    "recordings": "real recordings beside ViSP and RAPID",
    "time": "milliseconds by step, with nodes and with image size",
}
SEED = 0
NEEDS_DATA = {
    "recordings": "folders of images/, object.obj, camera.yaml and reference.csv, itself or in its folder tracking"
}
_workbench = cache(Workbench)  # its renderers and its count of good frames serve all parts of one benchmark


def tables(part: str, bench: Bench) -> Iterator[Table]:
    """The tables of one part."""
    return importlib.import_module(f"{__name__}.{part}").run(_workbench(bench))
