"""What one step of the tracker looks at and with, and what an attempt at the pose comes to."""

from dataclasses import dataclass, field

import numpy as np

from vipr.systems.camera.lens import Lens
from vipr.systems.tracking.cad_model import CadModel
from vipr.systems.tracking.diagnosis import Evidence
from vipr.systems.tracking.keyframes import Keyframe
from vipr.systems.tracking.looks import pyramid
from vipr.systems.tracking.motion_filter import Motion, surprise
from vipr.systems.tracking.normal_flow import cut_patch
from vipr.systems.tracking.small_algebra import invert


@dataclass(frozen=True, eq=False)
class Attempt:
    """Where the object was found, and what speaks for it."""

    X_CO: np.ndarray
    covariance: np.ndarray  # (6, 6) of what the image says, without the prediction
    evidence: Evidence
    # (6, 6) of the covariance, what is the same in the next frame: of edges, and of the keyframe's own pose.
    shared: np.ndarray = field(default_factory=lambda: np.zeros((6, 6)))
    ahead: Motion | None = None  # the prediction that it was weighed against
    led_by: Keyframe | None = None  # whose texture led there
    against: tuple[Keyframe, ...] = ()  # whose texture led, or would lead, elsewhere: overruled by the edges
    prune: bool = False  # patches that look wrong at this pose are not the object's


class Sight:
    """What one step looks at and with: the image, the model, what is known, and the patch of the image that the search needs."""

    def __init__(
        self,
        image,
        model: CadModel,
        lens: Lens,
        settings,
        occluders_C,
        belief,
        ahead: Motion,
        dt: float,
        steady: Motion,
    ):
        self.image, self.model, self.lens, self.settings, self.occluders_C = image, model, lens, settings, occluders_C
        self.keyframes, self.doubtful = belief.keyframes, belief.doubtful
        self.X_CO_last, self.V_CO, self.dt = belief.X_CO, belief.V_CO, dt
        self.steady = steady
        self.expect(ahead)
        self.patch, self._pyramid = None, None

    def expect(self, ahead: Motion) -> None:
        """Take this prediction as the prior of the fits."""
        self.ahead = ahead
        self.X_CO_ahead, self.information = ahead.X_CO, invert(np.ascontiguousarray(ahead.covariance[:6, :6]))

    def goes_steadily(self, X_CO: np.ndarray, limit: float = 25.0) -> bool:
        """Whether a pose is what the motion so far leads to (squared Mahalanobis distance of six parameters below the limit)."""
        return surprise(self.steady.X_CO, self.steady.covariance, X_CO) < limit

    def open(self, poses: list[np.ndarray], margin: float) -> None:
        """Cut the patch that holds the model at all the poses, and margin [px] around it."""
        corners = np.concatenate([self.model.corners @ X[:3, :3].T + X[:3, 3] for X in poses])
        corners = corners[corners[:, 2] > 1e-3]
        pixel = self.lens.project(corners) if len(corners) else np.full((1, 2), -1e6)
        self.patch = cut_patch(self.image, pixel.min(0) - margin, pixel.max(0) + margin, self.settings.colour)
        self._pyramid = None

    @property
    def pyramid(self):
        if self._pyramid is None:
            self._pyramid = pyramid(self.patch)
        return self._pyramid
