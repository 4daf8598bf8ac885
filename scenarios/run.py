"""Runs a scenario: simulates it, shows its progress, and leaves its folder behind."""

import time
from pathlib import Path

import numpy as np
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder
from rich.console import Console
from rich.progress import BarColumn, Progress, TextColumn, TimeRemainingColumn

from vipr.scenarios.scenario import Scenario
from vipr.scenarios.settings import as_dict
from vipr.systems.recording.folder import RunFolder
from vipr.systems.recording.recorder import Recorder
from vipr.systems.timing import LEDGER

TICK = 0.04  # s, of the recorder
RECORD_OFFSET = 0.039  # s after the exposure: everything that the frame led to is there


def run_scenario(scenario: Scenario, folder: Path, *, video: bool = True) -> dict:
    """Run it to its end and return its summary; the folder is readable at any moment (see ``recording.folder``).

    Raises:
        InputError: for a folder that cannot be written, and for settings that the robot refuses.
        KeyboardInterrupt: after the folder is complete up to that moment.
    """
    robot = scenario.build()
    run = RunFolder(
        folder,
        scenario=scenario.name,
        seed=scenario.seed,
        channels=scenario.channels(),
        settings=as_dict(scenario.settings),
        plots=scenario.plots(),
        frames=scenario.frames(),
        rate=1.0 / TICK,
        video=video,
    )
    console = Console(stderr=True)
    with run:
        builder = DiagramBuilder()
        builder.AddNamedSystem("robot", robot)
        recorder = builder.AddNamedSystem(
            "recorder", Recorder(run.channels, run.record, period=TICK, offset=RECORD_OFFSET)
        )
        for channel in run.channels:
            builder.Connect(robot.GetOutputPort(channel.name), recorder.GetInputPort(channel.name))
        diagram = builder.Build()
        complaint = run.draw(robot)
        if complaint:
            console.print(complaint)
        simulator = Simulator(diagram)
        simulator.Initialize()
        LEDGER.reset()
        start = time.perf_counter()
        simulated = _advance(simulator, scenario, console)
        wall = time.perf_counter() - start
        outcome = scenario.judge(run.history())
        others = sum(LEDGER.seconds.values())
        return run.finish(
            success=outcome.success,
            reason=outcome.reason,
            figures=outcome.figures,
            limits=scenario.limits(),
            wall_s=wall,
            simulated_s=simulated,
            seconds={**LEDGER.seconds, "physics": max(wall - others, 0.0)},
        )


def _advance(simulator: Simulator, scenario: Scenario, console: Console) -> float:
    """To the scenario's end [s], which it returns, with a bar that tells simulated time and real-time factor."""
    robot, root = simulator.get_system().GetSubsystemByName("robot"), simulator.get_context()
    columns = (
        TextColumn("{task.description}"),
        BarColumn(),
        TextColumn("{task.completed:.1f} of {task.total:.1f} s simulated, real-time factor {task.fields[factor]:.2f}"),
        TimeRemainingColumn(),
    )
    with Progress(*columns, console=console, transient=True) as bar:
        task = bar.add_task(scenario.name, total=scenario.duration, factor=0.0)
        start = time.perf_counter()
        for end in np.append(np.arange(0.2, scenario.duration, 0.2), scenario.duration):
            simulator.AdvanceTo(end)
            bar.update(task, completed=end, factor=end / (time.perf_counter() - start))
            if scenario.over(robot, robot.GetMyContextFromRoot(root)):
                break
    return float(end)
