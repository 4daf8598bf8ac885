"""Fig. 11 of the paper: an object that turns a full 360 degrees about each axis of the camera, and that moves sideways."""

from collections.abc import Iterator

import numpy as np

from vipr.scenarios.bench.tables import Table
from vipr.scenarios.bench.tracking.workbench import BOXES, OFF, RATE, Frames, Workbench
from vipr.scenarios.sequences import trajectories
from vipr.scenarios.sequences.rendered import Conditions

EXPOSURE = 0.02  # s
NOTE = f"off but `tracking`: frames said to be tracked whose corners are off by more than {OFF:g} px RMS."
CONDITIONS = Conditions(exposure=EXPOSURE, samples=4)


def turn(bench: Workbench, name: str, axis: str, speed: float, degrees: float = 360.0) -> Frames:
    """An object turning about an axis of C at a speed [deg/s], before clutter."""
    moving = trajectories.turning(bench.at(name), axis, speed, centre_O=bench.model(name).centre)
    length = int(np.ceil((degrees / speed + 0.32) * RATE)) + 1
    return bench.render(name, moving, length, CONDITIONS, seed=int(speed))


def glide(bench: Workbench, name: str, speed: float, axis: int = 0) -> Frames:
    """An object swinging sideways (axis 0), up and down (1) or in depth (2) with a top speed [m/s], before clutter."""
    amplitude = np.zeros(3)
    amplitude[axis] = (0.18, 0.1, 0.3)[axis]
    moving = trajectories.swinging(bench.at(name), amplitude, speed)
    length = int(np.ceil((2 * np.pi * amplitude[axis] / speed + 0.4) * RATE)) + 1
    return bench.render(name, moving, length, CONDITIONS, seed=int(1000 * speed))


def run(bench: Workbench) -> Iterator[Table]:
    objects = BOXES[:1] if bench.quick else BOXES
    speeds = (90.0,)
    table = Table(
        f"Fig. 11: a full turn about each axis of the camera at {RATE:g} Hz, 2 m, before clutter, exposure {1e3 * EXPOSURE:g} ms",
        (
            "object",
            "axis",
            "deg/s",
            "frames",
            "followed",
            "deg median / max",
            "corner px median / max",
            "off but `tracking`",
        ),
    )
    for name in objects:
        for axis in "y" if bench.quick else "xyz":
            for speed in speeds:
                bench.progress(f"fig11: {name} about {axis} at {speed:g} deg/s")
                table.rows.append(_row(bench, name, axis, speed, turn(bench, name, axis, speed)))
    table.note = NOTE
    yield table
    table = Table(
        f"Swinging across (0.36 m) and in depth (0.6 m) at 2 m, before clutter, exposure {1e3 * EXPOSURE:g} ms; top speed",
        (
            "object",
            "axis",
            "m/s",
            "frames",
            "followed",
            "deg median / max",
            "corner px median / max",
            "off but `tracking`",
        ),
    )
    for name in objects:
        for axis in (0,):
            for speed in (0.4,):
                bench.progress(f"fig11: {name} along {'xyz'[axis]} at {speed:g} m/s")
                table.rows.append(_row(bench, name, "xyz"[axis], speed, glide(bench, name, speed, axis)))
    table.note = NOTE
    yield table


def _row(bench, name, axis, speed, frames):
    result = bench.track(name, frames)
    followed = "all" if result.survived else f"lost at {result.lost_at}"
    good = result.followed
    degrees, pixels = result.degrees[good], result.corner_px[good]
    return (
        name,
        axis,
        speed,
        len(frames),
        followed,
        f"{np.median(degrees):.2f} / {degrees.max():.2f}" if good.any() else "-",
        f"{np.median(pixels):.2f} / {pixels.max():.2f}" if good.any() else "-",
        int(result.off.sum()),
    )
