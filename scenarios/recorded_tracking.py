"""Track an object through recorded images and write what was found: ``poses.csv``, ``overlay.mp4``, ``summary.json``.

Everything is written under a temporary name and renamed at the end, so that a run that fails leaves an earlier result alone. A run that is
interrupted keeps what it has.
"""

import json
import os
import platform
import time
from collections.abc import Callable, Mapping
from importlib.metadata import version
from pathlib import Path

import numpy as np

from vipr.diagrams.stages import Stages
from vipr.scenarios.playback import Playback
from vipr.scenarios.replacements import load_stages
from vipr.scenarios.settings import as_dict
from vipr.systems.camera.image_files import ImageSequence
from vipr.systems.camera.lens import Lens
from vipr.systems.errors import InputError
from vipr.systems.recording.video import VideoWriter
from vipr.systems.signals import CameraFrame
from vipr.systems.tracking.cad_model import CadModel
from vipr.systems.tracking.evaluation import COLUMNS, compare
from vipr.systems.tracking.model_tracking import TrackerSettings
from vipr.systems.tracking.overlay import draw_overlay
from vipr.systems.tracking.tracker import ModelTracker

STATES = ("tracking", "uncertain", "lost")
FIELDS = ("frame", "time_s", *COLUMNS, "state", "nodes", "residual_px", "ms")


def track_images(
    images: ImageSequence,
    model: CadModel,
    lens: Lens,
    X_CO_initial: np.ndarray,
    out: Path,
    *,
    settings: TrackerSettings | None = None,
    stages: Mapping[str, str] | None = None,
    fps: float = 25.0,
    video: bool = True,
    skip_bad: bool = False,
    reference: dict[int, np.ndarray] | None = None,
    progress: Callable[[int, str], None] = lambda frame, state: None,
) -> dict:
    """Run the tracker over all images and return the summary that was written.

    ``stages`` names another in the place of the ``tracker`` (see ``scenarios.replacements``). Images must have the lens's size. A bad image
    ends the run with its InputError, or counts as a dropped frame with ``skip_bad``. ``progress`` is called after each frame.
    KeyboardInterrupt passes through after what was done so far has been put in place.
    """
    settings = settings or TrackerSettings()
    if not (np.isfinite(fps) and fps > 0):
        raise InputError(f"track: --fps must be positive, got {fps:g} images/s")
    period = 1.0 / fps
    tracker = Stages({"tracker": ModelTracker}, load_stages(stages or {})).make(
        "tracker", model, lens, X_CO_initial=X_CO_initial, settings=settings, period=period, offset=0.5 * period
    )
    eye = Playback(tracker, ("object_pose",), period)
    names = ["poses.csv", "summary.json"] + ["overlay.mp4"] * video
    temporary = {name: out / f".partial-{name}" for name in names}
    poses, states, spent, skipped = {}, {}, [], []

    def summary(complete: bool) -> dict:
        counts = {state: sum(s == state for s in states.values()) for state in STATES}
        result = {
            "model": model.name,
            "frames": len(states),
            "complete": complete,
            **counts,
            "skipped": skipped,
            "first_lost": next((f for f, s in states.items() if s == "lost"), None),
            "median_ms": round(float(np.median(spent)), 3) if spent else None,
            "p90_ms": round(float(np.percentile(spent, 90)), 3) if spent else None,
            "stages": dict(stages or {}),
            "settings": as_dict(settings),
            "versions": {name: version(name) for name in ("vipr", "numpy", "opencv-python-headless")}
            | {"python": platform.python_version()},
        }
        if reference is not None and poses:
            result["agreement"] = compare(model, lens, poses, reference, states).as_dict()
        return result

    def finish(complete: bool) -> dict:
        result = summary(complete)
        temporary["summary.json"].write_text(json.dumps(result, indent=2) + "\n")
        for name, path in temporary.items():
            if path.exists():
                os.replace(path, out / name)
        return result

    writer = VideoWriter(temporary["overlay.mp4"], fps) if video else None
    try:
        with open(temporary["poses.csv"], "w") as table:
            table.write(",".join(FIELDS) + "\n")
            for frame, (name, image) in enumerate(images):
                if isinstance(image, InputError):
                    if not skip_bad:
                        raise InputError(f"{image}; --skip-bad goes on as if the camera had dropped it")
                    skipped.append(name)
                    image = np.zeros((0, 0), np.uint8)
                elif image.shape[:2] != (lens.height, lens.width):
                    raise InputError(
                        f"image {name} is {image.shape[1]} x {image.shape[0]} px, the camera file says "
                        f"{lens.width} x {lens.height} px"
                    )
                begin = time.perf_counter()
                belief = eye.show(CameraFrame(image, frame / fps, frame))["object_pose"]
                ms = 1e3 * (time.perf_counter() - begin)
                poses[frame], states[frame] = belief.X_CO, belief.state
                spent.append(ms)
                numbers = ",".join(f"{v:.9g}" for v in belief.X_CO.ravel())
                table.write(
                    f"{frame},{frame / fps:.6f},{numbers},{belief.state},{belief.nodes},{belief.residual_px:.4f},{ms:.3f}\n"
                )
                table.flush()
                if writer is not None:
                    blank = np.zeros((lens.height, lens.width, 3), np.uint8)
                    shown = lens.undistort(image) if image.size else blank
                    writer.write(draw_overlay(shown, model, lens, belief.X_CO, belief.state, f"frame {frame}"))
                progress(frame, belief.state)
        if writer is not None:
            writer.close()
        return finish(True)
    except KeyboardInterrupt:
        if writer is not None:
            writer.close()
        if states:
            finish(False)
        raise
    except OSError as error:
        raise InputError(f"--out {out}: cannot be written ({error.strerror or error})") from None
    finally:
        if writer is not None:
            writer.close()
        for path in temporary.values():
            path.unlink(missing_ok=True)
