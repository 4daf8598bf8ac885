"""The target lost on the way for a second: how soon the hand stands still, and whether it finds its place afterwards."""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from vipr.scenarios.bench.benchmark import Bench
from vipr.scenarios.bench.servo.starts import placing
from vipr.scenarios.bench.servo.trial import LAWS, Flight, Setting, fly
from vipr.scenarios.bench.tables import Table
from vipr.scenarios.place_by_showing import PlaceSettings

BLIND = 1.0  # s
STILL = 1e-3  # rad/s


def run(bench: Bench) -> Iterator[Table]:
    seeds = bench.seeds(10, 2)
    laws = {name: LAWS[name] for name in ("position-based", "image-based, current L", "2.5D")}
    laws["position-based, at most 0.1 m/s and 0.4 rad/s"] = replace(LAWS["position-based"], max_speed=0.1, max_turn=0.4)
    rows = []
    for name, law in laws.items():
        flights = []
        for seed in seeds:
            bench.progress(f"target lost, {name}: {seed}")
            start = 0.04 * round(np.random.default_rng([seed, 7]).uniform(0.2, 1.4) / 0.04)
            setting = Setting.of(placing(PlaceSettings(place=seed, duration_s=6.0), seed))
            setting = replace(setting, blind=(start - 1e-6, start + BLIND))
            flights.append(fly(setting, law, step=0.01))
        told = [1e3 * (_first(f, np.abs(f.V).max(axis=1) == 0) - f.setting.blind[0]) for f in flights]
        still = [1e3 * (_first(f, np.abs(f.rates).max(axis=1) < STILL) - f.setting.blind[0]) for f in flights]
        way = [_way(f) for f in flights]
        rows.append(
            (
                name,
                max(told),
                float(np.median(still)),
                max(still),
                1e3 * max(way),
                f"{sum(f.converged for f in flights)} of {len(flights)}",
                f"{sum(f.within_limits for f in flights)} of {len(flights)}",
            )
        )
    yield Table(
        f"Target lost for {BLIND:g} s on the way (place_by_showing), {len(seeds)} starts, geometry",
        ("law", "told to stop ms", "at rest ms", "worst", "way mm", "converged after", "within limits"),
        rows,
        note="From the first exposure that shows nothing: until the servo commands no motion (worst), until no set-point moves; way of the "
        "hand until then (worst).",
    )


def _first(flight: Flight, condition: np.ndarray) -> float:
    """First tick [s] after the loss at which the condition (n,) holds."""
    return float(flight.t[(flight.t >= flight.setting.blind[0]) & condition][0])


def _way(flight: Flight) -> float:
    """Way of the hand [m] during the loss."""
    blind = (flight.t >= flight.setting.blind[0]) & (flight.t < flight.setting.blind[1])
    return float(np.linalg.norm(np.diff(flight.X_WE[blind, :3, 3], axis=0), axis=1).sum())
