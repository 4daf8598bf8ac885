"""``vipr bench gestures``: hidden Markov models beside enumeration and hmmlearn, real handwriting, real pauses.

One module a part; each has ``run(bench) -> Iterator[Table]``. See `PARTS` for their names.
"""

import importlib
from collections.abc import Iterator
from dataclasses import replace

from vipr.scenarios.bench.benchmark import Bench
from vipr.scenarios.bench.tables import Table

PARTS = {
    "likelihoods": "scores and re-estimation beside enumeration of all paths and beside hmmlearn",
    "speed": "scoring and training beside hmmlearn",
    "gaps": "letters of which a stretch was not seen",
    "handwriting": "real handwriting, writers held out",
    "phases": "pauses between the gestures of a speaker",
}
SEED = 0
NEEDS_DATA = {
    "handwriting": "unipen_lower/ and pendigits/, itself or in its folder gestures",
    "phases": "gesture_phase/, itself or in its folder gestures",
}


def tables(part: str, bench: Bench) -> Iterator[Table]:
    """The tables of one part."""
    if bench.data is not None and (bench.data / "gestures").is_dir():
        bench = replace(bench, data=bench.data / "gestures")
    return importlib.import_module(f"{__name__}.{part}").run(bench)
