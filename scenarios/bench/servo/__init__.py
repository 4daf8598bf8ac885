"""``vipr bench servo``: servo laws from many starts, in hard cases, with wrong calibration, behind moving objects, losing their target.

Most runs replace pictures and joint servo by exact geometry with the tracker's measured errors and delay (``GeometricServo``); the arm's
set-point generator with its limits is the real one. ``rendered`` confirms a sample in the full workcell. One module a part.
"""

import importlib
from collections.abc import Iterator

from vipr.scenarios.bench.benchmark import Bench
from vipr.scenarios.bench.tables import Table

PARTS = {
    "starts": "the same random starts for every law",
    "hard": "half a turn about the optical axis, tilts, far starts",
    "calibration": "focal length, place of the camera wrong",
    "following": "a moving object, with and without feed-forward",
    "loss": "the target lost on the way",
    "rendered": "a sample with rendered pictures and the real tracker",
    "pursuit": "a moving object with rendered pictures and the real tracker",
}
SEED = 1
NEEDS_DATA: dict[str, str] = {}


def tables(part: str, bench: Bench) -> Iterator[Table]:
    """The tables of one part."""
    return importlib.import_module(f"{__name__}.{part}").run(bench)
