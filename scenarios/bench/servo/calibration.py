"""What a wrong calibration does: the focal length 10 % off, the camera 50 mm and 5 degrees from where the robot believes it."""

from collections.abc import Iterator

import numpy as np

from vipr.scenarios.align import Align, AlignSettings
from vipr.scenarios.bench.benchmark import Bench
from vipr.scenarios.bench.servo.starts import placing, rms
from vipr.scenarios.bench.servo.trial import LAWS, Setting, fly
from vipr.scenarios.bench.tables import Table
from vipr.scenarios.camera_knowledge import CameraKnowledge
from vipr.scenarios.place_by_showing import PlaceSettings

FOCAL, SHIFT_MM, TURN_DEG = 10.0, 50.0, 5.0
SMALL_MM = 2.0
CLOSED = ("position-based", "image-based, current L")
OPEN = ("position-based", "image-based, current L")


def run(bench: Bench) -> Iterator[Table]:
    seeds = bench.seeds(20, 2)
    placed = [Setting.of(placing(PlaceSettings(place=s, duration_s=6.0, calibration=wrong(s)), s)) for s in seeds]
    reached = [
        Setting.of(Align(AlignSettings(cruise_s=0.0, approach_s=3.0, settle_s=1.5, calibration=wrong(s)), s))
        for s in seeds[: (len(seeds) + 1) // 2]
    ]
    rows = [row(bench, "closed-loop: a held object, shown before", name, placed) for name in CLOSED]
    rows += [row(bench, "open-loop: the hand to an object", name, reached) for name in OPEN]
    rows += [row(bench, "closed-loop: the hand is seen too", name, reached, see_hand=True) for name in OPEN]
    yield Table(
        f"Calibration wrong: focal length by {FOCAL:g} %, the camera's place by {SHIFT_MM:g} mm and {TURN_DEG:g} deg, geometry",
        ("endpoint", "law", f"below {SMALL_MM:g} mm", "final mm", "worst", "final deg", "worst ", "within limits"),
        rows,
        note="final: RMS of the last 0.5 s against truth, median and worst of the starts.",
    )


def wrong(seed: int) -> CameraKnowledge:
    """A focal length that is too long or too short by turns, and a camera that stands elsewhere."""
    sign = 1.0 if seed % 2 else -1.0
    return CameraKnowledge(focal_error_percent=sign * FOCAL, X_WC_error_mm=SHIFT_MM, X_WC_error_deg=TURN_DEG)


def row(bench: Bench, endpoint: str, name: str, settings: list[Setting], see_hand: bool = False) -> tuple:
    flights = []
    for k, setting in enumerate(settings):
        bench.progress(f"wrong calibration, {endpoint}, {name}: {k + 1} of {len(settings)}")
        flights.append(fly(setting, LAWS[name], see_hand=see_hand))
    mm, deg = (np.array([rms(getattr(f, unit)[f.last]) for f in flights]) for unit in ("mm", "deg"))
    return (
        endpoint,
        name,
        f"{np.count_nonzero(mm < SMALL_MM)} of {len(mm)}",
        float(np.median(mm)),
        float(mm.max()),
        float(np.median(deg)),
        float(deg.max()),
        f"{sum(f.within_limits for f in flights)} of {len(flights)}",
    )
