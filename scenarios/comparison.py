"""One change, measured: a scenario as it is and with some settings or stages changed, run on the same seeds, figure beside figure."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np
from scipy.stats import wilcoxon

from vipr.scenarios.bench.tables import Table
from vipr.scenarios.runs import run_many
from vipr.systems.errors import InputError


def compare(
    scenario: str, changes: Sequence[str], seeds: Sequence[int], out: Path, *, both: Sequence[str] = (), jobs: int = 1
) -> Table:
    """The table of a scenario with the settings ``both``, and with ``changes`` on top, over the seeds.

    A figure's row: the medians, the median of the paired differences, on how many seeds it fell and rose, and the probability that such
    differences come by chance (Wilcoxon's signed-rank test, two-sided). Seeds where either run has no such figure are left out of the row.
    Runs are left in ``out/as-it-is`` and ``out/changed``.
    """
    if not changes:
        raise InputError(
            "compare: nothing is changed; give a setting or a stage, such as --set stages.tracker=mine.py:MyTracker"
        )
    variants = [(list(both), out / "as-it-is"), ([*both, *changes], out / "changed")]
    return paired_table(scenario, changes, *run_many(scenario, variants, seeds, jobs))


def paired_table(scenario: str, changes: Sequence[str], before: list[dict], after: list[dict]) -> Table:
    """The table of two lists of summaries, run by run of the same seeds."""
    table = Table(
        f"{scenario}, {len(before)} seeds: as it is, and with {', '.join(changes)}",
        ("figure", "n", "as it is", "changed", "difference", "falls", "rises", "p"),
    )
    table.rows.append(("done", len(before), _done(before), _done(after), _done(after) - _done(before), "", "", ""))
    names = dict.fromkeys(name for summary in (*before, *after) for name in summary["figures"])
    for name in names:
        pairs = [
            (b["figures"].get(name, np.nan), a["figures"].get(name, np.nan)) for b, a in zip(before, after, strict=True)
        ]
        was, became = np.array([p for p in pairs if np.isfinite(p).all()], float).reshape(-1, 2).T
        if not len(was):
            continue
        change = became - was
        chance = float(wilcoxon(change).pvalue) if np.count_nonzero(change) > 4 else float("nan")
        row = (np.median(was), np.median(became), np.median(change))
        table.rows.append((name, len(was), *map(float, row), int((change < 0).sum()), int((change > 0).sum()), chance))
    reasons = [
        f"seed {s['seed']} {kind}: {s['reason']}"
        for kind, runs in (("as it is", before), ("changed", after))
        for s in runs
        if not s["success"]
    ]
    table.note = "; ".join(reasons)
    return table


def _done(summaries: list[dict]) -> int:
    return sum(bool(summary["success"]) for summary in summaries)
