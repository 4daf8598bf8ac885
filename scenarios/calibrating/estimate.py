"""Calibrate from a folder of images and poses, and write what was found: two YAML files, ``summary.json``, ``residuals.png``."""

import json
from pathlib import Path

import numpy as np

from vipr.diagrams.workcell_layout import STAGE
from vipr.scenarios.calibrating.views import Truth
from vipr.systems import se3
from vipr.systems.calibration.board import Board, find_board
from vipr.systems.calibration.bundle import ArmAccuracy
from vipr.systems.calibration.calibrate import Calibration, calibrate
from vipr.systems.calibration.files import read_hand_poses, write_calibration
from vipr.systems.camera.image_files import ImageSequence
from vipr.systems.errors import InputError

WORKSPACE = STAGE + np.stack(np.meshgrid(*([np.linspace(-0.15, 0.15, 4)] * 2), [0.0, 0.15, 0.3]), axis=-1).reshape(
    -1, 3
)  # m, W


def calibrate_images(
    images: str, poses: Path, board: Board, *, radial: int = 0, arm: ArmAccuracy = ArmAccuracy()
) -> tuple[Calibration, list[str]]:
    """The calibration, and the names of images in which the board was not found.

    Images without a pose, of different sizes, or that cannot be read end it with an InputError.
    """
    X_WE = read_hand_poses(poses)
    views, without, size = [], [], None
    for name, image in ImageSequence(images):
        if isinstance(image, InputError):
            raise image
        if name not in X_WE:
            raise InputError(f"calibrate: {poses} has no pose for image {name}")
        if size not in (None, image.shape[1::-1]):
            raise InputError(
                f"calibrate: image {name} is {image.shape[1]} x {image.shape[0]} px, those before are {size[0]} x {size[1]} px"
            )
        size = image.shape[1::-1]
        view = find_board(board, image, name)
        without += [name] if view is None else []
        views += [] if view is None else [view]
    if not views:
        raise InputError(
            f"calibrate: the board ({board.kind}, {board.columns} x {board.rows} squares) is in none of the images"
        )
    found = calibrate(board, views, [X_WE[view.name] for view in views], size, radial=radial, arm=arm)
    return found, without


def summary(found: Calibration, without: list[str], true: Truth | None = None) -> dict:
    """What is written to ``summary.json``; with the errors against the truth where there is one."""
    lens = found.lens
    told = {
        "views": len(found.views),
        "without_board": without,
        "corners": found.corners,
        "left_out": found.left_out,
        "rms_px": found.rms_px,
        "noise_px": found.noise_px,
        "intrinsics": {"fx": lens.fx, "fy": lens.fy, "cx": lens.cx, "cy": lens.cy, "distortion": list(lens.distortion)},
        "intrinsics_standard_error": found.intrinsics_error,
        "X_WC": found.X_WC.tolist(),
        "position_standard_error_mm": found.position_error_mm.tolist(),
        "rotation_standard_error_deg": found.rotation_error_deg.tolist(),
        "X_EB": found.X_EB.tolist(),
    }
    if true is not None:
        told["error_against_truth"] = errors(found, true)
    return told


def errors(found: Calibration, true: Truth) -> dict:
    """Estimated minus true: intrinsics [px], position of the camera [mm] and rotation [deg] along and about the world's axes.

    ``workspace_px`` is what they do together: how far the calibrated camera puts points above the stage from where they are seen (RMS).
    """
    difference = se3.difference(true.X_WC, found.X_WC)
    apart = [
        lens.project((WORKSPACE - X_WC[:3, 3]) @ X_WC[:3, :3])
        for lens, X_WC in ((found.lens, found.X_WC), (true.lens, true.X_WC))
    ]
    return {
        **{name: getattr(found.lens, name) - getattr(true.lens, name) for name in ("fx", "fy", "cx", "cy")},
        "position_mm": (1e3 * difference[3:]).tolist(),
        "rotation_deg": np.rad2deg(difference[:3]).tolist(),
        "workspace_px": float(np.sqrt(np.mean(np.sum((apart[0] - apart[1]) ** 2, axis=1)))),
    }


def write(folder: Path, found: Calibration, told: dict) -> None:
    """Write the files of a calibration."""
    write_calibration(folder, found)
    (folder / "summary.json").write_text(json.dumps(told, indent=2) + "\n")
    draw(folder / "residuals.png", found)


def lines(found: Calibration, told: dict) -> list[str]:
    """The result in words."""
    truth, lens = told.get("error_against_truth"), found.lens
    rows = [
        f"{len(found.views)} views, {found.corners} corners ({found.left_out} left out), {found.rms_px:.3f} px RMS, "
        f"noise {found.noise_px:.3f} px a coordinate"
    ]
    for name, error in found.intrinsics_error.items():
        value = getattr(lens, name) if hasattr(lens, name) else lens.distortion[("k1", "k2").index(name)]
        against = f"   error {truth[name]:+.3f}" if truth and name in truth else ""
        rows.append(f"{name:>12}: {value:10.3f} +- {error:.3f}{' px' if hasattr(lens, name) else ''}{against}")
    for name, values, sigma, unit, key in (
        ("position", 1e3 * found.X_WC[:3, 3], found.position_error_mm, "mm", "position_mm"),
        ("rotation", np.rad2deg(se3.log_so3(found.X_WC[:3, :3])), found.rotation_error_deg, "deg", "rotation_deg"),
    ):
        against = f"   error {_triple(truth[key], '+.3f')}" if truth else ""
        rows.append(f"{name:>12}: {_triple(values, '.3f')} +- {_triple(sigma, '.3f')} {unit}{against}")
    if truth:
        rows.append(
            f"   together: points above the stage are put {truth['workspace_px']:.3f} px RMS from where they are"
        )
    return rows


def _triple(values, form: str) -> str:
    return "(" + ", ".join(format(v, form) for v in values) + ")"


def draw(path: Path, found: Calibration) -> None:
    """Where the corners were, and how far each is from where the fit puts it."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(11, 4.6), layout="constrained")
    where, scatter = figure.subplots(1, 2, width_ratios=[1.45, 1])
    u, r = found.pixels, found.residuals
    times = 10.0 ** np.round(np.log10(6.0 / max(found.rms_px, 1e-3)))
    where.quiver(u[:, 0], u[:, 1], r[:, 0], r[:, 1], angles="xy", scale_units="xy", scale=1.0 / times, width=0.0015)
    where.plot(u[:, 0], u[:, 1], ".", markersize=2)
    where.set(
        title=f"Corners and residuals, {times:.0f} times as long", xlabel="u [px]", ylabel="v [px]", aspect="equal"
    )
    where.set(xlim=(0, found.lens.width), ylim=(found.lens.height, 0))
    scatter.plot(r[:, 0], r[:, 1], ".", markersize=3)
    reach = 1.1 * float(np.abs(r).max())
    scatter.set(title=f"Residuals, {found.rms_px:.3f} px RMS", xlabel="u [px]", ylabel="v [px]", aspect="equal")
    scatter.set(xlim=(-reach, reach), ylim=(-reach, reach))
    scatter.grid(alpha=0.3)
    figure.savefig(path, dpi=100)
