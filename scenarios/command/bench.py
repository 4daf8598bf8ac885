"""``vipr bench NAME``: the benchmarks whose tables stand in the README."""

from pathlib import Path
from typing import Annotated

import typer


def register(app: typer.Typer) -> None:
    """Add ``bench`` and its benchmarks to the app."""
    group = typer.Typer(help="Measure a stage; the tables of the README.", no_args_is_help=True)
    app.add_typer(group, name="bench")
    # One line a benchmark: `group.command("tracking")(tracking)`, heavy imports inside the function.
    group.command("align")(align)
    group.command("tracking")(tracking)
    group.command("people")(people)


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


def tracking(
    quick: Annotated[
        bool, typer.Option("--quick", help="Fewer and shorter sequences: minutes instead of an hour.")
    ] = False,
    only: Annotated[
        str,
        typer.Option(
            help="Parts, with commas between: accuracy, fig11, parts, handheld, disturbance, loss, recordings, time."
        ),
    ] = "",
    data: Annotated[
        Path | None, typer.Option(help="Folder of recordings, each with images, model, camera and reference.")
    ] = None,
    seed: Annotated[int, typer.Option(help="Seed of all motions, scenery and noise.")] = 0,
    as_json: Annotated[bool, typer.Option("--json", help="Print the tables as JSON.")] = False,
) -> None:
    """The model-based tracker: accuracy, speed, disturbances, losses, recordings, time."""
    from rich.console import Console

    from vipr.scenarios.bench.tables import print_json, print_tables
    from vipr.scenarios.bench.tracking import run

    parts = [name.strip() for name in only.split(",") if name.strip()]
    with Console(stderr=True).status("rendering") as status:
        tables = run(quick=quick, only=parts, data=data, seed=seed, progress=status.update)
        (print_json if as_json else print_tables)(tables)


def people(
    quick: Annotated[bool, typer.Option("--quick", help="A tenth of the scenes.")] = False,
    only: Annotated[str, typer.Option(help="Parts, with commas between: time, rooms, light, clips, pixels.")] = "",
    data: Annotated[Path | None, typer.Option(help="Folder of recordings with video/, skin/ and images/.")] = None,
    seed: Annotated[int, typer.Option(help="Seed of the first scene.")] = 1000,
    as_json: Annotated[bool, typer.Option("--json", help="Print the tables as JSON.")] = False,
) -> None:
    """Seeing people: Table I row by row, rendered rooms, changing light, real clips, skin pixels."""
    from rich.console import Console

    from vipr.scenarios.bench.people import run
    from vipr.scenarios.bench.tables import print_json, print_tables

    parts = [name.strip() for name in only.split(",") if name.strip()]
    with Console(stderr=True).status("rendering") as status:
        tables = run(quick=quick, only=parts, data=data, seed=seed, progress=status.update)
        (print_json if as_json else print_tables)(tables)
