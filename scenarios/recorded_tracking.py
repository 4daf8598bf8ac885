"""Track objects through recorded images and write what was found: ``poses.csv``, ``overlay.mp4``, ``summary.json``.

Of several objects each has its own ``poses-NAME.csv``. Everything is written under a temporary name and renamed at the end, so that a run
that fails leaves an earlier result alone. A run that is interrupted keeps what it has.
"""

import json
import os
import platform
from collections.abc import Callable, Mapping
from contextlib import ExitStack
from importlib.metadata import version
from pathlib import Path

import numpy as np

from vipr.scenarios.followed import FIELDS, Followed, Target, names_of
from vipr.scenarios.settings import as_dict
from vipr.systems.camera.image_files import ImageSequence
from vipr.systems.camera.lens import Lens
from vipr.systems.errors import InputError
from vipr.systems.recording.video import VideoWriter
from vipr.systems.signals import CameraFrame
from vipr.systems.tracking.settings import TrackerSettings


def track_images(
    images: ImageSequence,
    targets: list[Target],
    lens: Lens,
    out: Path,
    *,
    settings: TrackerSettings | None = None,
    stages: Mapping[str, str] | None = None,
    fps: float = 25.0,
    video: bool = True,
    skip_bad: bool = False,
    progress: Callable[[int, str], None] = lambda frame, state: None,
) -> dict:
    """Run a tracker for each target over all images and return the summary that was written.

    Of one target, its figures are in the summary itself; of several, in a list ``objects`` with their names. ``stages`` names another in
    the place of the ``tracker`` (see ``scenarios.replacements``). Images must have the lens's size. A bad image ends the run with its
    InputError, or counts as a dropped frame with ``skip_bad``. ``progress`` is called after each frame, with the states. KeyboardInterrupt
    passes through after what was done so far has been put in place.
    """
    settings = settings or TrackerSettings()
    if not (np.isfinite(fps) and fps > 0):
        raise InputError(f"track: --fps must be positive, got {fps:g} images/s")
    followed = [Followed(target, lens, settings, stages or {}, 1.0 / fps) for target in targets]
    names = names_of(targets)
    tables = ["poses.csv"] if len(targets) == 1 else [f"poses-{name}.csv" for name in names]
    temporary = {name: out / f".partial-{name}" for name in (*tables, "summary.json", *["overlay.mp4"] * video)}
    skipped: list[str] = []

    def finish(complete: bool) -> dict:
        found = [one.summary() for one in followed]
        several = {"objects": [{"name": name, **figures} for name, figures in zip(names, found, strict=True)]}
        result = {
            **(found[0] if len(found) == 1 else several),
            "complete": complete,
            "skipped": skipped,
            "stages": dict(stages or {}),
            "settings": as_dict(settings),
            "versions": {name: version(name) for name in ("vipr", "numpy", "opencv-python-headless")}
            | {"python": platform.python_version()},
        }
        temporary["summary.json"].write_text(json.dumps(result, indent=2) + "\n")
        for name, path in temporary.items():
            if path.exists():
                os.replace(path, out / name)
        return result

    writer = VideoWriter(temporary["overlay.mp4"], fps) if video else None
    try:
        with ExitStack() as open_files:
            files = [open_files.enter_context(open(temporary[name], "w")) for name in tables]
            for file in files:
                file.write(",".join(FIELDS) + "\n")
            for number, (name, image) in enumerate(images):
                image = _usable(name, image, lens, skip_bad)
                if not image.size:
                    skipped.append(name)
                frame = CameraFrame(image, number / fps, number)
                for one, file in zip(followed, files, strict=True):
                    file.write(one.see(frame))
                    file.flush()
                if writer is not None:
                    writer.write(_drawn(image, lens, followed, names, number))
                progress(number, ", ".join(one.states[number] for one in followed))
        if writer is not None:
            writer.close()
        return finish(True)
    except KeyboardInterrupt:
        if writer is not None:
            writer.close()
        if followed[0].states:
            finish(False)
        raise
    except OSError as error:
        raise InputError(f"--out {out}: cannot be written ({error.strerror or error})") from None
    finally:
        if writer is not None:
            writer.close()
        for path in temporary.values():
            path.unlink(missing_ok=True)


def _usable(name: str, image: np.ndarray | InputError, lens: Lens, skip_bad: bool) -> np.ndarray:
    """The image, or one without pixels for a bad one that may be skipped."""
    if isinstance(image, InputError):
        if not skip_bad:
            raise InputError(f"{image}; --skip-bad goes on as if the camera had dropped it")
        return np.zeros((0, 0), np.uint8)
    if image.shape[:2] != (lens.height, lens.width):
        raise InputError(
            f"image {name} is {image.shape[1]} x {image.shape[0]} px, the camera file says {lens.width} x {lens.height} px"
        )
    return image


def _drawn(image, lens, followed, names, number):
    """The overlay of one frame; of a dropped one, on black."""
    shown = lens.undistort(image) if image.size else np.zeros((lens.height, lens.width, 3), np.uint8)
    for line, (one, name) in enumerate(zip(followed, names, strict=True)):
        shown = one.draw(shown, f"frame {number}" if len(names) == 1 else f"frame {number} {name}", line)
    return shown
