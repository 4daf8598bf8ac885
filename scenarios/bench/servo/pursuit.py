"""``follow`` in the full workcell: rendered pictures, the real tracker, the arm's dynamics and joint servo."""

from collections.abc import Iterator
from pathlib import Path
from tempfile import TemporaryDirectory

from vipr.scenarios.align import FollowSettings
from vipr.scenarios.bench.benchmark import Bench
from vipr.scenarios.bench.servo.rendered import SERVOS, most_used
from vipr.scenarios.bench.tables import Table
from vipr.scenarios.runs import run_many

FIGURES = (  # the worst run of each
    "following_translation_rms_mm",
    "following_translation_error_mm",
    "following_rotation_rms_deg",
    "following_rotation_error_deg",
    "final_translation_error_mm",
    "final_rotation_error_deg",
)


def run(bench: Bench) -> Iterator[Table]:
    seeds, asked, rows = bench.seeds(3, 1), FollowSettings(), []
    bench.progress(f"follow: {', '.join(SERVOS)}, seeds {seeds[0]} to {seeds[-1]}")
    with TemporaryDirectory() as folder:
        found = run_many("follow", [([f"servo={servo}"], Path(folder) / servo) for servo in SERVOS], seeds, bench.jobs)
    for servo, summaries in zip(SERVOS, found, strict=True):
        figures = [summary["figures"] for summary in summaries]
        done = sum(bool(summary["success"]) for summary in summaries)
        worst = (max(float(f[name]) for f in figures) for name in FIGURES)
        rows.append((servo, f"{done} of {len(figures)}", *worst, most_used(figures)))
    yield Table(
        f"Following an object at {asked.object_speed_m_s:g} m/s and {asked.object_turn_deg_s:g} deg/s (follow), seeds {seeds[0]} to "
        f"{seeds[-1]}, pictures, tracker, dynamics",
        ("servo", "done", "RMS mm", "largest mm", "RMS deg", "largest deg", "final mm", "final deg", "limits used %"),
        rows,
        note="Worst of the seeds; RMS and largest while the object moves, final: largest of the last 0.5 s. limits used: most of any joint "
        "limit.",
    )
