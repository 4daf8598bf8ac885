"""Compilation of the inner loops of seeing people ahead of their first use: a drawn person waves, covers the face and leaves."""

import cv2
import numpy as np

from vipr.systems.hands.pipeline import PeopleBelief, see_people

SKIN = (105, 140, 205)  # BGR


def compile_people() -> None:
    """Compile, and keep beside the modules, all that frames of a camera (read-only) and of a video, small and reduced, need."""
    for scale, writable in ((1, True), (1, False), (2, True), (2, False)):
        belief = PeopleBelief()
        for k in range(16):
            image = picture(k, scale)
            image.setflags(write=writable)
            belief = see_people(image, 0.04 * k, k, belief)


def picture(k: int, scale: int) -> np.ndarray:
    """Frame k (120, 160, 3) BGR uint8 in pixels of ``scale``: a face, one hand that comes to it, and a bare arm that waves."""
    image = np.random.default_rng(k).integers(96, 104, (120, 160, 3)).astype(np.uint8)
    if k < 14:
        cv2.ellipse(image, (80, 34), (11, 15), 0, 0, 360, SKIN, -1)
        for eye in (76, 84):
            cv2.ellipse(image, (eye, 31), (3, 2), 0, 0, 360, (40, 50, 75), -1)
        cv2.circle(image, (40 + 3 * k, 76 - 3 * k), 6, SKIN, -1)
    cv2.line(image, (125, 90), (118 + 2 * (k % 4), 50), SKIN, 8)
    return np.kron(image, np.ones((scale, scale, 1), np.uint8))
