"""Examples of the recording stage's systems, for the laws."""

import numpy as np
from pydrake.math import RigidTransform

from vipr.systems.recording.channels import ImageChannel, JointChannel, PoseChannel, StatusChannel, VectorChannel
from vipr.systems.recording.recorder import Recorder
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
    X = exp(np.array([0.1, 0.02 * k, 0, 0.001 * k, 0, 2.0]))
    image = np.full((48, 64, 3), 5 * k % 256, np.uint8)
    return {
        "camera": CameraFrame(image=image, time=0.04 * k, number=k),
        "X_CO": ObjectPose(X_CO=X, state="lost" if k == 0 else "tracking", time=0.04 * k, nodes=90, residual_px=0.4),
        "X_CO_true": X,
        "servo_error": np.array([0.1 / (k + 1), 0.2]),
        "q": np.array([0.1 * k, 1.0, 2.5, 0.0]),
        "phase": Status("approach" if k < 5 else "hold"),
    }


def fix_tick(recorder, context, k: int) -> None:
    """Fix the recorder's ports at tick k."""
    for name, value in tick(k).items():
        value = RigidTransform(value) if name == "X_CO_true" else value
        recorder.GetInputPort(name).FixValue(context, value)


def recorder(record=lambda time, values: None):
    system = Recorder(CHANNELS, record)
    return system, lambda context, t: fix_tick(system, context, round(t / 0.04))


EXAMPLES = {Recorder: recorder}
