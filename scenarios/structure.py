"""A robot's structure for reading: stages, wires and schedule."""

from pydrake.systems.framework import Diagram, System
from rich.console import Console
from rich.table import Table


def structure(robot: Diagram) -> dict:
    """Stages with their ports, wires in the order they were made, and periodic events with period and offset [s]."""
    stages, events = [], []
    for system in robot.GetSystems():
        stages.append(
            {
                "name": system.get_name(),
                "system": type(system).__name__,
                "inputs": [system.get_input_port(i).get_name() for i in range(system.num_input_ports())],
                "outputs": [system.get_output_port(i).get_name() for i in range(system.num_output_ports())],
            }
        )
        for timing in _timings(system):
            events.append({"stage": system.get_name(), **timing})
    wires = [
        f"{writer.get_name()}.{writer.get_output_port(o).get_name()} -> {reader.get_name()}.{reader.get_input_port(i).get_name()}"
        for (reader, i), (writer, o) in robot.connection_map().items()
    ]
    events.sort(key=lambda event: (event["offset_s"], event["period_s"]))
    return {"name": robot.get_name(), "stages": stages, "wires": wires, "schedule": events}


def _timings(system: System) -> list[dict]:
    found = system.MapPeriodicEventsByTiming()
    return [{"period_s": data.period_sec(), "offset_s": data.offset_sec()} for data in found]


def print_structure(found: dict) -> None:
    """The structure as tables."""
    console = Console()
    table = Table(title=f"{found['name']}: stages")
    for column in ("stage", "system", "inputs", "outputs"):
        table.add_column(column)
    for stage in found["stages"]:
        table.add_row(stage["name"], stage["system"], ", ".join(stage["inputs"]), ", ".join(stage["outputs"]))
    console.print(table)
    console.print("[bold]wires[/bold]")
    for wire in found["wires"]:
        console.print(f"  {wire}", highlight=False)
    table = Table(title="schedule")
    for column in ("stage", "period ms", "offset ms"):
        table.add_column(column, justify="left" if column == "stage" else "right")
    for event in found["schedule"]:
        table.add_row(event["stage"], f"{1e3 * event['period_s']:g}", f"{1e3 * event['offset_s']:g}")
    console.print(table)
