"""Compilation of the tracker's inner loops ahead of their first use: it tracks a drawn box through everything they are for."""

import cv2
import numpy as np

from vipr.systems import se3
from vipr.systems.camera.lens import Lens
from vipr.systems.tracking.belief import start
from vipr.systems.tracking.cad_model import Shape, build_model
from vipr.systems.tracking.displacements import move
from vipr.systems.tracking.model_tracking import step

LENS = Lens(320, 240, 400.0, 400.0, 159.5, 119.5)
SIDE = 64  # px of a face's print
CORNERS = 0.05 * np.array([[i, j, k] for i in (-1, 1) for j in (-1, 1) for k in (-1, 1)])
FACES = ((0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3))


def compile_tracker() -> None:
    """Compile, and keep beside the modules, all that tracking printed and plain, convex and other bodies in grey and colour needs."""
    prints = np.random.default_rng(0).integers(40, 220, (len(FACES), 8, 8)).astype(np.uint8)
    box = build_model(Shape("box", CORNERS, FACES))
    beside = (np.array([0.08, 0.0, -0.03]), np.array([0.08, 0.0, 0.03]), 0.01)
    two_bodies = build_model(Shape("box and can", CORNERS, FACES, cylinders=(beside,)))
    hand = np.array([[[0.5, 0.5, 0.1], [0.6, 0.5, 0.1], [0.5, 0.6, 0.1]]])
    for model, printed, colour, occluders in ((box, True, False, None), (two_bodies, False, True, hand)):
        X_CO = se3.pose(se3.exp_so3(np.array([0.5, 0.6, 0.1])), np.array([0.0, 0.0, 0.5]))
        belief = start(X_CO)
        for k in range(4):
            image = picture(X_CO, prints if printed else prints[:, :1, :1])
            image = cv2.cvtColor(image, cv2.COLOR_GRAY2BGR) if colour else image
            belief = step(belief, image, 0.04 * k, model, LENS, occluders_C=occluders)
            jump = 0.3 if k == 2 else 0.02  # the last one is a loss
            X_CO = move(X_CO, np.array([jump, jump, 0.0, 0.002, 0.0, 0.0]))


def picture(X_CO, prints):
    """The box's faces with their prints before a grey ground."""
    image = np.full((LENS.height, LENS.width), 20, np.uint8)
    p_C = CORNERS @ X_CO[:3, :3].T + X_CO[:3, 3]
    pixel = LENS.project(p_C).astype(np.float32)
    square = np.array([[0, 0], [SIDE, 0], [SIDE, SIDE], [0, SIDE]], np.float32)
    for face, look in zip(FACES, prints, strict=True):
        a, b, _, d = p_C[list(face)]
        if np.cross(b - a, d - a) @ a < 0:  # seen from outside
            H = cv2.getPerspectiveTransform(square, pixel[list(face)])
            look = cv2.resize(look, (SIDE, SIDE), interpolation=cv2.INTER_NEAREST)
            seen = cv2.warpPerspective(np.full((SIDE, SIDE), 255, np.uint8), H, (LENS.width, LENS.height)) > 127
            image[seen] = cv2.warpPerspective(look, H, (LENS.width, LENS.height))[seen]
    return image
