"""``vipr list``, ``vipr run`` and ``vipr show``: scenarios."""

import json
from pathlib import Path
from typing import Annotated

import typer

from vipr.systems.errors import InputError

Settings = Annotated[
    list[str], typer.Option("--set", metavar="KEY=VALUE", help="Change a setting, e.g. servo.gain=2; repeatable.")
]
AsJson = Annotated[
    bool, typer.Option("--json", help="Print what a program would read, and nothing else, on standard output.")
]


def register(app: typer.Typer) -> None:
    """Add the subcommands to the app."""
    app.command("list")(list_scenarios)
    app.command()(run)
    app.command()(show)


def list_scenarios(as_json: AsJson = False) -> None:
    """List the scenarios."""
    from vipr.scenarios.catalogue import SCENARIOS

    if as_json:
        print(json.dumps([{"name": name, "summary": scenario.summary} for name, scenario in SCENARIOS.items()]))
        return
    for name, scenario in SCENARIOS.items():
        print(f"{name:20s} {scenario.summary}")


def run(
    scenario: Annotated[str, typer.Argument(help="Name of the scenario; see `vipr list`.")],
    seed: Annotated[int, typer.Option(help="Everything random comes from it; 0 or larger.")] = 0,
    settings: Settings = [],  # noqa: B006 (typer copies it)
    out: Annotated[Path | None, typer.Option(help="Folder of the run; out/SCENARIO-seed-N if not given.")] = None,
    video: Annotated[bool, typer.Option("--video/--no-video", help="Write video.mp4.")] = True,
    as_json: AsJson = False,
) -> None:
    """Run a scenario and write its log, video and report. Exit code 0: it did its task; 1: it did not."""
    from vipr.scenarios.catalogue import find_scenario
    from vipr.scenarios.run import run_scenario
    from vipr.scenarios.settings import load_settings

    found = find_scenario(scenario)
    if seed < 0:
        raise InputError(f"--seed: must be 0 or larger, got {seed}")
    values = load_settings(found.settings_type, found.settings_file(), settings)
    folder = out or Path("out") / f"{scenario}-seed-{seed}"
    summary = run_scenario(found(values, seed), folder, video=video)
    if as_json:
        print(json.dumps(summary, indent=2))
    else:
        _print_summary(summary, folder)
    raise typer.Exit(0 if summary["success"] else 1)


def show(
    scenario: Annotated[str, typer.Argument(help="Name of the scenario; see `vipr list`.")],
    settings: Settings = [],  # noqa: B006 (typer copies it)
    out: Annotated[Path | None, typer.Option(help="Write the diagram's picture to this .svg file.")] = None,
    as_json: AsJson = False,
) -> None:
    """Show a scenario's robot: its stages, their wires and their schedule."""
    from vipr.scenarios.catalogue import find_scenario
    from vipr.scenarios.settings import load_settings
    from vipr.scenarios.structure import print_structure, structure

    found = find_scenario(scenario)
    robot = found(load_settings(found.settings_type, found.settings_file(), settings), 0).build()
    if as_json:
        print(json.dumps(structure(robot), indent=2))
    else:
        print_structure(structure(robot))
    if out:
        from vipr.systems.recording.diagram_picture import write_diagram

        write_diagram(robot, out)


def _print_summary(summary: dict, folder: Path) -> None:
    print(
        f"{summary['scenario']} seed {summary['seed']}: {'done' if summary['success'] else 'FAILED'}, {summary['reason']}"
    )
    for name, value in summary["figures"].items():
        print(f"  {name:36s} {value:10.4g}")
    time = summary["time"]
    shares = ", ".join(f"{name} {100 * share:.1f} %" for name, share in time["share"].items())
    print(f"  real-time factor {time['real_time_factor']:.2f}; wall time: {shares}")
    print(f"  {folder / 'report.html'}")
