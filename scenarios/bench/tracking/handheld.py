"""An object carried and shaken by hand before clutter, corners moving by up to 18 px a frame, with the blur of a 20 ms exposure."""

from collections.abc import Iterator

import numpy as np

from vipr.scenarios.bench.tables import Table
from vipr.scenarios.bench.tracking.workbench import BOXES, OFF, RATE, Frames, Workbench
from vipr.scenarios.sequences import trajectories
from vipr.scenarios.sequences.rendered import Conditions

SPEED = 18.0  # px a frame


def shaken(bench: Workbench, name: str, seed: int, speed: float = SPEED, frames: int = 100, **conditions) -> Frames:
    """Frames of an object held by fingers, carried and shaken so that its fastest corner moves by speed [px] in one frame."""
    rng = np.random.default_rng([bench.seed, seed])
    X_CO = bench.at(name, place=(*rng.uniform(-0.04, 0.04, 2), 2.0))
    moving = trajectories.hand_held(
        X_CO,
        bench.model(name).corners,
        bench.lens,
        seed=bench.seed + seed,
        pixels_per_frame=speed,
        duration=frames / RATE,
        centre_O=bench.model(name).centre,
    )
    shown = Conditions(**{"exposure": 0.02, "hand": "holding", "samples": 3, **conditions})
    return bench.render(name, moving, frames, shown, seed=seed)


def run(bench: Workbench) -> Iterator[Table]:
    seeds, length = (range(2), 50) if bench.quick else (range(20), 75)
    table = Table(
        f"Hand-held: corners up to {SPEED:g} px a frame, exposure 20 ms, clutter, fingers before the object, {length} frames",
        (
            "seed",
            "object",
            "followed",
            "corner px median / 90 % / max",
            "deg median / 90 % / max",
            "uncertain",
            "lost",
            "off",
        ),
        note=f"off: frames said to be tracked whose corners are off by more than {OFF:g} px RMS.",
    )
    survived, off, all_px, all_deg = 0, 0, [], []
    for seed in seeds:
        name = BOXES[seed % 2]
        bench.progress(f"handheld: seed {seed + 1} of {len(seeds)}")
        result = bench.track(name, shaken(bench, name, seed, frames=length))
        survived += result.survived
        off += int(result.off.sum())
        good = result.followed
        all_px += list(result.corner_px[good])
        all_deg += list(result.degrees[good])
        followed = "all" if result.survived else f"lost at {result.lost_at}"
        spread = [_spread(values[good]) for values in (result.corner_px, result.degrees)]
        counts = int(result.states("uncertain").sum()), int(result.states("lost").sum()), int(result.off.sum())
        table.rows.append((bench.seed + seed, name, followed, *spread, *counts))
    table.rows.append(
        ("all", "", f"{survived} of {len(seeds)}", _spread(np.array(all_px)), _spread(np.array(all_deg)), "", "", off)
    )
    yield table


def _spread(values):
    return " / ".join(f"{v:.2f}" for v in (*np.percentile(values, [50, 90]), values.max())) if len(values) else "-"
