"""``vipr compare``: is it better with this setting, or with this stage of my own?"""

from pathlib import Path
from typing import Annotated

import typer


def register(app: typer.Typer) -> None:
    """Add the subcommand to the app."""
    app.command()(compare)


def compare(
    scenario: Annotated[str, typer.Argument(help="Name of the scenario; see `vipr list`.")],
    changes: Annotated[
        list[str],
        typer.Option(
            "--set", metavar="KEY=VALUE", help="What is changed, e.g. stages.tracker=FILE.py:CLASS; repeatable."
        ),
    ] = [],  # noqa: B006 (typer copies it)
    both: Annotated[
        list[str], typer.Option("--both", metavar="KEY=VALUE", help="A setting of both sides; repeatable.")
    ] = [],  # noqa: B006
    seeds: Annotated[int, typer.Option(help="How many seeds, from 1.", min=1)] = 5,
    out: Annotated[Path | None, typer.Option(help="Folder of the runs; out/compare-SCENARIO if not given.")] = None,
    jobs: Annotated[int, typer.Option(help="Runs at a time; one core each.", min=1)] = 1,
    as_json: Annotated[bool, typer.Option("--json", help="Print the table as JSON.")] = False,
) -> None:
    """Run a scenario as it is and with a change, on the same seeds, and put their figures side by side."""
    from vipr.scenarios import comparison
    from vipr.scenarios.bench.tables import print_json, print_tables

    folder = out or Path("out") / f"compare-{scenario}"
    table = comparison.compare(scenario, changes, range(1, seeds + 1), folder, both=both, jobs=jobs)
    (print_json if as_json else print_tables)([table])
