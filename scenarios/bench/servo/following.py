"""Keeping a pose to an object that moves at 0.1 m/s and turns at 20 degrees/s, with and without feed-forward."""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from vipr.scenarios.align import Follow
from vipr.scenarios.bench.benchmark import Bench
from vipr.scenarios.bench.servo.starts import rms
from vipr.scenarios.bench.servo.trial import LAWS, Setting, fly
from vipr.scenarios.bench.tables import Table
from vipr.scenarios.settings import load_settings


def run(bench: Bench) -> Iterator[Table]:
    settings = load_settings(Follow.settings_type, Follow.settings_file())
    scenarios = [Follow(settings, seed) for seed in bench.seeds(10, 2)]
    rows = []
    for name in ("position-based", "image-based, current L", "2.5D"):
        for feed_forward in (True, False):
            bench.progress(f"following, {name}, feed-forward {feed_forward}")
            law = replace(LAWS[name], gain=settings.servo.gain, feed_forward=feed_forward)
            flights = [fly(Setting.of(scenario), law) for scenario in scenarios]
            windows = [s.windows(f.t)["following"] for s, f in zip(scenarios, flights, strict=True)]
            mm, deg = ([getattr(f, u)[w] for f, w in zip(flights, windows, strict=True)] for u in ("mm", "deg"))
            rows.append(
                (
                    name,
                    "yes" if feed_forward else "no",
                    float(np.median([rms(e) for e in mm])),
                    max(rms(e) for e in mm),
                    max(float(e.max()) for e in mm),
                    float(np.median([rms(e) for e in deg])),
                    max(rms(e) for e in deg),
                    max(float(e.max()) for e in deg),
                    f"{sum(f.within_limits for f in flights)} of {len(flights)}",
                )
            )
    s = settings
    yield Table(
        f"Following an object at {s.object_speed_m_s:g} m/s and {s.object_turn_deg_s:g} deg/s (follow), {len(scenarios)} starts, geometry",
        ("law", "feed-forward", "RMS mm", "worst", "largest", "RMS deg", "worst ", "largest ", "within limits"),
        rows,
        note="RMS while the object moves, its starts and stops included: median and worst of the runs; largest: at any tick of any run.",
    )
