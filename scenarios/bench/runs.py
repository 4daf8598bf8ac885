"""``vipr bench runs``: any scenario over many seeds, every figure with its spread."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from vipr.scenarios.bench.tables import Table
from vipr.scenarios.runs import run_many


def run(scenario: str, seeds: Sequence[int], overrides: Sequence[str], out: Path, jobs: int = 1) -> Table:
    """The table of a scenario's runs, which leave their folders below ``out``."""
    return spread(scenario, run_many(scenario, [(overrides, out)], seeds, jobs)[0])


def spread(scenario: str, summaries: list[dict]) -> Table:
    """Each figure over the runs that have it: how many, median, mean, least and greatest."""
    done = sum(bool(s["success"]) for s in summaries)
    table = Table(
        f"{scenario}: {done} of {len(summaries)} runs did their task",
        ("figure", "n", "median", "mean", "least", "greatest"),
    )
    for name in dict.fromkeys(name for s in summaries for name in s["figures"]):
        values = np.array([s["figures"].get(name, np.nan) for s in summaries], float)
        values = values[np.isfinite(values)]
        if len(values):
            row = (np.median(values), values.mean(), values.min(), values.max())
            table.rows.append((name, len(values), *map(float, row)))
    table.note = "; ".join(f"seed {s['seed']}: {s['reason']}" for s in summaries if not s["success"])
    return table
