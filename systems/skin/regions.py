"""The regions of a frame with what speaks for each: centre of gravity, size, motion, and the look of a face."""

import numpy as np

from vipr.systems.skin.face_marks import face_marks
from vipr.systems.skin.scene import Scene


def describe(labels: np.ndarray, boxes: np.ndarray, skin: np.ndarray, scene: Scene):
    """Centres (n, 2), areas (n,), person (n,) and faceness (n,) of the labelled regions; pixels of ``labels``.

    Centres are weighted by ``skin`` (h, w) uint8, so that the border that the density adds counts little.
    """
    n = len(boxes)
    width = labels.shape[1]
    index = np.flatnonzero(labels)
    region = labels.ravel()[index].astype(np.int64) - 1
    weight = skin.ravel()[index] * (1.0 / 255.0)
    weight *= weight > 0.35
    count = np.bincount(region, minlength=n).astype(float)
    mass = np.bincount(region, weight, n)
    safe = np.maximum(mass, 1e-6)
    y, x = np.divmod(index, width)
    centres = np.stack([np.bincount(region, weight * x, n) / safe, np.bincount(region, weight * y, n) / safe], axis=1)
    alive = np.bincount(region, scene.alive.ravel()[index], n) / np.maximum(count, 1)
    known = np.bincount(region, scene.sure.ravel()[index], n) / np.maximum(count, 1)
    fill = count / np.maximum(boxes[:, 2] * boxes[:, 3], 1)
    faceness = _faceness(scene.luma, boxes, fill)
    person = 1.0 / (1.0 + np.exp(-(4.0 * alive + 3.0 * faceness - 3.0 * known - 0.8)))
    return centres, mass, person, faceness


def _faceness(luma: np.ndarray, boxes: np.ndarray, fill: np.ndarray) -> np.ndarray:
    """Marks of a face, discounted where the shape is not that of a head; looked for in the few most likely shapes only."""
    tall = boxes[:, 3] / np.maximum(boxes[:, 2], 1.0)
    shape = np.clip((fill - 0.25) / 0.3, 0.0, 1.0) * np.clip(3.2 - tall, 0.0, 1.0) * (tall > 0.7)
    faceness = np.zeros(len(boxes))
    likely = np.flatnonzero(shape > 0.1)[:4]
    if len(likely):
        faceness[likely] = np.clip(face_marks(luma, boxes[likely]) * shape[likely], 0.0, 1.0)
    return faceness
