"""The regions of a frame with what speaks for each: centre of gravity, size, motion, and the look of a face."""

from dataclasses import dataclass

import cv2
import numpy as np

from vipr.systems.compiled import compiled
from vipr.systems.skin.face_marks import face_marks
from vipr.systems.skin.scene import Scene
from vipr.systems.skin.working_image import unit


@dataclass(frozen=True, eq=False)
class Found:
    """The regions of one frame, in pixels of the labels."""

    centres: (
        np.ndarray
    )  # (n, 2) centre of gravity, weighted by skin, so that the border that the density adds counts little
    areas: np.ndarray  # (n,)
    person: np.ndarray  # (n,) 0 to 1
    faceness: np.ndarray  # (n,) 0 to 1
    cores: np.ndarray  # (n, 3) x, y, radius
    moving: np.ndarray  # (n,) 0 to 1


def describe(labels: np.ndarray, boxes: np.ndarray, skin: np.ndarray, luma: np.ndarray, scene: Scene) -> Found:
    """What speaks for each of the labelled regions; ``skin`` (h, w) uint8, boxes (n, 4) x y w h."""
    n = len(boxes)
    sums = _sums(labels, skin, scene.alive, scene.sure, scene.motion, n)
    mass = sums[:, 1]
    centres = sums[:, 2:4] / np.maximum(mass, 1e-6)[:, None]
    alive, known, moving = (sums[:, 4:] / np.maximum(sums[:, :1], 1.0)).T
    cores = find_cores(labels, boxes)
    faceness = np.zeros(n)
    sharp = np.clip((cores[:, 2] / unit(labels.shape) - 1.5) / 2.5, 0.0, 1.0)  # few pixels look like anything
    likely = np.flatnonzero((known < 0.8) & (sharp > 0.0))[:4]  # regions come by falling area
    if len(likely):
        faceness[likely] = sharp[likely] * face_marks(luma, cores[likely])
    person = 1.0 / (1.0 + np.exp(-(4.0 * alive + 3.0 * faceness - 3.0 * known - 0.8)))
    return Found(centres, mass, person, faceness, cores, moving)


@compiled
def _sums(labels, skin, alive, sure, motion, n):
    """(n, 7) of each region: pixels, skin, skin times x and y; how much of it was alive, is surely background, moves."""
    sums = np.zeros((n, 7))
    for y in range(labels.shape[0]):
        for x in range(labels.shape[1]):
            k = int(labels[y, x]) - 1
            if k >= 0:
                weight = skin[y, x] / 255.0
                if weight <= 0.35:
                    weight = 0.0
                sums[k, 0] += 1.0
                sums[k, 1] += weight
                sums[k, 2] += weight * x
                sums[k, 3] += weight * y
                sums[k, 4] += alive[y, x]
                sums[k, 5] += sure[y, x]
                sums[k, 6] += motion[y, x]
    return sums


def find_cores(labels: np.ndarray, boxes: np.ndarray) -> np.ndarray:
    """(n, 3) x, y, radius of the largest disc inside each region once its holes (eyes, mouth) are filled."""
    if not len(boxes):
        return np.zeros((0, 3))
    (x0, y0), (x1, y1) = boxes[:, :2].min(0).astype(int), (boxes[:, :2] + boxes[:, 2:]).max(0).astype(int)
    outside = cv2.copyMakeBorder(labels[y0:y1, x0:x1], 1, 1, 1, 1, cv2.BORDER_CONSTANT, value=0)
    cv2.floodFill(outside, None, (0, 0), 255)
    filled = cv2.threshold(outside, 254, 1, cv2.THRESH_BINARY_INV)[1]
    inside = cv2.distanceTransform(filled, cv2.DIST_L2, 3)[1:-1, 1:-1]
    return _deepest(labels, inside, x0, y0, len(boxes))


@compiled
def _deepest(labels, inside, x0, y0, n):
    """(n, 3) x, y and depth of the first deepest pixel of each region; ``inside`` begins at x0, y0."""
    cores = np.zeros((n, 3))
    for y in range(inside.shape[0]):
        for x in range(inside.shape[1]):
            k = int(labels[y0 + y, x0 + x]) - 1
            if k >= 0 and inside[y, x] > cores[k, 2]:
                cores[k, 0], cores[k, 1], cores[k, 2] = x0 + x, y0 + y, inside[y, x]
    return cores
