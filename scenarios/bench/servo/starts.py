"""The same random starts for every law: an object placed where it was shown, and a hand brought to an object."""

from collections.abc import Iterable, Iterator

import numpy as np

from vipr.scenarios.align import Align, AlignSettings
from vipr.scenarios.bench.benchmark import Bench
from vipr.scenarios.bench.servo.trial import AGAIN, LAWS, TRACKER, Flight, Setting, fly
from vipr.scenarios.bench.tables import Table
from vipr.scenarios.place_by_showing import PlaceByShowing, PlaceSettings
from vipr.scenarios.shown_place import ShownPlace
from vipr.systems import se3
from vipr.systems.tracking.geometric_sight import bias

COLUMNS = (
    "law",
    "converged",
    "final mm",
    "worst",
    "final deg",
    "worst ",
    "final px",
    "time s",
    "path m",
    "joint speed %",
    "in view",
    "within limits",
)
NOTE = (
    "converged: below 1 mm and 0.3 deg for the last 0.5 s. final: RMS of the last 0.5 s against truth, median and worst of the starts; px: "
    "distance of the features from their goal in the image as the servo sees it, worst. time: until it stays below; path: of the hand; "
    "joint speed: largest share of its limit; medians. within limits: every set-point within position, speed and acceleration limits, "
    "and nothing touched."
)


def run(bench: Bench) -> Iterator[Table]:
    seeds = bench.seeds(100, 5)
    yield table(
        bench,
        f"A held object to where it was shown (place_by_showing), {len(seeds)} starts, geometry with the tracker's errors",
        [Setting.of(placing(PlaceSettings(place=seed, duration_s=5.0), seed)) for seed in seeds],
    )
    seeds = bench.seeds(30, 3)
    yield table(
        bench,
        f"The hand to its reference pose, endpoint open-loop (align), {len(seeds)} starts, geometry with the tracker's errors",
        [Setting.of(Align(AlignSettings(cruise_s=0.0, approach_s=3.0, settle_s=1.5), seed)) for seed in seeds],
        ("position-based", "image-based, current L", "2.5D"),
    )


def placing(settings: PlaceSettings, seed: int) -> PlaceByShowing:
    """The scenario, its place shown by geometry: the corners' pixels with the bias that the tracker had when it looked."""
    scenario = PlaceByShowing(settings, seed)
    rng = np.random.default_rng([seed, 4])
    X = se3.inverse(scenario.config.X_WC) @ scenario.X_WO_shown
    error = bias(TRACKER, seed) + AGAIN.draw(rng, "bias")
    X = se3.pose(se3.exp_so3(error[:3]) @ X[:3, :3], X[:3, 3] + error[3:])
    lens, points = scenario.config.lens, scenario.cad.corners
    pixels = lens.project(points @ X[:3, :3].T + X[:3, 3])
    scenario.taught = ShownPlace(settings.object, settings.place, (lens.width, lens.height), points, pixels)
    return scenario


def table(bench: Bench, title: str, settings: list[Setting], laws: Iterable[str] = LAWS) -> Table:
    """One row a law."""
    rows = []
    for name in laws:
        flights = []
        for k, setting in enumerate(settings):
            bench.progress(f"{title.split(',')[0]}: {name}, start {k + 1} of {len(settings)}")
            flights.append(fly(setting, LAWS[name]))
        rows.append((name, *summary(flights)))
    return Table(title, COLUMNS, rows, note=NOTE)


def summary(flights: list[Flight]) -> tuple:
    """The columns after the law's name."""
    count = len(flights)
    mm, deg = (np.array([rms(getattr(f, unit)[f.last]) for f in flights]) for unit in ("mm", "deg"))
    return (
        f"{sum(f.converged for f in flights)} of {count}",
        float(np.median(mm)),
        float(mm.max()),
        float(np.median(deg)),
        float(deg.max()),
        max(f.final_px for f in flights),
        float(np.median([f.time for f in flights])),
        float(np.median([f.path for f in flights])),
        float(np.median([100.0 * f.limit_use[1] for f in flights])),
        f"{sum(f.in_view for f in flights)} of {count}",
        f"{sum(f.within_limits for f in flights)} of {count}",
    )


def rms(values: np.ndarray) -> float:
    return float(np.sqrt(np.mean(np.square(values))))
