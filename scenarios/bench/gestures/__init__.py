"""``vipr bench gestures``: hidden Markov models beside enumeration and hmmlearn, real handwriting, real pauses.

One module a part; each has ``run(bench) -> Iterator[Table]``. See `PARTS` for their names.
"""

import importlib
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path

from vipr.scenarios.bench.tables import Table, chosen_parts
from vipr.systems.errors import InputError

PARTS = {
    "likelihoods": "scores and re-estimation beside enumeration of all paths and beside hmmlearn",
    "speed": "scoring and training beside hmmlearn",
    "handwriting": "real handwriting, writers held out (needs --data)",
    "phases": "pauses between the gestures of a speaker (needs --data)",
}
WITH_DATA = ("handwriting", "phases")
FOLDERS = "unipen_lower/, pendigits/ and gesture_phase/"


@dataclass(frozen=True)
class Bench:
    """What every part is told."""

    quick: bool
    data: Path | None  # folder with FOLDERS
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
    """The tables of the parts, each as soon as it is measured. Raises InputError for unknown parts or missing data.

    ``data`` holds FOLDERS, itself or in its folder ``gestures``.
    """
    names = chosen_parts("gestures", only, PARTS)
    if not only and data is None:
        names = [name for name in names if name not in WITH_DATA]
    if data is not None and (data / "gestures").is_dir():
        data = data / "gestures"
    for name in names:
        if name in WITH_DATA and (data is None or not data.is_dir()):
            raise InputError(f"bench gestures: {name} needs --data FOLDER with {FOLDERS}, got {data}")
    bench = Bench(quick, data, seed, progress)
    for name in names:
        yield from importlib.import_module(f"vipr.scenarios.bench.gestures.{name}").run(bench)
