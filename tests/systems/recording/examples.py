"""Examples of the recording stage's systems, for the laws."""

from pydrake.math import RigidTransform
from recording_ticks import CHANNELS, tick

from vipr.systems.recording.recorder import Recorder


def fix_tick(recorder, context, k: int) -> None:
    """Fix the recorder's ports at tick k."""
    for name, value in tick(k).items():
        value = RigidTransform(value) if name == "X_CO_true" else value
        recorder.GetInputPort(name).FixValue(context, value)


def recorder(record=lambda time, values: None):
    system = Recorder(CHANNELS, record)
    return system, lambda context, t: fix_tick(system, context, round(t / 0.04))


EXAMPLES = {Recorder: recorder}
