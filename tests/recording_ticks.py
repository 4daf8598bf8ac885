"""A run to record, for the tests of the recording stage: one channel of each kind, ticks to feed it, the folder it fills."""

import numpy as np

from vipr.systems.recording.channels import ImageChannel, JointChannel, PoseChannel, StatusChannel, VectorChannel
from vipr.systems.recording.folder import RunFolder
from vipr.systems.recording.plots import Line, Plot, PosePlot
from vipr.systems.se3 import exp
from vipr.systems.signals import CameraFrame, ObjectPose, Status

CHANNELS = (
    ImageChannel("camera", video=True),
    PoseChannel("X_CO", parent="camera", child="object", tracked=True),
    PoseChannel("X_CO_true", parent="camera", child="object_true"),
    VectorChannel("servo_error", names=("translation", "rotation"), units=("m", "rad")),
    JointChannel("q", joints=("waist", "shoulder"), velocities=True),
    StatusChannel("phase"),
)


def tick(k: int) -> dict:
    """What the channels carry at tick k of 25 a second."""
    X = exp(np.array([0.1, 0.02 * k, 0.05, 0.001 * k, 0.1, 2.0]))
    image = np.full((48, 64, 3), 5 * k % 256, np.uint8)
    return {
        "camera": CameraFrame(image=image, time=0.04 * k, number=k),
        "X_CO": ObjectPose(X_CO=X, state="lost" if k == 0 else "tracking", time=0.04 * k, nodes=90, residual_px=0.4),
        "X_CO_true": X,
        "servo_error": np.array([0.1 / (k + 1), 0.2]),
        "q": np.array([0.1 * k, 1.0, 2.5, 0.0]),
        "phase": Status("approach" if k < 5 else "hold"),
    }


PLOTS = (
    PosePlot("Object in camera", "X_CO", "X_CO_true", limits=(2, 0.5)),
    Plot("Servo error", "distance", "mm", (Line("servo_error.translation", "translation"),), scale=1000, limit=5),
)


def folder(path, **changes):
    """A run's folder with these channels, but for the changes."""
    return RunFolder(path, **({"scenario": "align", "seed": 1, "channels": CHANNELS} | changes))


def fill(run, ticks=20):
    """Record that many ticks."""
    for k in range(ticks):
        run.record(0.04 * k, tick(k))


def finished_folder(path):
    """The folder of a run that ended well."""
    with folder(path, plots=PLOTS, frames={("world", "camera"): np.eye(4)}) as run:
        fill(run)
        run.event(0.5, "scenario", "object starts to move")
        run.finish(success=True, reason="held the pose", figures={"final_translation_error_mm": 0.8})
    return path
