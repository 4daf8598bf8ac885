"""Finding an object that was lost, anywhere in the image, by what it looked like while it was tracked.

Keypoints of the pictures that keyframes were learnt from lie on the model's surface; those of the image that are like them (SIFT; Lowe,
IJCV 2004) give the pose by the POSE box of the paper, wrong matches thrown out.
Frames: O object, C camera.
"""

import cv2
import numpy as np

from vipr.systems.camera.lens import Lens
from vipr.systems.pose.estimate import estimate_pose
from vipr.systems.tracking.cad_model import CadModel
from vipr.systems.tracking.displacements import corner_shift
from vipr.systems.tracking.keyframes import Keyframe, keypoints
from vipr.systems.tracking.surface import surface_points

LIKE = 0.8  # distance of the best match, as a share of that of the second best, at most
ENOUGH = 8  # matches, and of them believed, that a pose needs
BELIEVED_PX = 3.0  # RMS distance of believed matches, at most
APART_PX = 5.0  # RMS of the corners between poses that are not the same


def recall(keyframes: tuple[Keyframe, ...], image: np.ndarray, model: CadModel, lens: Lens) -> list[np.ndarray]:
    """Poses at which the object in an image (h, w[, 3]) uint8 looks as in its keyframes, that with most matches first."""
    grey = cv2.cvtColor(image, cv2.COLOR_BGR2GRAY) if image.ndim == 3 else image
    pixel, look = keypoints(grey)
    if len(pixel) < ENOUGH:
        return []
    found = []
    for keyframe in keyframes:
        known, known_look = keyframe.keypoints
        if len(known) < ENOUGH:
            continue
        pairs = cv2.BFMatcher().knnMatch(known_look, look, k=2)
        alike = np.array([(a.queryIdx, a.trainIdx) for a, b in pairs if a.distance < LIKE * b.distance], int)
        if len(alike) < ENOUGH:
            continue
        p_C, _ = surface_points(model, keyframe.X_CO, lens, known[alike[:, 0]], None)
        on = np.isfinite(p_C[:, 2])
        if on.sum() < ENOUGH:
            continue
        p_O = (p_C[on] - keyframe.X_CO[:3, 3]) @ keyframe.X_CO[:3, :3]
        estimate = estimate_pose(p_O, pixel[alike[on, 1]], lens)
        if estimate.valid and estimate.inliers.sum() >= ENOUGH and estimate.residual_px < BELIEVED_PX:
            poses = [estimate.X_CO, *(X for X, _ in estimate.alternatives if estimate.ambiguous)]
            found.append((int(estimate.inliers.sum()), poses))
    distinct: list[np.ndarray] = []
    for _, poses in sorted(found, key=lambda one: -one[0]):
        distinct += [X for X in poses if all(corner_shift(model, lens, X, other) > APART_PX for other in distinct)]
    return distinct
