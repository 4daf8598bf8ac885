"""A sample of the starts in the full workcell: rendered pictures, the real tracker, the arm's dynamics and joint servo."""

from collections.abc import Iterator
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

from vipr.scenarios.bench.benchmark import Bench
from vipr.scenarios.bench.servo.trial import CLOSE_DEG, CLOSE_MM
from vipr.scenarios.bench.tables import Table
from vipr.scenarios.place_by_showing import PlaceByShowing
from vipr.scenarios.run import run_scenario
from vipr.scenarios.settings import load_settings
from vipr.scenarios.shown_place import save_shown_place
from vipr.scenarios.workers import in_processes

SERVOS = ("position_based", "image_based", "hybrid")
FIGURES = ("final_translation_error_mm", "final_rotation_error_deg")


def run(bench: Bench) -> Iterator[Table]:
    seeds = bench.seeds(10, 2)
    found: dict[str, list[dict]] = {servo: [] for servo in SERVOS}
    bench.progress(f"rendered: {', '.join(SERVOS)}, places {seeds[0]} to {seeds[-1]}")
    for seed, figures in zip(seeds, in_processes(_placed, [(seed,) for seed in seeds], bench.jobs), strict=True):
        bench.progress(f"rendered: place {seed} done")
        for servo in SERVOS:
            found[servo].append(figures[servo])
    rows = []
    for servo, figures in found.items():
        mm, deg = (np.array([f[name] for f in figures]) for name in FIGURES)
        rows.append(
            (
                servo,
                f"{np.count_nonzero((mm < CLOSE_MM) & (deg < CLOSE_DEG))} of {len(mm)}",
                float(np.median(mm)),
                float(mm.max()),
                float(np.median(deg)),
                float(deg.max()),
                float(np.median([f["tracking_translation_rms_mm"] for f in figures])),
                most_used(figures),
            )
        )
    yield Table(
        f"A held object to where it was shown (place_by_showing), {len(seeds)} starts, pictures, tracker, dynamics",
        ("servo", "converged", "final mm", "worst", "final deg", "worst ", "tracking RMS mm", "limits used %"),
        rows,
        note="final: largest error of the last 0.5 s, median and worst of the starts; two pixels rendered for one. limits used: most "
        "of any joint limit.",
    )


def _placed(seed: int) -> dict[str, dict]:
    """The place of a seed is shown, then reached from the start of the seed by each servo: its figures."""
    common, figures = ["duration_s=5", f"place={seed}"], {}
    with TemporaryDirectory() as folder:
        shown = Path(folder) / "shown.yaml"
        save_shown_place(PlaceByShowing(_settings(common), seed).show(), shown)
        for servo in SERVOS:
            settings = _settings([*common, f"shown={shown}", f"servo={servo}"])
            run = run_scenario(PlaceByShowing(settings, seed), Path(folder) / servo, video=False)
            figures[servo] = run["figures"]
    return figures


def most_used(figures: list[dict]) -> float:
    """The largest share of any joint limit that any of the runs used [%]."""
    return float(max(value for f in figures for name, value in f.items() if name.endswith("_used_percent")))


def _settings(overrides: list[str]):
    return load_settings(PlaceByShowing.settings_type, PlaceByShowing.settings_file(), overrides)
