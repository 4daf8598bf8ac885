"""Disturbances one by one, on the same moderate hand-held motion."""

from collections.abc import Iterator

import numpy as np

from vipr.scenarios.bench.tables import Table
from vipr.scenarios.bench.tracking.workbench import BOXES, OFF, RATE, Workbench
from vipr.scenarios.sequences import trajectories
from vipr.scenarios.sequences.rendered import Conditions, hand_motion, hidden_share

SPEED = 8.0  # px a frame
BLUR = 10.0  # px
KINDS = {
    "none, plain background": ("plain", {}),
    "cluttered background": ("clutter", {}),
    "half hidden by a hand": ("clutter", {"hand": "half"}),
    "light falls by 50 % in 0.12 s, returns": ("clutter", {"light_change": 0.5}),
    f"motion blur of {BLUR:g} px": ("clutter", {"exposure": BLUR / SPEED / RATE}),
    "1 frame in 5 dropped": ("clutter", {"drop_every": 5}),
    "all of these": (
        "clutter",
        {"hand": "half", "light_change": 0.5, "exposure": BLUR / SPEED / RATE, "drop_every": 5},
    ),
}


def run(bench: Workbench) -> Iterator[Table]:
    seeds, length = (range(1), 30) if bench.quick else (range(4), 75)
    table = Table(
        f"Disturbances: hand-held motion of up to {SPEED:g} px a frame at 2 m, noise 2 grey levels",
        (
            "disturbance",
            "runs followed",
            "frames followed",
            "corner px median / 90 %",
            "deg median / 90 %",
            "uncertain",
            "lost",
            "off but `tracking`",
        ),
    )
    hidden = []
    for kind, (background, options) in KINDS.items():
        runs = []
        for seed in seeds:
            name = BOXES[seed % 2]
            bench.progress(f"disturbance: {kind}, {name}, seed {seed}")
            corners = bench.model(name).corners
            # Blur is that of the fastest corner: the exposure may be longer than a frame takes, as a slow shutter's trail.
            moving = trajectories.hand_held(
                bench.at(name),
                corners,
                bench.lens,
                seed=bench.seed + 50 + seed,
                pixels_per_frame=SPEED,
                duration=length / RATE,
                centre_O=bench.model(name).centre,
            )
            conditions = Conditions(samples=4, **options)
            frames = bench.render(name, moving, length, conditions, background=background, seed=50 + seed)
            runs.append(bench.track(name, frames))
            if options == {"hand": "half"}:
                renderer = bench.renderer(background, bench.lens)
                hand = hand_motion(renderer, name, moving, "half", length / RATE)
                middle = 0.5 * length / RATE
                hidden.append(hidden_share(renderer, name, moving(middle), hand(middle)))
        frames = np.concatenate([r.followed for r in runs])
        px, deg = (
            np.concatenate([v[r.followed] for r, v in zip(runs, values, strict=True)])
            for values in ([r.corner_px for r in runs], [r.degrees for r in runs])
        )
        seen = np.concatenate([np.array(r.arrived) for r in runs])
        table.rows.append(
            (
                kind,
                f"{sum(r.survived for r in runs)} of {len(runs)}",
                f"{frames.mean():.1%}",
                "{:.2f} / {:.2f}".format(*np.percentile(px, [50, 90])) if len(px) else "-",
                "{:.2f} / {:.2f}".format(*np.percentile(deg, [50, 90])) if len(deg) else "-",
                f"{np.concatenate([r.states('uncertain') for r in runs])[seen].mean():.1%}",
                f"{np.concatenate([r.states('lost') for r in runs])[seen].mean():.1%}",
                int(sum(r.off.sum() for r in runs)),
            )
        )
    table.note = (
        f"The hand hides {np.mean(hidden):.0%} of the object's area. States are of frames that arrived; "
        f"off: corners by more than {OFF:g} px RMS."
    )
    yield table
