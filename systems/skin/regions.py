"""The regions of a frame with what speaks for each: centre of gravity, size, motion, and the look of a face."""

from dataclasses import dataclass

import cv2
import numpy as np

from vipr.systems.skin.face_marks import face_marks
from vipr.systems.skin.scene import Scene


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
    width = labels.shape[1]
    index = np.flatnonzero(labels)
    region = labels.ravel()[index].astype(np.int64) - 1
    weight = skin.ravel()[index] * (1.0 / 255.0)
    weight *= weight > 0.35
    count = np.maximum(np.bincount(region, minlength=n), 1).astype(float)
    mass = np.bincount(region, weight, n)
    safe = np.maximum(mass, 1e-6)
    y, x = np.divmod(index, width)
    centres = np.stack([np.bincount(region, weight * x, n) / safe, np.bincount(region, weight * y, n) / safe], axis=1)
    alive = np.bincount(region, scene.alive.ravel()[index], n) / count
    known = np.bincount(region, scene.sure.ravel()[index], n) / count
    moving = np.bincount(region, scene.motion.ravel()[index], n) / count
    cores = find_cores(labels, boxes)
    faceness = np.zeros(n)
    sharp = np.clip(
        (cores[:, 2] / np.sqrt(labels.size / 19200.0) - 1.5) / 2.5, 0.0, 1.0
    )  # few pixels look like anything
    likely = np.flatnonzero((known < 0.8) & (sharp > 0.0))[:4]  # regions come by falling area
    if len(likely):
        faceness[likely] = sharp[likely] * np.clip(face_marks(luma, cores[likely]), 0.0, 1.0)
    person = 1.0 / (1.0 + np.exp(-(4.0 * alive + 3.0 * faceness - 3.0 * known - 0.8)))
    return Found(centres, mass, person, faceness, cores, moving)


def find_cores(labels: np.ndarray, boxes: np.ndarray) -> np.ndarray:
    """(n, 3) x, y, radius of the largest disc inside each region once its holes (eyes, mouth) are filled."""
    contours, _ = cv2.findContours((labels > 0).astype(np.uint8), cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_NONE)
    filled = np.zeros((labels.shape[0] + 2, labels.shape[1] + 2), np.uint8)
    cv2.drawContours(filled, contours, -1, 255, cv2.FILLED, offset=(1, 1))
    inside = cv2.distanceTransform(filled, cv2.DIST_L2, 3)[1:-1, 1:-1]
    cores = np.zeros((len(boxes), 3))
    for i, (x, y, w, h) in enumerate(boxes.astype(int)):
        part = np.where(labels[y : y + h, x : x + w] == i + 1, inside[y : y + h, x : x + w], 0.0)
        _, radius, _, (px, py) = cv2.minMaxLoc(part)
        cores[i] = x + px, y + py, radius
    return cores
