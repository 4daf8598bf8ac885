"""``vipr track``: the model-based tracker on recorded images."""

import typer


def register(app: typer.Typer) -> None:
    """Add the subcommand to the app."""
