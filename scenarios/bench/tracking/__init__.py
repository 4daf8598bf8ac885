"""``vipr bench tracking``: the model-based tracker on rendered sequences with truth and on recordings.

One module a part; each has ``run(bench) -> Iterator[Table]``. See `PARTS` for their names.
"""

import importlib
from collections.abc import Callable, Iterator
from pathlib import Path

from vipr.scenarios.bench.tables import Table, chosen_parts
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


def run(
    *,
    quick: bool = False,
    only: list[str] | None = None,
    data: Path | None = None,
    seed: int = 0,
    progress: Callable[[str], None] = lambda text: None,
) -> Iterator[Table]:
    """The tables of the parts, each as soon as it is measured. Raises InputError for unknown parts or missing data."""
    names = chosen_parts("tracking", only, PARTS)
    if not only and data is None:
        names.remove("recordings")
    bench = Workbench(quick=quick, data=data, seed=seed, progress=progress)
    for name in names:
        yield from importlib.import_module(f"vipr.scenarios.bench.tracking.{name}").run(bench)
