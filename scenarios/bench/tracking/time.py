"""Time a frame takes: in all, by step, with the number of nodes and with the size of the image, and of a first frame. One thread."""

import inspect
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace

import cv2
import numpy as np

from vipr.scenarios.bench.tables import Table
from vipr.scenarios.bench.tracking.workbench import BOXES, RATE, UNPRINTED, WRONG_DEG, WRONG_MM, XC77, Workbench, wrong
from vipr.scenarios.sequences import trajectories
from vipr.scenarios.sequences.rendered import Conditions
from vipr.systems.camera.lens import Lens
from vipr.systems.tracking.belief import start
from vipr.systems.tracking.model_tracking import step
from vipr.systems.tracking.settings import TrackerSettings

REPEATS = 5
STEPS = 14  # shown
STARTS = 10
WHOLE = (start, step)


def run(bench: Workbench) -> Iterator[Table]:
    threads = cv2.getNumThreads()
    cv2.setNumThreads(1)
    try:
        yield from _tables(bench)
    finally:
        cv2.setNumThreads(threads)


def _tables(bench):
    length = 20 if bench.quick else 50
    objects = (*BOXES, BOXES[0] + UNPRINTED)
    frames = {name: _frames(bench, name, XC77, length) for name in objects}
    total = Table(
        "Processor time a frame at 640x480, ms",
        ("object", "nodes used", "median", "90 %", "best run's median"),
        note=f"Hand-held motion of up to 8 px a frame before clutter; {REPEATS} runs of {length} frames.",
    )
    for name in objects:
        bench.progress(f"time: {name}")
        runs = [bench.track(name, frames[name], count=False) for _ in range(REPEATS)]
        ms = np.array([r.ms[3:] for r in runs])
        used = int(np.median([b.nodes for b in runs[0].beliefs]))
        best = float(np.median(ms, axis=1).min())
        total.rows.append((name, used, float(np.median(ms)), float(np.percentile(ms, 90)), best))
    yield total
    name = BOXES[0]
    bench.progress("time: by step")
    with clocked() as spent:
        result = bench.track(name, frames[name] * 3, count=False)
    count, whole = len(result.ms), sum(result.ms)
    steps = Table("Time by step (with the clocks' own cost)", ("step", "calls a frame", "ms a frame", "share"))
    shown = sorted(spent.items(), key=lambda item: -item[1][1])[:STEPS]
    for function, (calls, seconds) in shown:
        steps.rows.append((function, calls / count, 1e3 * seconds / count, f"{1e3 * seconds / whole:.0%}"))
    rest = whole - 1e3 * sum(s for _, (_, s) in shown)
    steps.rows.append(("the rest", float("nan"), rest / count, f"{rest / whole:.0%}"))
    yield steps
    nodes = Table("Time with the number of nodes asked for, 640x480", ("nodes asked", "nodes used", "ms median"))
    for asked in (50, 100, 200, 400) if bench.quick else (50, 100, 200, 400, 800):
        bench.progress(f"time: {asked} nodes")
        settings = replace(TrackerSettings(), nodes=asked, spacing=0.5)
        result = bench.track(name, frames[name], settings, count=False)
        nodes.rows.append((asked, int(np.median([b.nodes for b in result.beliefs])), float(np.median(result.ms[3:]))))
    yield nodes
    sizes = Table(
        "Time with the size of the image, the same view, 200 nodes",
        ("image", "megapixels", "ms median"),
        note="Corners move by up to 8 px a frame at every size.",
    )
    for scale in (0.5, 1.0) if bench.quick else (0.5, 1.0, 2.0, 3.0):
        bench.progress(f"time: scale {scale:g}")
        lens = scaled(XC77, scale)
        seen = frames[name] if scale == 1.0 else _frames(bench, name, lens, 12 if bench.quick else 20)
        result = bench.track(name, seen, lens=lens, count=False)
        sizes.rows.append(
            (f"{lens.width}x{lens.height}", lens.width * lens.height / 1e6, float(np.median(result.ms[3:])))
        )
    yield sizes
    yield _first(bench, {name: frames[name] for name in BOXES})


def scaled(lens: Lens, scale: float) -> Lens:
    """The lens before a sensor with scale times as many pixels a side."""
    return Lens(
        round(lens.width * scale),
        round(lens.height * scale),
        lens.fx * scale,
        lens.fy * scale,
        (lens.cx + 0.5) * scale - 0.5,
        (lens.cy + 0.5) * scale - 0.5,
    )


def _frames(bench, name, lens, length):
    model = bench.model(name)
    moving = trajectories.hand_held(
        bench.at(name), model.corners, lens, seed=3, pixels_per_frame=8.0, duration=length / RATE, centre_O=model.centre
    )
    return bench.render(name, moving, length, Conditions(samples=2), lens=lens, seed=3)


def _first(bench, frames):
    """The first frame after a pose was given from outside."""
    table = Table(
        "Time of a first frame at 640x480, ms",
        ("object", "start", "median", "max"),
        note=f"{STARTS} frames each; a wrong start is {WRONG_MM:g} mm and {WRONG_DEG:g} degrees off.",
    )
    rng = np.random.default_rng(bench.seed)
    for name, seen in frames.items():
        chosen = seen[:: len(seen) // STARTS][:STARTS]
        centre = bench.model(name).centre
        for how, starts in (("right", [X for _, X in chosen]), ("wrong", [wrong(X, centre, rng) for _, X in chosen])):
            bench.progress(f"time: {name}, {how} starts")
            ms = [
                bench.track(name, [one], count=False, X_CO_start=X).ms[0] for one, X in zip(chosen, starts, strict=True)
            ]
            table.rows.append((name, how, float(np.median(ms)), max(ms)))
    return table


@contextmanager
def clocked():
    """{function: (calls, exclusive seconds)} of all functions of the tracker, while in the body."""
    spent, inner, originals = {}, [], {}

    def clock(name, function):
        def timed(*args, **kwargs):
            inner.append(0.0)
            begin = time.process_time()
            try:
                return function(*args, **kwargs)
            finally:
                took = time.process_time() - begin
                calls, seconds = spent.get(name, (0, 0.0))
                spent[name] = calls + 1, seconds + took - inner.pop()
                if inner:
                    inner[-1] += took

        return timed

    for module in [m for key, m in sys.modules.items() if key.startswith("vipr.systems.tracking.")]:
        for name, value in vars(module).items():
            if (
                inspect.isfunction(value)
                and value.__module__.startswith("vipr.systems.tracking")
                and value not in WHOLE
            ):
                originals[module, name] = value
    try:
        for (module, name), value in originals.items():
            setattr(module, name, clock(value.__name__.lstrip("_").replace("_", " "), value))
        yield spent
    finally:
        for (module, name), value in originals.items():
            setattr(module, name, value)
