"""Real recordings, beside what other trackers reached on them (their poses lie beside the images)."""

import csv
import time
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from vipr.scenarios.bench.tables import Table
from vipr.scenarios.bench.tracking.workbench import RATE, Workbench
from vipr.systems import se3
from vipr.systems.camera.image_files import ImageSequence
from vipr.systems.camera.lens import load_lens
from vipr.systems.errors import InputError
from vipr.systems.tracking.belief import start
from vipr.systems.tracking.cad_model import load_model
from vipr.systems.tracking.evaluation import FOLLOWED_DEG, FOLLOWED_PX, compare, corner_distances, read_pose, read_poses
from vipr.systems.tracking.model_tracking import step
from vipr.systems.tracking.settings import TrackerSettings

REPEATS = 3
OTHERS = {"visp_edge": "ViSP 3.5 edges", "visp_edge_klt": "ViSP 3.5 edges + KLT", "opencv_rapid": "OpenCV RAPID"}


def run(bench: Workbench) -> Iterator[Table]:
    folders = sequences(bench.data)
    table = Table(
        "Recordings: median / 90 % / max against the reference poses",
        ("sequence", "tracker", "mm", "deg", "corner px", "followed", "wrong but `tracking`", "ms median"),
        note="followed: frames with corners within 20 px RMS and 15 degrees. agrees: followed to the last frame, and median and 90 % of "
        f"the corner distance no larger than ViSP edges'. ms: ours of processor time, the best of {REPEATS} runs; theirs as recorded.",
    )
    for folder in folders:
        bench.progress(f"recordings: {folder.name}")
        model, lens = load_model(folder / "object.obj"), load_lens(folder / "camera.yaml")
        reference = read_poses(folder / "reference.csv")
        runs = [track(folder, model, lens) for _ in range(1 if bench.quick else REPEATS)]
        poses, states, _ = runs[0]
        ms = min((run[2] for run in runs), key=np.median)
        own = compare(model, lens, poses, reference, states)
        rows, visp = [], None
        for file, name in OTHERS.items():
            path = folder / f"{file}.csv"
            if path.is_file():
                theirs = read_poses(path)
                other = compare(model, lens, theirs, reference)
                visp = other if file == "visp_edge" else visp
                rows.append(
                    (folder.name, name, *_figures(other, model, lens, theirs, reference), "-", _milliseconds(path))
                )
        agrees = ""
        if visp is not None:
            yes = (
                own.lost_at is None
                and own.corner_px.median <= visp.corner_px.median
                and own.corner_px.p90 <= visp.corner_px.p90
            )
            agrees = " (agrees)" if yes else " (does not agree)"
        table.rows.append(
            (
                folder.name,
                "VIPR" + agrees,
                *_figures(own, model, lens, poses, reference),
                own.false_tracking,
                float(np.median(ms)),
            )
        )
        table.rows += rows
    yield table


def sequences(data: Path) -> list[Path]:
    """Folders with images, model, camera, initial pose and reference under the data folder or its ``tracking``."""
    root = data / "tracking" if (data / "tracking").is_dir() else data
    found = [p.parent for p in sorted(root.glob("*/reference.csv")) if (p.parent / "object.obj").is_file()]
    if not found and (root / "reference.csv").is_file():
        found = [root]
    if not found:
        raise InputError(
            f"--data {data}: holds no sequence (a folder with images/, object.obj, camera.yaml, reference.csv)"
        )
    return found


def track(folder: Path, model, lens):
    """Poses, states and milliseconds of processor time of the tracker on one sequence."""
    belief = start(read_pose(folder / "initial-pose.yaml"))
    settings = TrackerSettings()
    poses, states, ms = {}, {}, []
    for k, (_, image) in enumerate(ImageSequence(str(folder / "images"))):
        if isinstance(image, InputError):
            raise image
        image = lens.undistort(image)
        begin = time.process_time()
        belief = step(belief, image, k / RATE, model, lens, settings, number=k)
        ms.append(1e3 * (time.process_time() - begin))
        poses[k], states[k] = belief.X_CO, belief.state
    return poses, states, ms


def _figures(agreement, model, lens, poses, reference):
    frames = sorted(set(poses) & set(reference))
    good = sum(_is_followed(model, lens, poses[k], reference[k]) for k in frames)
    followed = f"{good} of {len(frames)}"
    return str(agreement.translation_mm), str(agreement.rotation_deg), str(agreement.corner_px), followed


def _is_followed(model, lens, X_CO, X_true):
    corners = corner_distances(model, lens, X_CO, X_true)
    turned = np.degrees(se3.angle_between(X_CO, X_true))
    return bool(np.sqrt(np.mean(corners**2)) <= FOLLOWED_PX and turned <= FOLLOWED_DEG)


def _milliseconds(path):
    with open(path, newline="") as file:
        return float(np.median([float(row["ms"]) for row in csv.DictReader(file)]))
