"""``vipr bench align``: the first loop over many seeds, against its targets."""

from pathlib import Path

import numpy as np

from vipr.scenarios.bench.tables import Table, print_tables
from vipr.scenarios.runs import run_many

COLUMNS = {
    "final_translation_error_mm": "final mm",
    "final_rotation_error_deg": "final deg",
    "following_translation_error_mm": "following mm",
    "following_rotation_error_deg": "following deg",
    "tracking_translation_rms_mm": "tracking mm RMS",
    "tracking_rotation_rms_deg": "tracking deg RMS",
}
WORK = ("vision", "control", "hand", "camera", "logging", "other")  # what is neither rendering nor physics


def run(seeds: int, overrides: list[str], out: Path, jobs: int = 1) -> list[dict]:
    """Summaries of ``align`` for seeds 1 to ``seeds``, ``jobs`` at a time; each run leaves its folder below ``out``."""
    return run_many("align", [(overrides, out)], range(1, seeds + 1), jobs)[0]


def print_table(summaries: list[dict]) -> None:
    """One row a seed, the median and the worst of each column, and where the wall time went."""
    rows = [[summary["figures"].get(name, float("nan")) for name in COLUMNS] for summary in summaries]
    done = sum(summary["success"] for summary in summaries)
    table = Table(
        "align: hand against its reference pose, worst of each window",
        ("seed", *COLUMNS.values(), "done"),
        [(str(s["seed"]), *row, "yes" if s["success"] else "no") for s, row in zip(summaries, rows, strict=True)],
        note=_time(summaries),
    )
    table.rows.append(("median", *np.median(rows, axis=0), ""))
    table.rows.append(("worst", *np.max(rows, axis=0), f"{done} of {len(summaries)}"))
    print_tables([table])


def _time(summaries: list[dict]) -> str:
    """Real-time factor and shares of the wall time, over all runs."""
    factor = float(np.median([summary["time"]["real_time_factor"] for summary in summaries]))
    shares = {
        name: 100 * float(np.mean([s["time"]["share"].get(name, 0.0) for s in summaries]))
        for name in (*WORK, "render", "physics")
    }
    others = sum(shares[name] for name in WORK)
    told = ", ".join(f"{name} {share:.1f} %" for name, share in shares.items())
    return f"Real-time factor {factor:.2f} (median); neither rendering nor physics: {others:.1f} %; wall time: {told}"
