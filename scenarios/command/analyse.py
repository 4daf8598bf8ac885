"""``vipr analyse NAME``: what theory says of a loop, so that its gain is chosen and not guessed."""

from pathlib import Path
from typing import Annotated

import typer


def register(app: typer.Typer) -> None:
    """Add ``analyse`` to the app."""
    group = typer.Typer(help="Poles, margins and step responses of a loop.", no_args_is_help=True)
    app.add_typer(group, name="analyse")
    group.command("servo")(servo)


def servo(
    gain: Annotated[list[float], typer.Option(help="A gain, 1/s; repeatable.")] = [0.5, 1, 2, 4, 8, 16],  # noqa: B006
    latency: Annotated[
        list[float], typer.Option(help="A latency from exposure to the servo's tick, ms; repeatable.")
    ] = [0, 22, 40, 80, 120, 200, 400],  # noqa: B006 (typer copies it)
    out: Annotated[Path, typer.Option(help="Folder for servo.png.")] = Path("out/analyse-servo"),
    as_json: Annotated[bool, typer.Option("--json", help="Print the tables as JSON.")] = False,
) -> None:
    """The visual servo loop of the workcell, linearised about the goal: stability and speed against gain and latency."""
    from vipr.scenarios.bench.tables import print_json, print_tables
    from vipr.scenarios.command.output import output_folder
    from vipr.scenarios.servo_analysis import draw, tables

    latencies = [1e-3 * value for value in latency]
    results = tables(gain, latencies)
    picture = output_folder(out) / "servo.png"
    draw(picture, gain, latencies)
    if as_json:
        print_json(results)
    else:
        print_tables(results)
        print(f"picture: {picture}")
