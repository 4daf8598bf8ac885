"""``vipr calibrate``: intrinsics and X_WC from views of a board in the robot's hand."""

from pathlib import Path
from typing import Annotated

import typer


def register(app: typer.Typer) -> None:
    """Add the subcommand to the app."""
    app.command("calibrate")(calibrate)


def calibrate(
    out: Annotated[Path, typer.Option(help="Folder for camera.yaml, X_WC.yaml, summary.json and residuals.png.")],
    seed: Annotated[
        int | None, typer.Option(help="Make the views in the simulated workcell: the seed chooses them and the noise.")
    ] = None,
    views: Annotated[int, typer.Option(help="How many views are simulated.")] = 20,
    other_camera: Annotated[
        bool, typer.Option("--other-camera", help="In simulation: the seed moves the camera and changes its lens too.")
    ] = False,
    images: Annotated[
        str | None, typer.Option(help="Images of the board: folder, quoted glob 'DIR/*.png' or pattern.")
    ] = None,
    poses: Annotated[
        Path | None, typer.Option(help="CSV with the columns image, x_we_00 ... x_we_33: the hand in the world (m).")
    ] = None,
    board: Annotated[Path | None, typer.Option(help="YAML of the board; default: models/calibration_board.")] = None,
    radial: Annotated[int, typer.Option(help="Coefficients of radial distortion to estimate: 0, 1 or 2.")] = 0,
    arm_mm: Annotated[float, typer.Option(help="How well the arm knows its hand's position, mm (1 sigma).")] = 0.1,
    arm_deg: Annotated[float, typer.Option(help="And its rotation, degrees (1 sigma).")] = 0.01,
    as_json: Annotated[bool, typer.Option("--json", help="Print the summary as JSON.")] = False,
) -> None:
    """Calibrate the fixed camera with a board in the hand: on images with poses, or in the simulated workcell."""
    import json

    from rich.console import Console

    from vipr.models import model_path
    from vipr.scenarios.calibrating.estimate import calibrate_images, lines, summary, write
    from vipr.scenarios.calibrating.views import simulate_views
    from vipr.scenarios.command.output import output_folder
    from vipr.systems.calibration.board import load_board
    from vipr.systems.calibration.bundle import ArmAccuracy
    from vipr.systems.errors import InputError

    if (seed is None) == (images is None):
        raise InputError("calibrate: give either --seed, for simulated views, or --images with --poses")
    if images is not None and poses is None:
        raise InputError("calibrate: --images needs --poses, where the hand was in each of them")
    if seed is not None and (poses is not None or board is not None):
        raise InputError("calibrate: --poses and --board belong to --images; simulated views bring their own")
    arm = ArmAccuracy(arm_mm, arm_deg)
    pattern = load_board(board or model_path("calibration_board/board.yaml"))
    folder, true = output_folder(out), None
    if seed is not None:
        with Console(stderr=True).status("the arm shows the board") as status:
            true = simulate_views(
                folder,
                seed,
                views,
                other_camera=other_camera,
                progress=lambda done: status.update(f"the arm shows the board: {done} of {views}"),
            )
        images, poses = str(folder / "images"), folder / "poses.csv"
    found, without = calibrate_images(images, poses, pattern, radial=radial, arm=arm)
    told = summary(found, without, true)
    write(folder, found, told)
    print(json.dumps(told, indent=2) if as_json else "\n".join([*lines(found, told), f"written to {out}"]))
