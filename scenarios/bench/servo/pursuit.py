"""``follow`` in the full workcell: rendered pictures, the real tracker, the arm's dynamics and joint servo."""

from collections.abc import Iterator
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

from vipr.scenarios.align import Follow
from vipr.scenarios.bench.servo.rendered import SERVOS, most_used
from vipr.scenarios.bench.servo.trial import Bench
from vipr.scenarios.bench.tables import Table
from vipr.scenarios.run import run_scenario
from vipr.scenarios.settings import load_settings

FIGURES = (  # the worst run of each
    "following_translation_rms_mm",
    "following_translation_error_mm",
    "following_rotation_rms_deg",
    "following_rotation_error_deg",
    "final_translation_error_mm",
    "final_rotation_error_deg",
)


def run(bench: Bench) -> Iterator[Table]:
    seeds, rows = bench.seeds(3, 1), []
    for servo in SERVOS:
        settings = load_settings(Follow.settings_type, Follow.settings_file(), [f"servo={servo}"])
        summaries = []
        for seed in seeds:
            bench.progress(f"follow: {servo}, seed {seed}")
            with TemporaryDirectory() as folder:
                summaries.append(run_scenario(Follow(settings, seed), Path(folder) / "run", video=False))
        figures = [summary["figures"] for summary in summaries]
        worst = [float(np.max([f[name] for f in figures])) for name in FIGURES]
        done = sum(bool(summary["success"]) for summary in summaries)
        rows.append((servo, f"{done} of {len(figures)}", *worst, most_used(figures)))
    yield Table(
        f"Following an object at {settings.object_speed_m_s:g} m/s and {settings.object_turn_deg_s:g} deg/s (follow), seeds "
        f"{seeds[0]} to {seeds[-1]}, pictures, tracker, dynamics",
        ("servo", "done", "RMS mm", "largest mm", "RMS deg", "largest deg", "final mm", "final deg", "limits used %"),
        rows,
        note="Worst of the seeds; RMS and largest while the object moves, final: largest of the last 0.5 s. limits used: most of any joint "
        "limit.",
    )
