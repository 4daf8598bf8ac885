"""``vipr teach``: shows the robot a place for an object (paper III-F)."""

from pathlib import Path
from typing import Annotated

import typer

from vipr.scenarios.command.run import Settings


def register(app: typer.Typer) -> None:
    """Add the subcommand to the app."""
    app.command()(teach)


def teach(
    out: Annotated[Path, typer.Option(help="YAML file of the place.")] = Path("shown-place.yaml"),
    seed: Annotated[int, typer.Option(help="Of the camera's noise; 0 or larger.", min=0)] = 0,
    settings: Settings = [],  # noqa: B006 (typer copies it)
) -> None:
    """Hold an object at a place (--set object=..., place=...) before the camera, and store the image positions of its corners, and beside
    FILE.yaml the picture, FILE.png.

    ``vipr run place_by_showing --set shown=FILE`` brings it there again.
    """
    from vipr.scenarios.place_by_showing import PlaceByShowing
    from vipr.scenarios.settings import load_settings
    from vipr.scenarios.shown_place import save_shown_place

    values = load_settings(PlaceByShowing.settings_type, PlaceByShowing.settings_file(), settings)
    shown = PlaceByShowing(values, seed).show()
    save_shown_place(shown, out)
    print(f"{shown.object}, place {shown.place}: {len(shown.pixels)} corners in {out}")
