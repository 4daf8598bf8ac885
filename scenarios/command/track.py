"""``vipr track``: the model-based tracker on recorded images."""

import json
from pathlib import Path
from typing import Annotated

import typer


def register(app: typer.Typer) -> None:
    """Add the subcommand to the app."""
    app.command("track")(track)


def track(
    images: Annotated[str, typer.Option(help="Folder, quoted glob 'DIR/*.png', pattern 'DIR/%04d.png' or video file.")],
    model: Annotated[
        list[Path],
        typer.Option(
            help="CAD model in metres: .obj, .cao, .yaml, or a mesh (.stl, .ply, .off); repeated for several objects."
        ),
    ],
    camera: Annotated[Path, typer.Option(help="ROS camera_info YAML of the images.")],
    initial_pose: Annotated[
        list[Path],
        typer.Option(help="YAML with X_CO of the first image (4x4), or 6 numbers t, theta u; one for each model."),
    ],
    out: Annotated[
        Path,
        typer.Option(help="Folder for poses.csv (poses-NAME.csv of several), overlay.mp4 and summary.json."),
    ],
    fps: Annotated[float, typer.Option(help="Images a second.")] = 25.0,
    reference: Annotated[
        list[Path], typer.Option(help="CSV of reference poses to compare with; none, or one for each model.")
    ] = [],  # noqa: B006 (typer copies it)
    set_: Annotated[
        list[str] | None, typer.Option("--set", help="A tracker setting, key=value; may be repeated.")
    ] = None,
    stage: Annotated[
        list[str],
        typer.Option("--stage", metavar="NAME=FILE.py:CLASS", help="A tracker in the place of the robot's own."),
    ] = [],  # noqa: B006 (typer copies it)
    skip_bad: Annotated[bool, typer.Option("--skip-bad", help="Take unreadable images as dropped frames.")] = False,
    no_video: Annotated[bool, typer.Option("--no-video", help="Write no overlay.mp4.")] = False,
    as_json: Annotated[bool, typer.Option("--json", help="Print the summary as JSON.")] = False,
) -> None:
    """Track objects of known CAD model through recorded images; their poses in the first image are given."""
    from rich.console import Console
    from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn

    from vipr.scenarios.command.output import output_folder
    from vipr.scenarios.followed import Target
    from vipr.scenarios.recorded_tracking import track_images
    from vipr.scenarios.replacements import stages_given
    from vipr.scenarios.settings import load_settings
    from vipr.systems.camera.image_files import ImageSequence
    from vipr.systems.camera.lens import load_lens
    from vipr.systems.errors import InputError
    from vipr.systems.tracking.cad_model import load_model
    from vipr.systems.tracking.evaluation import read_pose, read_poses
    from vipr.systems.tracking.settings import TrackerSettings

    settings = load_settings(TrackerSettings, None, set_ or [])
    if len(initial_pose) != len(model) or len(reference) not in (0, len(model)):
        raise InputError(
            f"track: --initial-pose must come once for each --model, --reference so or never; got {len(model)} models, "
            f"{len(initial_pose)} initial poses, {len(reference)} references"
        )
    lens = load_lens(camera)
    targets = [
        Target(load_model(cad), read_pose(pose), known and read_poses(known))
        for cad, pose, known in zip(model, initial_pose, reference or [None] * len(model), strict=True)
    ]
    sequence = ImageSequence(images)
    columns = (TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), TimeRemainingColumn())
    with Progress(*columns, console=Console(stderr=True), transient=True) as bar:
        task = bar.add_task("starting (compiles at its first use ever)", total=len(sequence) or None)
        result = track_images(
            sequence,
            targets,
            lens,
            output_folder(out),
            settings=settings,
            stages=stages_given(stage),
            fps=fps,
            video=not no_video,
            skip_bad=skip_bad,
            progress=lambda frame, state: bar.update(task, completed=frame + 1, description=state),
        )
    if as_json:
        print(json.dumps(result, indent=2))
        return
    for one in result.get("objects", [result]):
        print_figures(one)
    print(f"written to {out}")


def print_figures(one: dict) -> None:
    """What became of one object, as a few lines."""
    name = f"{one['name']}: " if "name" in one else ""
    states = f"{one['tracking']} tracking, {one['uncertain']} uncertain, {one['lost']} lost"
    print(f"{name}{one['frames']} frames: {states}; {one['median_ms']} ms a frame (median)")
    if "agreement" in one:
        print_agreement(one["agreement"])


def print_agreement(agreement: dict) -> None:
    """The agreement with a reference, as a few lines."""
    lines = (
        ("translation", "translation_mm", "mm"),
        ("rotation", "rotation_deg", "deg"),
        ("corners", "corner_px", "px"),
    )
    for name, key, unit in lines:
        s = agreement[key]
        print(f"{name:>12}: {s['median']:.2f} / {s['p90']:.2f} / {s['max']:.2f} {unit} (median / 90 % / max)")
    print(f"{'followed':>12}: {agreement['followed']} of {agreement['frames']} frames of the reference")
