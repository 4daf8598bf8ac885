"""Forced losses, and how soon they are reported; false alarms on frames that are followed well."""

from collections.abc import Iterator

import numpy as np

from vipr.scenarios.bench.tables import Table
from vipr.scenarios.bench.tracking.handheld import shaken
from vipr.scenarios.bench.tracking.workbench import BOXES, RATE, Workbench
from vipr.scenarios.sequences import trajectories
from vipr.scenarios.sequences.rendered import Conditions
from vipr.systems import se3
from vipr.systems.signals import CameraFrame
from vipr.systems.tracking.belief import start
from vipr.systems.tracking.model_tracking import step
from vipr.systems.tracking.settings import TrackerSettings

KINDS = ("teleported", "hidden", "dark", "swapped")
BEFORE, AFTER = 10, 6  # frames
NOTICED = 2  # frames within which a loss should be noticed


def forced_loss(bench: Workbench, kind: str, seed: int):
    """(object, frames with their truth): BEFORE good frames, then AFTER frames in which the pose cannot be right.

    teleported: the object jumps by 0.12 to 0.25 m and turns by 60 to 180 degrees; hidden: it is gone; dark: the lights go out;
    swapped: another object takes its place. Truth is None where the object is not there.
    """
    rng = np.random.default_rng([bench.seed, seed])
    name, other = BOXES[seed % 2], BOXES[(seed + 1) % 2]
    X_CO = bench.at(name, place=(*rng.uniform(-0.05, 0.05, 2), 2.0))
    centre = bench.model(name).centre
    before = trajectories.hand_held(
        X_CO,
        bench.model(name).corners,
        bench.lens,
        seed=bench.seed + seed,
        pixels_per_frame=6.0,
        duration=1.0,
        centre_O=centre,
    )
    conditions = Conditions(exposure=0.01, samples=4)
    frames = bench.render(name, before, BEFORE, conditions, seed=seed)
    after = before
    if kind == "teleported":
        side = rng.uniform(0, 2 * np.pi)
        shift = rng.uniform(0.12, 0.25) * np.array([np.cos(side), 0.6 * np.sin(side), 0.0])
        axis = rng.normal(size=3)
        w = axis / np.linalg.norm(axis) * rng.uniform(np.pi / 3, np.pi)
        after = lambda t: trajectories.displaced(before(t), w, shift, centre)  # noqa: E731
    elif kind == "hidden":
        after = lambda t: None  # noqa: E731
    elif kind == "swapped":
        other_centre = bench.model(other).centre
        after = lambda t: before(t) @ se3.pose(np.eye(3), centre - other_centre)  # noqa: E731

    shown = other if kind == "swapped" else name
    shape = (bench.lens.height, bench.lens.width)
    for k in range(BEFORE, BEFORE + AFTER):
        t = k / RATE
        if kind == "dark":
            noise = np.random.default_rng([seed, k]).normal(2.0, 2.0, shape)
            frames.append((CameraFrame(np.clip(np.rint(noise), 0, 255).astype(np.uint8), t, k), None))
        else:
            ((frame, _),) = bench.render(shown, lambda s, t=t: after(t + s), 1, conditions, seed=1000 * seed + k)
            frames.append((CameraFrame(frame.image, t, k), after(t) if kind == "teleported" else None))
    return name, frames


def run(bench: Workbench) -> Iterator[Table]:
    count = 3 if bench.quick else 30
    table = Table(
        f"Forced losses: frames until the tracker no longer says `tracking`, {count} of each",
        (
            "loss",
            "events",
            f"noticed within {NOTICED}",
            "within 1",
            "later",
            "never",
            "found again",
            "lost said (of 6 frames)",
        ),
        note="found again: the tracker is on the object at its new place within the 6 frames, which counts as noticed.",
    )
    for kind in KINDS:
        delays, again, lost = [], 0, []
        for seed in range(count):
            bench.progress(f"loss: {kind} {seed + 1}/{count}")
            name, frames = forced_loss(bench, kind, seed)
            delay, found, said = _watch(bench, name, frames)
            delays.append(0 if found else delay)
            again += found
            lost.append(said)
        delays = np.array(delays, float)
        table.rows.append(
            (
                kind,
                count,
                f"{(delays <= NOTICED).mean():.1%}",
                f"{(delays <= 1).mean():.1%}",
                int(((delays > NOTICED) & np.isfinite(delays)).sum()),
                int(np.isinf(delays).sum()),
                again,
                f"{np.mean(lost):.1%}",
            )
        )
    yield table
    if bench.good_frames[0] < 300:
        for seed in range(1 if bench.quick else 6):
            bench.progress(f"loss: good frames, seed {seed}")
            bench.track(BOXES[seed % 2], shaken(bench, BOXES[seed % 2], 300 + seed, 10.0, 100))
    total, uncertain, lost = bench.good_frames
    yield Table(
        "False alarms: frames followed within 5 px RMS, in all runs of this benchmark so far with the settings as they are",
        ("good frames", "said to be lost", "said to be uncertain"),
        [(total, f"{lost} ({lost / max(total, 1):.2%})", f"{uncertain} ({uncertain / max(total, 1):.2%})")],
    )


def _watch(bench, name, frames):
    """(frames until the state is not tracking, whether the object was found again, share of frames said to be lost)."""
    model, settings = bench.model(name), TrackerSettings()
    belief, delay, said, found = None, np.inf, [], False
    for k, (frame, X_CO) in enumerate(frames):
        belief = belief or start(X_CO, frame.time)
        belief = step(belief, frame.image, frame.time, model, bench.lens, settings, number=frame.number)
        if k < BEFORE:
            continue
        said.append(belief.state == "lost")
        if belief.state != "tracking":
            delay = min(delay, k - BEFORE + 1)
        elif X_CO is not None:
            p = [bench.lens.project(model.corners @ X[:3, :3].T + X[:3, 3]) for X in (belief.X_CO, X_CO)]
            found |= bool(np.sqrt(np.mean(np.sum((p[0] - p[1]) ** 2, axis=1))) < 10.0)
    return delay, found, float(np.mean(said))
