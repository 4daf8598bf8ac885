"""What the benchmarks that print tables have in common: which parts are wanted, how much of them, and where the data are.

A benchmark is a module ``vipr.scenarios.bench.NAME`` with ``PARTS`` (name: what it measures), ``SEED`` (where nobody gives one),
``NEEDS_DATA`` (name of a part: what --data must hold for it; such parts are left out where neither they nor data are given) and
``tables(part, bench) -> Iterator[Table]``.
"""

import importlib
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

from vipr.scenarios.bench.tables import Table, chosen_parts
from vipr.systems.errors import InputError


@dataclass(frozen=True)
class Bench:
    """How much is to be measured, from what, and whom to tell."""

    quick: bool = False
    data: Path | None = None  # folder of recordings
    seed: int = 0
    progress: Callable[[str], None] = lambda text: None
    jobs: int = 1  # at a time, for what runs in processes of its own

    def of(self, count: int, quick: int) -> int:
        """How many: ``count``, or ``quick`` of them."""
        return quick if self.quick else count

    def seeds(self, count: int, quick: int) -> range:
        """Seeds of the runs of one part, from the benchmark's own on."""
        return range(self.seed, self.seed + self.of(count, quick))


def measure(
    name: str,
    only: Sequence[str] = (),
    *,
    quick: bool = False,
    data: Path | None = None,
    seed: int | None = None,
    progress: Callable[[str], None] = lambda text: None,
    jobs: int = 1,
) -> Iterator[Table]:
    """The tables of a benchmark's parts (all if none are named), each as soon as it is measured.

    Raises InputError for unknown parts and missing data, before anything is measured.
    """
    module = importlib.import_module(f"vipr.scenarios.bench.{name}")
    parts = chosen_parts(name, only, module.PARTS)
    if data is None and not only:
        parts = [part for part in parts if part not in module.NEEDS_DATA]
    for part in parts:
        if part in module.NEEDS_DATA and (data is None or not data.is_dir()):
            raise InputError(f"bench {name}: {part} needs --data FOLDER with {module.NEEDS_DATA[part]}, got {data}")
    bench = Bench(quick, data, module.SEED if seed is None else seed, progress, jobs)
    return (table for part in parts for table in module.tables(part, bench))
