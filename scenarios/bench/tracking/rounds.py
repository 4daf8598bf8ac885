"""Printed can, mug and bottle, from starts that are wrong: a band of print beside a rim must not be taken for the rim."""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from vipr.scenarios.bench.tables import Table
from vipr.scenarios.bench.tracking.workbench import OFF, RATE, ROUNDS, WRONG_DEG, WRONG_MM, Run, Workbench, wrong
from vipr.scenarios.sequences import trajectories
from vipr.scenarios.sequences.rendered import Conditions
from vipr.systems import se3
from vipr.systems.tracking.settings import TrackerSettings

FAR_MM = 8.0  # depth by which a pose is wrong
FRAMES = 10
VARIANTS = {"": TrackerSettings(), ", no rivals": replace(TrackerSettings(), rivals=False)}


def standing(rng: np.random.Generator) -> tuple[np.ndarray, np.ndarray]:
    """Rotation, and place of the centre in C [m], of an object that stands; seen from 5 to 40 degrees above, 1.6 to 2.4 m away."""
    above, yaw, roll = np.radians(rng.uniform(5.0, 40.0)), rng.uniform(-np.pi, np.pi), 0.05 * rng.normal()
    turn = np.eye(3)
    for rotation in ([0, 0, roll], [above, 0, 0], [0.5 * np.pi, 0, 0], [0, 0, yaw]):
        turn = turn @ se3.exp_so3(np.array(rotation, float))
    return turn, np.array([*rng.uniform(-0.15, 0.15, 2) * (1.0, 0.7), rng.uniform(1.6, 2.4)])


def run(bench: Workbench) -> Iterator[Table]:
    count = 2 if bench.quick else 40
    table = Table(
        f"Round objects: {count} places of each, moving by at most 2 px a frame, starts {WRONG_MM:g} mm and {WRONG_DEG:g} degrees wrong",
        (
            "object",
            "`tracking`",
            f"> {OFF:g} px off",
            f"> {FAR_MM:g} mm",
            "corner px median / 90 %",
            "depth mm median / 90 % / max",
            "axis deg median / 90 %",
            "depth told mm",
            "error / told, 90 %",
        ),
        note=f"The state of frame {FRAMES}; the figures are of those that say `tracking` there. Every other one before clutter.",
    )
    for name in ROUNDS:
        model, found = bench.model(name), {variant: [] for variant in VARIANTS}
        for k in range(count):
            bench.progress(f"rounds: {name} {k + 1}/{count}")
            rng = np.random.default_rng([bench.seed, k, len(name)])
            turn, place = standing(rng)
            X_CO = bench.at(name, turn=turn, place=place)
            moving = trajectories.hand_held(
                X_CO,
                model.corners,
                bench.lens,
                seed=bench.seed + k,
                pixels_per_frame=2.0,
                duration=FRAMES / RATE,
                centre_O=model.centre,
            )
            background = "clutter" if k % 2 else "plain"
            shown = Conditions(samples=1, finer=4)
            frames = bench.render(name, moving, FRAMES, shown, background=background, seed=k)
            X_CO_start = wrong(frames[0][1], model.centre, rng)
            for variant, settings in VARIANTS.items():
                found[variant].append(_last(bench.track(name, frames, settings, X_CO_start=X_CO_start)))
        table.rows += [(name + variant, *_figures(np.array(rows))) for variant, rows in found.items()]
    yield table


def _figures(rows):
    """The figures of a row of the table from what ``_last`` says of each run."""
    px, mm, deg, told = rows[rows[:, 0] > 0, 1:].T
    if not len(px):
        return f"0 of {len(rows)}", 0, 0, *["-"] * 5
    return (
        f"{len(px)} of {len(rows)}",
        int((px > OFF).sum()),
        int((mm > FAR_MM).sum()),
        "{:.2f} / {:.2f}".format(*np.percentile(px, [50, 90])),
        "{:.1f} / {:.1f} / {:.1f}".format(*np.percentile(mm, [50, 90, 100])),
        "{:.2f} / {:.2f}".format(*np.percentile(deg, [50, 90])),
        f"{np.median(told):.1f}",
        f"{np.percentile(mm / told, 90):.1f}",
    )


def _last(result: Run):
    """Whether the last frame is tracked, and its errors: px, mm of depth, degrees, and mm told."""
    tracked = result.beliefs[-1].state == "tracking"
    return tracked, result.corner_px[-1], abs(result.millimetres[-1, 2]), result.degrees[-1], result.depth_told[-1]
