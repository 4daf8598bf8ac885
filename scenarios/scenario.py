"""What a scenario is: settings, a robot, what is logged of it, and a judgement."""

from abc import ABC, abstractmethod
from dataclasses import dataclass, field
from importlib.resources import files
from pathlib import Path
from typing import Any, ClassVar

import numpy as np
from pydrake.systems.framework import Context, Diagram, DiagramBuilder, LeafSystem

from vipr.systems.recording.channels import Channel
from vipr.systems.recording.history import History
from vipr.systems.recording.plots import Plot, PosePlot


@dataclass(frozen=True)
class Outcome:
    """How a run ended: every figure's name ends in its unit."""

    success: bool
    reason: str
    figures: dict[str, float] = field(default_factory=dict)


class Scenario(ABC):
    """One thing a robot does, from its settings and a seed; the same pair always does the same."""

    name: ClassVar[str]
    summary: ClassVar[str]  # one line for `vipr list`
    settings_type: ClassVar[type]

    def __init__(self, settings: Any, seed: int):
        self.settings, self.seed = settings, seed

    @classmethod
    def settings_file(cls) -> Path:
        """The YAML file of the scenario's values."""
        return Path(str(files("vipr.scenarios"))) / f"{cls.name}.yaml"

    @property
    @abstractmethod
    def duration(self) -> float:
        """Simulated time [s]."""

    def over(self, robot: Diagram, context: Context) -> bool:
        """Whether the run may end now, before its ``duration``; asked a few times a second."""
        return False

    @abstractmethod
    def build(self) -> Diagram:
        """The robot; every channel's port is exported under the channel's name."""

    def fed(self, robot: Diagram, sources: dict[str, LeafSystem]) -> Diagram:
        """The robot with its open inputs fed, by their names, and each of its outputs exported."""
        builder = DiagramBuilder()
        builder.AddNamedSystem("robot", robot)
        for name, source in sources.items():
            builder.AddNamedSystem(f"{name}_source", source)
            builder.Connect(source.get_output_port(), robot.GetInputPort(name))
        for i in range(robot.num_output_ports()):
            port = robot.get_output_port(i)
            builder.ExportOutput(port, port.get_name())
        diagram = builder.Build()
        diagram.set_name(self.name)
        return diagram

    @abstractmethod
    def channels(self) -> list[Channel]:
        """What the recorder takes down, each from the robot's output port of the same name."""

    @abstractmethod
    def plots(self) -> list[Plot | PosePlot]:
        """What the report draws of it."""

    def frames(self) -> dict[tuple[str, str], np.ndarray]:
        """Poses that never change, ``{(parent, child): X_PC}``, for the log."""
        return {}

    def limits(self) -> dict[str, float]:
        """What figures may reach at most, by their names, for the report."""
        return {}

    @abstractmethod
    def judge(self, history: History) -> Outcome:
        """The outcome of a run that reached its end, from what was taken down."""
