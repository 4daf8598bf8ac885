"""Recorded frames played to stages: a system that takes frames, driven at the rate of a recording."""

from typing import Any

from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import System

from vipr.systems.errors import InputError
from vipr.systems.signals import CameraFrame


class Playback:
    """Plays frames to a system with an input port ``frame`` and reads its outputs after each.

    ``period`` [s] is the recording's; the system's own ticks must come between 0 and 0.9 of a period after each frame.
    """

    READ = 0.95  # of a period after the frame

    def __init__(self, system: System, outputs: tuple[str, ...], period: float):
        for kind, name, there in (
            ("input", "frame", system.HasInputPort("frame")),
            *(("output", name, system.HasOutputPort(name)) for name in outputs),
        ):
            if not there:
                raise InputError(f"{type(system).__name__} has no {kind} port {name!r}")
        self._period, self._outputs = period, outputs
        self._simulator = Simulator(system)
        self._frames = 0

    def show(self, frame: CameraFrame) -> dict[str, Any]:
        """What the outputs are after this frame, by name."""
        system, context = self._simulator.get_system(), self._simulator.get_mutable_context()
        system.GetInputPort("frame").FixValue(context, frame)
        self._simulator.AdvanceTo((self._frames + self.READ) * self._period)
        self._frames += 1
        return {name: system.GetOutputPort(name).Eval(context) for name in self._outputs}
