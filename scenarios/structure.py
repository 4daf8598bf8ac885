"""A robot's structure for reading: stages, wires and schedule."""

from pydrake.systems.framework import Diagram
from rich.console import Console
from rich.table import Table

OPENED = ("vipr.diagrams",)  # diagrams whose insides are shown; Drake's own stay closed


def structure(robot: Diagram) -> dict:
    """Stages with their ports, wires in the order they were made, and its schedule, periods and offsets [s].

    A stage of a diagram inside the robot is named ``diagram.stage``.
    """
    found = {"name": robot.get_name(), "stages": [], "wires": [], "schedule": []}
    _open(robot, "", found)
    found["schedule"].sort(key=lambda event: (event["offset_s"], event["period_s"]))
    return found


def _open(diagram: Diagram, prefix: str, found: dict) -> None:
    wires = diagram.connection_map().items()
    read = {(reader.get_name(), int(i)) for (reader, i), _ in wires}
    written = {(writer.get_name(), int(o)) for _, (writer, o) in wires}
    for system in diagram.GetSystems():
        name = prefix + system.get_name()
        found["stages"].append(
            {
                "name": name,
                "system": type(system).__name__,
                "inputs": _named(system, system.num_input_ports(), system.get_input_port, read),
                "outputs": _named(system, system.num_output_ports(), system.get_output_port, written),
            }
        )
        if type(system).__module__.startswith(OPENED):
            _open(system, f"{name}.", found)
        for stage, (period, offset) in getattr(system, "schedule", {}).items():
            found["schedule"].append({"stage": f"{name}.{stage}", "period_s": period, "offset_s": offset})
    for (reader, i), (writer, o) in wires:
        output, input_ = writer.get_output_port(o).get_name(), reader.get_input_port(i).get_name()
        found["wires"].append(f"{prefix}{writer.get_name()}.{output} -> {prefix}{reader.get_name()}.{input_}")


def _named(system, count: int, port, wired: set) -> list[str]:
    """Names of a system's ports; of a system of Drake's own (a plant has dozens) only those with a wire."""
    own = type(system).__module__.startswith("vipr.")
    return [port(i).get_name() for i in range(count) if own or (system.get_name(), i) in wired]


def print_structure(found: dict) -> None:
    """The structure as tables."""
    console = Console()
    table = Table(title=f"{found['name']}: stages")
    for column in ("stage", "system", "inputs", "outputs"):
        table.add_column(column, overflow="fold", no_wrap=column == "stage")
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
