"""``vipr bench gestures``: hidden Markov models beside enumeration and hmmlearn, real handwriting, real pauses.

One module a part; each has ``run(bench) -> Iterator[Table]``. See `PARTS` for their names.
"""

import importlib
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path

from vipr.scenarios.bench.tables import Table
from vipr.systems.errors import InputError

PARTS = {
    "likelihoods": "scores and re-estimation beside enumeration of all paths and beside hmmlearn",
    "speed": "scoring and training beside hmmlearn",
    "handwriting": "real handwriting, writers held out (needs --data)",
    "phases": "pauses between the gestures of a speaker (needs --data)",
}
WITH_DATA = ("handwriting", "phases")


@dataclass(frozen=True)
class Bench:
    """What every part is told."""

    quick: bool
    data: Path | None  # folder with unipen_lower/, pendigits/ and gesture_phase/
    seed: int
    progress: Callable[[str], None]


def run(
    *,
    quick: bool = False,
    only: list[str] | None = None,
    data: Path | None = None,
    seed: int = 0,
    progress: Callable[[str], None] = lambda text: None,
) -> Iterator[Table]:
    """The tables of the parts, each as soon as it is measured. Raises InputError for unknown parts or missing data."""
    names = only or [name for name in PARTS if data is not None or name not in WITH_DATA]
    for name in names:
        if name not in PARTS:
            raise InputError(f"bench gestures: unknown part {name!r}, allowed are {', '.join(PARTS)}")
        if name in WITH_DATA and (data is None or not data.is_dir()):
            raise InputError(
                f"bench gestures: {name} needs --data FOLDER with unipen_lower/, pendigits/ and gesture_phase/, got {data}"
            )
    bench = Bench(quick, data, seed, progress)
    for name in names:
        yield from importlib.import_module(f"vipr.scenarios.bench.gestures.{name}").run(bench)
