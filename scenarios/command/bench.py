"""``vipr bench NAME``: the benchmarks whose tables stand in the README."""

import typer


def register(app: typer.Typer) -> None:
    """Add ``bench`` and its benchmarks to the app."""
    group = typer.Typer(help="Measure a stage; the tables of the README.", no_args_is_help=True)
    app.add_typer(group, name="bench")
    # One line a benchmark: `group.command("tracking")(tracking)`, heavy imports inside the function.
