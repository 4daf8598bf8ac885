"""``vipr bench NAME``: the benchmarks whose tables stand in the README."""

from pathlib import Path
from typing import Annotated

import typer

# Benchmarks that print tables (``vipr.scenarios.bench.benchmark``): what each measures, and its parts, told without importing it.
TABLES = {
    "tracking": (
        "The model-based tracker: accuracy, speed, disturbances, losses, recordings, time.",
        "accuracy, rounds, fig11, parts, handheld, disturbance, loss, recordings, time",
    ),
    "servo": (
        "Visual servoing: laws from many starts, hard cases, wrong calibration, following, lost targets, rendered runs.",
        "starts, hard, calibration, following, loss, rendered, pursuit",
    ),
    "people": (
        "Seeing people: Table I row by row, rendered rooms, changing light, real clips and variants of them, skin pixels.",
        "time, rooms, light, clips, variants, pixels",
    ),
    "gestures": (
        "Gesture models: correctness and speed beside hmmlearn, real handwriting, real pauses.",
        "likelihoods, speed, gaps, handwriting, phases",
    ),
    "arm": (
        "The arm: clearance against the real model's distances, limits under wild twists, stopping, time.",
        "clearance, limits, stopping, time",
    ),
    "calibration": (
        "vipr calibrate over many seeds: errors against truth beside the standard errors that it tells.",
        "errors, views",
    ),
}


def register(app: typer.Typer) -> None:
    """Add ``bench`` and its benchmarks to the app."""
    group = typer.Typer(help="Measure a stage; the tables of the README.", no_args_is_help=True)
    app.add_typer(group, name="bench")
    group.command("align")(align)
    group.command("runs")(runs)
    group.command("grasp")(grasp)
    for name, (summary, parts) in TABLES.items():
        group.command(name, help=summary)(_tables_command(name, parts))


def align(
    seeds: Annotated[int, typer.Option(help="How many seeds, from 1.", min=1)] = 20,
    settings: Annotated[
        list[str], typer.Option("--set", metavar="KEY=VALUE", help="A setting of the scenario; repeatable.")
    ] = [],  # noqa: B006 (typer copies it)
    out: Annotated[Path, typer.Option(help="Folder of the runs.")] = Path("out/bench-align"),
    jobs: Annotated[int, typer.Option(help="Runs at a time; one core each.", min=1)] = 1,
    as_json: Annotated[bool, typer.Option("--json", help="Print the summaries as JSON.")] = False,
) -> None:
    """The first loop, ``vipr run align``, over many seeds: errors against truth, and where the time goes."""
    import json

    from vipr.scenarios.bench.align import print_table, run

    summaries = run(seeds, settings, out, jobs)
    if as_json:
        print(json.dumps(summaries, indent=2))
    else:
        print_table(summaries)


def runs(
    scenario: Annotated[str, typer.Argument(help="Name of the scenario; see `vipr list`.")],
    seeds: Annotated[int, typer.Option(help="How many seeds.", min=1)] = 10,
    first: Annotated[int, typer.Option(help="The first seed.", min=0)] = 1,
    settings: Annotated[
        list[str], typer.Option("--set", metavar="KEY=VALUE", help="A setting of the scenario; repeatable.")
    ] = [],  # noqa: B006 (typer copies it)
    out: Annotated[Path | None, typer.Option(help="Folder of the runs; out/bench-SCENARIO if not given.")] = None,
    jobs: Annotated[int, typer.Option(help="Runs at a time; one core each.", min=1)] = 1,
    as_json: Annotated[bool, typer.Option("--json", help="Print the table as JSON.")] = False,
) -> None:
    """Any scenario over many seeds: every figure's median, mean, least and greatest."""
    from vipr.scenarios.bench.runs import run
    from vipr.scenarios.bench.tables import print_json, print_tables

    folder = out or Path("out") / f"bench-{scenario}"
    table = run(scenario, range(first, first + seeds), settings, folder, jobs)
    (print_json if as_json else print_tables)([table])


def grasp(
    trials: Annotated[int, typer.Option(help="Placements, over all objects in turn.", min=1)] = 200,
    only: Annotated[
        str, typer.Option(help="Parts, with commas between: placements, errors, choices, physics, switch.")
    ] = "",
    seed: Annotated[int, typer.Option(help="Seed of the first placement.", min=0)] = 20000,
    settings: Annotated[
        list[str], typer.Option("--set", metavar="KEY=VALUE", help="A setting of `pick`; repeatable.")
    ] = [],  # noqa: B006 (typer copies it)
    jobs: Annotated[int, typer.Option(help="Picks at a time; one core each.", min=1)] = 1,
    kept: Annotated[
        Path | None,
        typer.Option("--keep", help="File of picks: what is done is added, what is there is not done again."),
    ] = None,
    as_json: Annotated[bool, typer.Option("--json", help="Print the tables as JSON.")] = False,
) -> None:
    """Picks of random placements: held, slip, tilt; with errors of the pose, without parts of the robot, with finer physics."""
    from rich.console import Console

    from vipr.scenarios.bench.grasp import run
    from vipr.scenarios.bench.tables import print_json, print_tables

    console = Console(stderr=True, soft_wrap=True)
    tell = console.print if not console.is_terminal else console.log
    wanted = [part.strip() for part in only.split(",") if part.strip()]
    (print_json if as_json else print_tables)(run(trials, wanted, seed, jobs, settings, kept, tell))


def _tables_command(name: str, parts: str):
    """The command of one of `TABLES`."""

    def bench(
        quick: Annotated[
            bool, typer.Option("--quick", help="A small share of the runs: minutes instead of an hour.")
        ] = False,
        only: Annotated[str, typer.Option(help=f"Parts, with commas between: {parts}.")] = "",
        data: Annotated[
            Path | None,
            typer.Option(envvar="VIPR_DATA", help="Folder of recordings; parts that need it are left out without it."),
        ] = None,
        seed: Annotated[
            int | None, typer.Option(help="Seed of everything random; the benchmark's own if not given.")
        ] = None,
        jobs: Annotated[
            int, typer.Option(help="Rendered scenes and runs at a time, where a part can; one core each.", min=1)
        ] = 1,
        as_json: Annotated[bool, typer.Option("--json", help="Print the tables as JSON.")] = False,
    ) -> None:
        from vipr.scenarios.bench.benchmark import measure
        from vipr.scenarios.bench.tables import print_json, print_tables
        from vipr.scenarios.command.output import progress_line

        wanted = [part.strip() for part in only.split(",") if part.strip()]
        with progress_line(f"bench {name}") as tell:
            tables = measure(name, wanted, quick=quick, data=data, seed=seed, progress=tell, jobs=jobs)
            (print_json if as_json else print_tables)(tables)

    return bench
