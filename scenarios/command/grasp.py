"""``vipr grasp``: teach grasps, and show what is taught."""

from pathlib import Path
from typing import Annotated

import typer

OBJECT = Annotated[str, typer.Argument(help="A folder of vipr.models that has a CAD model, such as can.")]


def register(app: typer.Typer) -> None:
    """Add the subcommands to the app."""
    group = typer.Typer(help="Grasps: taught in simulation, kept as data.", no_args_is_help=True)
    app.add_typer(group, name="grasp")
    group.command("teach")(teach)
    group.command("show")(show)


def teach(
    object_: OBJECT,
    out: Annotated[Path | None, typer.Option(help="The YAML file; the object's grasps.yaml if not given.")] = None,
    seed: Annotated[int, typer.Option(help="Draws the errors of the pose that the best are tried with.", min=0)] = 1,
    standing: Annotated[bool, typer.Option(help="Only as it stands: an open mug is not to be laid down.")] = False,
) -> None:
    """Try grasps of an object on a bench with the hand alone, judge them, and write the best to its table."""
    from rich.console import Console

    from vipr.models import model_path
    from vipr.scenarios.teaching.teach import teach as search
    from vipr.systems.errors import InputError
    from vipr.systems.grasping.grasp import save_grasps

    if out is not None and not out.resolve().parent.is_dir():
        raise InputError(f"--out {out}: its folder must exist")
    console = Console(stderr=True, soft_wrap=True)
    table = search(object_, seed=seed, lying=not standing, tick=lambda text: console.print(text, highlight=False))
    path = out or model_path(f"{object_}/model.yaml").with_name("grasps.yaml")
    save_grasps(
        table,
        path,
        f"Written by vipr grasp teach {object_} --seed {seed}{' --standing' if standing else ''}; lengths in the object's frame O.",
    )
    _print_table(table)
    print(f"written to {path}")


def show(object_: OBJECT) -> None:
    """Show an object's table of grasps."""
    from vipr.models import model_path, object_names
    from vipr.systems.errors import InputError
    from vipr.systems.grasping.grasp import load_grasps

    if object_ not in object_names():
        raise InputError(f"grasp show: unknown object {object_!r}; there are: {', '.join(object_names())}")
    _print_table(load_grasps(model_path(f"{object_}/model.yaml").with_name("grasps.yaml")))


def _print_table(grasps) -> None:
    import numpy as np
    from rich.console import Console
    from rich.table import Table

    table = Table(title=f"grasps of {grasps.object}, {grasps.mass:g} kg")
    for name in ("grasp", "up", "spread deg", "torque N m", "width mm", "quality", "held %"):
        table.add_column(name, justify="left" if name == "grasp" else "right")
    for g in grasps.grasps:
        up = "".join(f"{'-' if v < 0 else ''}{axis}" for axis, v in zip("xyz", g.up, strict=True) if abs(v) > 0.5)
        torque = " ".join(f"{v:g}" for v in g.torque)
        numbers = (
            f"{np.degrees(g.spread):.0f}",
            torque,
            f"{1e3 * g.width:.0f}",
            f"{g.quality:.3f}",
            f"{100 * g.held:.0f}",
        )
        table.add_row(g.name, up, *numbers)
    Console().print(table)
