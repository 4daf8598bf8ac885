"""Keyframes: patches of the object's faces seen at one pose, their places on the model and their looks at several scales.

Frames: O object, C camera.
"""

from dataclasses import dataclass, field, replace
from functools import cached_property

import cv2
import numpy as np

from vipr.systems.compiled import compiled
from vipr.systems.tracking.displacements import difference
from vipr.systems.tracking.normal_flow import Patch


@dataclass(frozen=True, eq=False)
class Keyframe:
    """M patches seen at one pose."""

    X_CO: np.ndarray  # (4, 4)
    covariance: np.ndarray  # (6, 6) of that pose
    p_O: np.ndarray  # (M, 3) m, centres
    normal_O: np.ndarray  # (M, 3) of the surface
    axes_O: np.ndarray  # (M, 2, 3) m on the surface for one pixel along x and y of the keyframe
    looks: np.ndarray  # (LEVELS, M, P) samples, mean removed, length one; zero where the patch has no contrast
    gradient: np.ndarray  # (LEVELS, 2, M, P) of looks by the keyframe's level pixels along x and y
    trust: float = 1.0  # 0 to 1, probability that the pose was right
    fit_px: float = 0.0  # residual of the edges at that pose
    # (6, 6) of that pose, beside the covariance: what was the same in all frames up to then and had not averaged out.
    shared: np.ndarray = field(default_factory=lambda: np.zeros((6, 6)))
    lasting: bool = False  # known beforehand: kept whatever is seen
    picture: Patch | None = None  # what it was learnt from

    def __len__(self):
        return len(self.p_O)

    @cached_property
    def alive(self) -> np.ndarray:
        """(LEVELS, M) whether the patch has contrast at the level."""
        return self.looks.any(2)

    @cached_property
    def keypoints(self) -> tuple[np.ndarray, np.ndarray]:
        """Pixels (N, 2) of the keypoints in the picture that it was learnt from, and their descriptors (N, 128)."""
        if self.picture is None:
            return np.zeros((0, 2)), np.zeros((0, 128), np.float32)
        pixel, look = keypoints(np.clip(self.picture.grey, 0, 255).astype(np.uint8))
        return pixel + self.picture.origin, look

    def without(self, numbers: np.ndarray) -> "Keyframe":
        """The keyframe without the patches of these numbers."""
        kept = np.setdiff1d(np.arange(len(self)), numbers)
        return replace(
            self,
            p_O=self.p_O[kept],
            normal_O=self.normal_O[kept],
            axes_O=self.axes_O[kept],
            looks=self.looks[:, kept],
            gradient=self.gradient[:, :, kept],
        )


def keypoints(grey: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Pixels (N, 2) of the SIFT keypoints of a grey image (h, w) uint8, and their descriptors (N, 128)."""
    found, look = cv2.SIFT_create(nfeatures=1000).detectAndCompute(grey, None)
    if not found:
        return np.zeros((0, 2)), np.zeros((0, 128), np.float32)
    return np.array([k.pt for k in found]), look


def choose_keyframe(keyframes: tuple[Keyframe, ...], X_CO: np.ndarray, limit: float = 0.6) -> Keyframe | None:
    """The keyframe seen most like X_CO (angle [rad] of the view plus change of size); the oldest of equals; None beyond the limit."""
    best, least = None, limit
    for keyframe in keyframes:
        away = view_difference(keyframe.X_CO, X_CO)
        if away < least - 0.02:
            best, least = keyframe, away
    return best


@compiled
def view_difference(X_CA: np.ndarray, X_CB: np.ndarray) -> float:
    """How differently two poses show the object: rotation [rad] out of the image plane, half of that in it, and |log of scale|."""
    w = difference(X_CA, X_CB)
    x, y, z = X_CB[0, 3], X_CB[1, 3], X_CB[2, 3]
    roll = (w[0] * x + w[1] * y + w[2] * z) / max(np.sqrt(x * x + y * y + z * z), 1e-12)
    out = np.sqrt(max(w[0] ** 2 + w[1] ** 2 + w[2] ** 2 - roll * roll, 0.0))
    return out + 0.5 * abs(roll) + abs(np.log(max(X_CA[2, 3], 1e-6) / max(X_CB[2, 3], 1e-6)))
