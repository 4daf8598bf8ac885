"""``vipr hands``: face and hands on real video, with the chain of the robot."""

import json
from pathlib import Path
from typing import Annotated

import typer


def register(app: typer.Typer) -> None:
    """Add the subcommand to the app."""
    app.command("hands")(hands)


def hands(
    out: Annotated[Path, typer.Option(help="Folder for regions.csv, overlay.mp4 and summary.json.")],
    video: Annotated[Path | None, typer.Option(help="Video file.")] = None,
    camera: Annotated[int | None, typer.Option(help="Number of a live camera; Ctrl-C ends.")] = None,
    images: Annotated[
        str | None, typer.Option(help="Folder, quoted glob 'DIR/*.jpg' or pattern 'DIR/%04d.png'.")
    ] = None,
    fps: Annotated[float | None, typer.Option(help="Frames a second, instead of the file's own (images: 25).")] = None,
    working_area: Annotated[float, typer.Option(help="Pixels to which frames are reduced inside.")] = 0.0,
    mirrored: Annotated[
        bool, typer.Option("--mirrored", help="The picture is a mirror image: the person's left hand is on its left.")
    ] = False,
    stage: Annotated[
        list[str],
        typer.Option(
            "--stage",
            metavar="NAME=FILE.py:CLASS",
            help="A stage of yours, skin or hands, in the place of the robot's own.",
        ),
    ] = [],  # noqa: B006 (typer copies it)
    no_video: Annotated[bool, typer.Option("--no-video", help="Write no overlay.mp4.")] = False,
    as_json: Annotated[bool, typer.Option("--json", help="Print the summary as JSON.")] = False,
) -> None:
    """Follow a face and two hands through a video ("left" is the person's left hand)."""
    from rich.console import Console
    from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn

    from vipr.scenarios.command.output import output_folder
    from vipr.scenarios.people.clip import follow_video
    from vipr.scenarios.replacements import stages_given
    from vipr.systems.camera.video_frames import open_camera, open_images, open_video
    from vipr.systems.errors import InputError
    from vipr.systems.skin.classifier import SkinOptions

    if (video is not None) + (camera is not None) + (images is not None) != 1:
        raise InputError("hands: give one of --video FILE, --camera N and --images 'DIR/*.jpg'")
    options = SkinOptions(working_area=working_area) if working_area else SkinOptions()
    if video is not None:
        source = open_video(video, fps)
    elif images is not None:
        source = open_images(images, 25.0 if fps is None else fps)
    else:
        source = open_camera(camera, fps)
    folder = output_folder(out)
    columns = (TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), TimeRemainingColumn())
    with Progress(*columns, console=Console(stderr=True), transient=True) as bar:
        task = bar.add_task("following", total=source.count or None)
        summary = follow_video(
            source, folder, options=options, stages=stages_given(stage), video=not no_video, mirrored=mirrored,
            progress=lambda k: bar.update(task, completed=k + 1),
        )  # fmt: skip
    if as_json:
        print(json.dumps(summary, indent=2))
        return
    seen = ", ".join(f"{name} in {count}" for name, count in summary["seen"].items())
    print(f"{summary['frames']} frames: {seen}; {summary['median_ms']} ms a frame (median)")
    for note in summary["notes"]:
        print(f"note: {note}")
    print(f"written to {out}")
