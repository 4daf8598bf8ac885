"""Files of a calibration: poses of the hand in, ``camera.yaml`` (ROS camera_info) and ``X_WC.yaml`` out."""

import csv
from pathlib import Path

import numpy as np
import yaml

from vipr.systems import se3
from vipr.systems.calibration.calibrate import Calibration
from vipr.systems.camera.lens import Lens, load_lens, save_lens
from vipr.systems.errors import InputError

CAMERA, POSE = "camera.yaml", "X_WC.yaml"
COLUMNS = tuple(f"x_we_{i}{j}" for i in range(4) for j in range(4))


def write_hand_poses(path: Path, poses: dict[str, np.ndarray]) -> None:
    """Write ``{image name: X_WE}`` as a CSV file."""
    with open(path, "w", newline="") as file:
        table = csv.writer(file)
        table.writerow(("image", *COLUMNS))
        table.writerows((name, *(f"{v:.9g}" for v in X.ravel())) for name, X in poses.items())


def read_hand_poses(path: str | Path) -> dict[str, np.ndarray]:
    """``{image name: X_WE}`` of a CSV file with the columns image and x_we_00 ... x_we_33 (rows of the 4x4 matrix, m)."""
    try:
        with open(path, newline="") as file:
            rows = list(csv.DictReader(file))
    except (OSError, UnicodeDecodeError, csv.Error) as error:
        raise InputError(f"poses {path}: cannot be read ({error})") from None
    poses = {}
    for number, row in enumerate(rows, start=2):
        try:
            X = np.array([float(row[c]) for c in COLUMNS]).reshape(4, 4)
            name = row["image"]
        except (KeyError, TypeError, ValueError) as error:
            raise InputError(
                f"poses {path}, line {number}: needs the columns image, x_we_00 ... x_we_33 with numbers ({error} is missing or wrong)"
            ) from None
        if not se3.is_pose(X):
            raise InputError(f"poses {path}, line {number}: x_we of {name} is not a rigid pose (rotation and metres)")
        poses[name] = X
    if not poses:
        raise InputError(f"poses {path}: holds no pose")
    return poses


def write_calibration(folder: Path, calibration: Calibration) -> None:
    """Write ``camera.yaml`` and ``X_WC.yaml``."""
    save_lens(folder / CAMERA, calibration.lens, "calibrated")
    content = {
        "X_WC": calibration.X_WC.tolist(),
        "standard_error": {
            "position_mm": calibration.position_error_mm.tolist(),
            "rotation_deg": calibration.rotation_error_deg.tolist(),
        },
        "X_EB": calibration.X_EB.tolist(),
    }
    text = (
        "# The camera in the robot's world (m), with standard errors about the world's axes; the board in the hand.\n"
    )
    (folder / POSE).write_text(text + yaml.safe_dump(content, sort_keys=False, default_flow_style=None, width=140))


def read_calibration(folder: str | Path) -> tuple[Lens, np.ndarray]:
    """Lens and X_WC of a folder that ``vipr calibrate`` wrote."""
    folder = Path(folder)
    lens = load_lens(folder / CAMERA)
    try:
        X_WC = np.array(yaml.safe_load((folder / POSE).read_text())["X_WC"], float)
    except (OSError, UnicodeDecodeError, yaml.YAMLError, KeyError, TypeError, ValueError) as error:
        raise InputError(
            f"calibration {folder}: {POSE} cannot be read ({(str(error).splitlines() or ['?'])[0]})"
        ) from None
    if not se3.is_pose(X_WC):
        raise InputError(f"calibration {folder}: X_WC in {POSE} is not a rigid 4x4 pose")
    return lens, X_WC
