"""``vipr bench servo``: servo laws from many starts, in hard cases, with wrong calibration, behind moving objects, losing their target.

Most runs replace pictures and joint servo by exact geometry with the tracker's measured errors and delay (``GeometricServo``); the arm's
set-point generator with its limits is the real one. ``rendered`` confirms a sample in the full workcell. One module a part.
"""

import importlib
from collections.abc import Callable, Iterator
from pathlib import Path

from vipr.scenarios.bench.servo.trial import Bench
from vipr.scenarios.bench.tables import Table, chosen_parts

PARTS = {
    "starts": "the same random starts for every law",
    "hard": "half a turn about the optical axis, tilts, far starts",
    "calibration": "focal length, place of the camera wrong",
    "following": "a moving object, with and without feed-forward",
    "loss": "the target lost on the way",
    "rendered": "a sample with rendered pictures and the real tracker",
    "pursuit": "a moving object with rendered pictures and the real tracker",
}


def run(
    *,
    quick: bool = False,
    only: list[str] | None = None,
    data: Path | None = None,
    seed: int = 0,
    progress: Callable[[str], None] = lambda text: None,
) -> Iterator[Table]:
    """The tables of the parts, each as soon as it is measured. Raises InputError for unknown parts; ``data`` is not needed."""
    bench = Bench(quick=quick, seed=seed, progress=progress)
    for name in chosen_parts("servo", only, PARTS):
        yield from importlib.import_module(f"vipr.scenarios.bench.servo.{name}").run(bench)
