"""What a run believes of its camera: the truth, what ``vipr calibrate`` found, or either with errors of a given size."""

from dataclasses import dataclass, replace

import numpy as np

from vipr.systems import se3
from vipr.systems.calibration.files import read_calibration
from vipr.systems.camera.lens import Lens
from vipr.systems.errors import InputError


@dataclass(frozen=True, kw_only=True)
class CameraKnowledge:
    """Settings ``calibration.*`` of a scenario; by default the camera is known exactly."""

    folder: str = ""  # of `vipr calibrate`: its camera.yaml and X_WC.yaml are believed instead of the truth
    focal_error_percent: float = 0.0  # both focal lengths are believed so much too long (negative: too short)
    X_WC_error_mm: float = 0.0  # the camera is believed so far from where it is, in a direction that the seed chooses
    X_WC_error_deg: float = 0.0  # and turned by so much about its centre, about an axis that the seed chooses

    def __post_init__(self):
        for name, least, most, unit in (
            ("focal_error_percent", -50, 50, "%"),
            ("X_WC_error_mm", 0, 500, "mm"),
            ("X_WC_error_deg", 0, 45, "deg"),
        ):
            value = getattr(self, name)
            if not least <= value <= most:
                raise InputError(f"calibration.{name} must be {least} to {most} {unit}, got {value}")

    def believed(self, lens: Lens, X_WC: np.ndarray, seed: int) -> tuple[Lens, np.ndarray]:
        """Lens and X_WC that the robot works with, for the true ones."""
        size = (lens.width, lens.height)
        if self.folder:
            lens, X_WC = read_calibration(self.folder)
            if (lens.width, lens.height) != size:
                raise InputError(
                    f"calibration {self.folder}: is of images of {lens.width} x {lens.height} px, the camera's are {size[0]} x {size[1]} px"
                )
        longer = 1.0 + 0.01 * self.focal_error_percent
        rng = np.random.default_rng([seed, 7])
        aside, axis = (v / np.linalg.norm(v) for v in rng.normal(size=(2, 3)))
        R = se3.exp_so3(np.deg2rad(self.X_WC_error_deg) * axis)
        X_WC = se3.pose(R @ X_WC[:3, :3], X_WC[:3, 3] + 1e-3 * self.X_WC_error_mm * aside)
        return replace(lens, fx=longer * lens.fx, fy=longer * lens.fy), X_WC
