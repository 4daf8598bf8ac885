"""``vipr bench align``: the first loop over many seeds, against its targets."""

from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context
from pathlib import Path

from rich.console import Console
from rich.table import Table

from vipr.scenarios.align import Align
from vipr.scenarios.run import run_scenario
from vipr.scenarios.settings import load_settings

COLUMNS = (
    "final_translation_error_mm",
    "final_rotation_error_deg",
    "following_translation_error_mm",
    "following_rotation_error_deg",
    "tracking_translation_rms_mm",
    "tracking_rotation_rms_deg",
)
WORK = ("vision", "control", "hand", "camera", "logging", "other")  # what is neither rendering nor physics


def run(seeds: int, overrides: list[str], out: Path, jobs: int = 1) -> list[dict]:
    """Summaries of ``align`` for seeds 1 to ``seeds``, ``jobs`` at a time; each run leaves its folder below ``out``."""
    load_settings(Align.settings_type, Align.settings_file(), overrides)  # refused here, once, if they are wrong
    with ProcessPoolExecutor(jobs, mp_context=get_context("spawn")) as pool:
        return list(pool.map(_run_one, range(1, seeds + 1), [overrides] * seeds, [out] * seeds))


def _run_one(seed: int, overrides: list[str], out: Path) -> dict:
    settings = load_settings(Align.settings_type, Align.settings_file(), overrides)
    return run_scenario(Align(settings, seed), out / f"seed-{seed}")


def print_table(summaries: list[dict]) -> None:
    """One row a seed, the worst of each column, and where the wall time went."""
    table = Table(title="align: hand against its reference pose, worst of each window")
    table.add_column("seed", justify="right")
    for name in COLUMNS:
        table.add_column(name, justify="right")
    table.add_column("done")
    for summary in summaries:
        values = [f"{summary['figures'].get(name, float('nan')):.2f}" for name in COLUMNS]
        table.add_row(str(summary["seed"]), *values, "yes" if summary["success"] else "no")
    worst = [max(s["figures"].get(name, float("nan")) for s in summaries) for name in COLUMNS]
    table.add_section()
    done = sum(summary["success"] for summary in summaries)
    table.add_row("worst", *(f"{value:.2f}" for value in worst), f"{done} of {len(summaries)}")
    console = Console()
    console.print(table)
    factor = sorted(summary["time"]["real_time_factor"] for summary in summaries)[len(summaries) // 2]
    shares = {
        name: sum(s["time"]["share"].get(name, 0.0) for s in summaries) / len(summaries)
        for name in (*WORK, "render", "physics")
    }
    console.print(
        f"real-time factor {factor:.2f} (median); neither rendering nor physics: {100 * sum(shares[n] for n in WORK):.1f} %"
    )
    console.print("wall time: " + ", ".join(f"{name} {100 * share:.1f} %" for name, share in shares.items()))
