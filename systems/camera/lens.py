"""The lens: a pinhole with optional Brown-Conrady distortion, in OpenCV's convention (pixel centres at integers).

Drake puts the principal point half a pixel further: ``cx_drake = cx + 0.5``. Frame C: x right, y down, z forward.
"""

from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np
import yaml

from vipr.systems.errors import InputError


@dataclass(frozen=True)
class Lens:
    """Intrinsics of one camera; lengths in pixels."""

    width: int
    height: int
    fx: float
    fy: float
    cx: float
    cy: float
    distortion: tuple[float, ...] = ()  # k1 k2 p1 p2 [k3], OpenCV order; empty = none

    def __post_init__(self):
        if self.width < 1 or self.height < 1:
            raise InputError(f"lens: image size must be positive, got {self.width} x {self.height} px")
        for name in ("fx", "fy", "cx", "cy"):
            if not np.isfinite(getattr(self, name)):
                raise InputError(f"lens: {name} must be a finite number of pixels, got {getattr(self, name)}")
        if self.fx <= 0 or self.fy <= 0:
            raise InputError(f"lens: focal lengths must be positive, got fx {self.fx} px, fy {self.fy} px")

    @property
    def K(self) -> np.ndarray:
        """(3, 3) camera matrix [px]."""
        return np.array([[self.fx, 0.0, self.cx], [0.0, self.fy, self.cy], [0.0, 0.0, 1.0]])

    def project(self, p_C: np.ndarray) -> np.ndarray:
        """Pixels (..., 2) of points (..., 3) [m] in C by the undistorted pinhole; points need z > 0."""
        p_C = np.asarray(p_C, float)
        return p_C[..., :2] / p_C[..., 2:] * (self.fx, self.fy) + (self.cx, self.cy)

    def undistort(self, image: np.ndarray) -> np.ndarray:
        """The image as the pinhole of this lens would see it (the image itself where there is no distortion)."""
        if not any(self.distortion):
            return image
        return cv2.undistort(image, self.K, np.array(self.distortion))


def load_lens(path: str | Path) -> Lens:
    """Lens of a ROS ``camera_info`` YAML file (``image_width``, ``image_height``, ``camera_matrix``, ``distortion_coefficients``)."""
    try:
        info = yaml.safe_load(Path(path).read_text())
    except (OSError, UnicodeDecodeError, yaml.YAMLError) as error:
        raise InputError(f"camera file {path}: cannot be read ({_first_line(error)})") from None
    if not isinstance(info, dict):
        raise InputError(f"camera file {path}: expected the fields of a ROS camera_info, got {type(info).__name__}")
    try:
        K = info["camera_matrix"] if "camera_matrix" in info else info["K"]
        K = np.asarray(K["data"] if isinstance(K, dict) else K, float).reshape(3, 3)
        width, height = int(info["image_width"]), int(info["image_height"])
    except (KeyError, TypeError, ValueError) as error:
        raise InputError(
            f"camera file {path}: needs image_width, image_height and camera_matrix with 9 numbers ({_first_line(error)} is missing "
            "or wrong)"
        ) from None
    model = info.get("distortion_model") or "plumb_bob"
    raw = info.get("distortion_coefficients", info.get("D")) or []
    coefficients = tuple(float(k) for k in (raw["data"] if isinstance(raw, dict) else raw))
    if any(coefficients) and model not in ("plumb_bob", "rational_polynomial"):
        raise InputError(f"camera file {path}: distortion_model must be plumb_bob or rational_polynomial, got {model}")
    return Lens(width, height, K[0, 0], K[1, 1], K[0, 2], K[1, 2], coefficients)


def save_lens(path: str | Path, lens: Lens, name: str = "camera") -> None:
    """Write the lens as a ROS ``camera_info`` YAML file that ``load_lens`` reads."""

    def matrix(rows: int, numbers) -> dict:
        numbers = [float(v) for v in numbers]
        return {"rows": rows, "cols": len(numbers) // rows, "data": numbers}

    distortion = [*lens.distortion, 0.0, 0.0, 0.0, 0.0, 0.0]
    info = {
        "image_width": lens.width,
        "image_height": lens.height,
        "camera_name": name,
        "camera_matrix": matrix(3, lens.K.ravel()),
        "distortion_model": "plumb_bob" if len(lens.distortion) <= 5 else "rational_polynomial",
        "distortion_coefficients": matrix(1, distortion[: max(5, len(lens.distortion))]),
        "rectification_matrix": matrix(3, np.eye(3).ravel()),
        "projection_matrix": matrix(3, np.column_stack([lens.K, np.zeros(3)]).ravel()),
    }
    Path(path).write_text(yaml.safe_dump(info, sort_keys=False, default_flow_style=None, width=140))


def _first_line(error: Exception) -> str:
    return (str(error).splitlines() or [type(error).__name__])[0]
