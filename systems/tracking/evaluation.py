"""Tracked poses against reference poses: pose files, and figures as trackers are compared by.

``Followed`` means: RMS distance of the projected model corners at most 20 px and rotation at most 15 degrees. The corner
distance of a frame is the mean over the model's corners.
"""

import csv
from dataclasses import asdict, dataclass
from pathlib import Path

import numpy as np
import yaml

from vipr.systems import se3
from vipr.systems.camera.lens import Lens
from vipr.systems.errors import InputError
from vipr.systems.tracking.cad_model import CadModel

COLUMNS = tuple(f"x_co_{i}{j}" for i in range(4) for j in range(4))
FOLLOWED_PX, FOLLOWED_DEG = 20.0, 15.0


@dataclass(frozen=True)
class Spread:
    """Median, 90th percentile and largest of a quantity."""

    median: float
    p90: float
    max: float

    @staticmethod
    def of(values) -> "Spread":
        values = np.asarray(values, float)
        if not len(values):
            return Spread(*[float("nan")] * 3)
        return Spread(float(np.median(values)), float(np.percentile(values, 90)), float(values.max()))

    def __str__(self):
        return f"{self.median:.2f} / {self.p90:.2f} / {self.max:.2f}"


@dataclass(frozen=True)
class Agreement:
    """How tracked poses agree with reference poses, over the frames that have both."""

    frames: int  # compared
    translation_mm: Spread
    rotation_deg: Spread
    corner_px: Spread
    followed: int  # frames before the first that was not followed
    lost_at: int | None  # that frame; None when followed to the end
    false_tracking: int  # frames said to be `tracking` that were not followed

    def as_dict(self) -> dict:
        return asdict(self)


def corner_distances(model: CadModel, lens: Lens, X_CA: np.ndarray, X_CB: np.ndarray) -> np.ndarray:
    """(N,) px between the projections of the model's corners at two poses; infinite behind the camera."""
    pixels = []
    for X in (X_CA, X_CB):
        p_C = model.corners @ X[:3, :3].T + X[:3, 3]
        if (p_C[:, 2] <= 0).any():
            return np.full(len(p_C), np.inf)
        pixels.append(lens.project(p_C))
    return np.linalg.norm(pixels[0] - pixels[1], axis=1)


def compare(
    model: CadModel,
    lens: Lens,
    poses: dict[int, np.ndarray],
    reference: dict[int, np.ndarray],
    states: dict[int, str] | None = None,
) -> Agreement:
    """Agreement of poses {frame: X_CO} with a reference. Raises InputError when they have no frame in common."""
    frames = sorted(set(poses) & set(reference))
    if not frames:
        raise InputError("reference: has no frame in common with the tracked ones")
    distance, angle, shift, good = [], [], [], []
    for frame in frames:
        X, truth = poses[frame], reference[frame]
        corners = corner_distances(model, lens, X, truth)
        distance.append(corners.mean())
        angle.append(np.degrees(se3.angle_between(X, truth)))
        shift.append(1e3 * np.linalg.norm(X[:3, 3] - truth[:3, 3]))
        good.append(bool(np.sqrt((corners**2).mean()) <= FOLLOWED_PX and angle[-1] <= FOLLOWED_DEG))
    first = good.index(False) if False in good else len(good)
    claimed = [states is not None and states.get(f) == "tracking" for f in frames]
    return Agreement(
        len(frames),
        Spread.of(shift),
        Spread.of(angle),
        Spread.of(distance),
        first,
        frames[first] if first < len(frames) else None,
        sum(c and not g for c, g in zip(claimed, good, strict=True)),
    )


def read_poses(path: str | Path) -> dict[int, np.ndarray]:
    """{frame: X_CO} of a CSV file with the columns frame and x_co_00 ... x_co_33."""
    try:
        with open(path, newline="") as file:
            rows = list(csv.DictReader(file))
    except (OSError, UnicodeDecodeError, csv.Error) as error:
        raise InputError(f"poses {path}: cannot be read ({error})") from None
    try:
        return {int(row["frame"]): np.array([float(row[c]) for c in COLUMNS]).reshape(4, 4) for row in rows}
    except (KeyError, TypeError, ValueError) as error:
        raise InputError(
            f"poses {path}: needs the columns frame, x_co_00 ... x_co_33 with numbers ({error} is missing or wrong)"
        ) from None


def read_pose(path: str | Path) -> np.ndarray:
    """X_CO of a YAML file with ``X_CO`` as 4x4 or 16 numbers, or of a file with six numbers [tx ty tz tux tuy tuz] (m, rad)."""
    try:
        content = yaml.safe_load(Path(path).read_text())
    except (OSError, UnicodeDecodeError, yaml.YAMLError) as error:
        raise InputError(f"pose file {path}: cannot be read ({str(error).splitlines()[0]})") from None
    if isinstance(content, dict):
        content = content.get("X_CO", content.get("pose"))
    try:
        if isinstance(content, str):  # numbers with blanks between them
            content = content.split()
        numbers = np.array(content, float).ravel()
    except (TypeError, ValueError):
        numbers = np.zeros(0)
    if numbers.size == 6 and np.isfinite(numbers).all():
        return se3.pose(se3.exp_so3(numbers[3:]), numbers[:3])
    if numbers.size != 16:
        raise InputError(f"pose file {path}: expected X_CO as 4x4 numbers, or 6 numbers tx ty tz tux tuy tuz (m, rad)")
    X = numbers.reshape(4, 4)
    if not se3.is_pose(X):
        raise InputError(f"pose file {path}: X_CO must be a finite rigid motion (rotation orthonormal to 1e-3)")
    return X
