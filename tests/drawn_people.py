"""Drawn people for tests: a face with eyes and a mouth and two hands of skin colour before a room that is not."""

import cv2
import numpy as np

SKIN = (105, 140, 205)  # BGR
FACE, LEFT, RIGHT = (80, 34), (116, 80), (44, 80)  # px at 160 x 120; the person's left hand is on the image's right


def person(left=LEFT, right=RIGHT, face=FACE, seed=0, light=(1.0, 1.0, 1.0)):
    """A picture (120, 160, 3) BGR uint8 with noise; a part that is None is not there. ``light`` multiplies B, G, R."""
    image = np.full((120, 160, 3), (120, 112, 98), np.uint8)
    image[:, ::16] = (90, 96, 84)
    cv2.rectangle(image, (62, 52), (98, 119), (120, 60, 40), -1)
    if face is not None:
        x, y = face
        cv2.ellipse(image, (x, y), (11, 15), 0, 0, 360, SKIN, -1)
        for eye in (x - 4, x + 4):
            cv2.ellipse(image, (eye, y - 3), (3, 2), 0, 0, 360, (40, 50, 75), -1)
        cv2.ellipse(image, (x, y + 8), (4, 1), 0, 0, 360, (60, 70, 120), -1)
    for hand in (left, right):
        if hand is not None:
            cv2.circle(image, hand, 6, SKIN, -1)
    noise = np.random.default_rng(seed).normal(0.0, 1.5, image.shape)
    return np.clip(np.rint(image * np.array(light) + noise), 0, 255).astype(np.uint8)


def waving(k, **parts):
    """Frame k at 25 Hz of a person whose hands go up and down in turn."""
    shift = round(14 * np.sin(0.3 * k))
    hands = {"left": (LEFT[0], LEFT[1] + shift), "right": (RIGHT[0], RIGHT[1] - shift)}
    return person(**(hands | parts), seed=k)
