"""A picture of the object at a pose that is known beforehand, such as of a place that was shown: what the tracker need not learn.

Where the object is seen as in the picture, it is compared with the picture itself. What is wrong there with the edges, the model or the
light was wrong in the picture too, so the pose that was known comes back (Vacchetti, Lepetit and Fua 2004 call such views offline
keyframes).
"""

from dataclasses import dataclass, field, replace

import numpy as np

from vipr.systems import se3
from vipr.systems.camera.lens import Lens
from vipr.systems.errors import InputError
from vipr.systems.tracking.cad_model import CadModel
from vipr.systems.tracking.keyframes import Keyframe
from vipr.systems.tracking.learning import learn_keyframe
from vipr.systems.tracking.looks import HALF, LEVELS, pyramid
from vipr.systems.tracking.normal_flow import cut_patch

MARGIN = HALF * 2**LEVELS  # px around the object that its coarsest patches look at


@dataclass(frozen=True, eq=False)
class KnownView:
    """The picture (h, w) or (h, w, 3) BGR uint8 as the camera took it, the pose in it and its covariance (6, 6) of (w, v) in C."""

    image: np.ndarray
    X_CO: np.ndarray
    covariance: np.ndarray = field(default_factory=lambda: np.zeros((6, 6)))


def known_keyframe(view: KnownView, model: CadModel, lens: Lens, count: int) -> Keyframe | None:
    """The view as a keyframe of at most ``count`` patches that is never forgotten; None where the object shows too little texture.

    Raises InputError for what is no pose before the camera, and for a picture of another size than the lens's.
    """
    X_CO, size = np.asarray(view.X_CO, float), view.image.shape[:2]
    if size != (lens.height, lens.width):
        raise InputError(
            f"known view: its picture is {size[1]} x {size[0]} px, its lens is for {lens.width} x {lens.height} px"
        )
    corners = model.corners @ X_CO[:3, :3].T + X_CO[:3, 3] if se3.is_pose(X_CO) else np.full((1, 3), np.nan)
    if not (corners[:, 2] > 0).all():
        raise InputError("known view: X_CO must be a rigid 4x4 pose of the object before the camera")
    pixel = lens.project(corners)
    patch = cut_patch(lens.undistort(view.image), pixel.min(axis=0) - MARGIN, pixel.max(axis=0) + MARGIN)
    keyframe = learn_keyframe(pyramid(patch), model, X_CO, np.asarray(view.covariance, float), lens, count)
    return None if keyframe is None else replace(keyframe, lasting=True)
