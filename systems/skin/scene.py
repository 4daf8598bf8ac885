"""What always stood there, what moves, and how the light changed: the cues beside colour.

A running picture of the still scene gives two things that colour alone cannot: walls and wood of skin's colour are known by never
changing, and the ratio of the present picture to it is the change of the light (diagonal model), robustly by its median.
"""

from dataclasses import dataclass

import cv2
import numpy as np

SETTLE = 1.2  # s after which an unchanging pixel is surely background
FORGET = 0.6  # s after which a changed pixel is no longer
MOTION_HALF_LIFE = 0.35  # s, of the motion energy
ALIVE_HALF_LIFE = 4.0  # s, for which a place where something moved is kept out of the background
_NEIGHBOURS = np.ones((3, 3), np.uint8)
SAMPLES = 1200  # pixels that the light is judged by
_LUMA = np.array([[0.25, 0.5, 0.25]], np.float32)


@dataclass(frozen=True, eq=False)
class Scene:
    """The still scene at working resolution, in the light's coordinates (pixels times gains)."""

    pixels: np.ndarray  # (h, w, 3) float32 BGR
    sure: np.ndarray  # (h, w) float32, 0 to 1: known to be background
    luma: np.ndarray  # (h, w) float32 of about 0.1 s before
    motion: np.ndarray  # (h, w) float32, 0 to 1: moved just now
    alive: np.ndarray  # (h, w) float32, 0 to 1: something moved near here in the last seconds
    noise: float = 2.0  # grey levels, of the difference of two frames


def brightness(pixels: np.ndarray) -> np.ndarray:
    """(h, w) float32 of pixels (h, w, 3)."""
    return cv2.transform(pixels, _LUMA)


def new_scene(pixels: np.ndarray) -> Scene:
    """The scene after its first frame (h, w, 3) float32: nothing is known to be background."""
    zero = np.zeros(pixels.shape[:2], np.float32)
    return Scene(pixels, zero, brightness(pixels), zero, zero)


def light_change(raw: np.ndarray, scene: Scene, gains: np.ndarray) -> np.ndarray:
    """(3,) gains that bring the picture raw (h, w, 3) uint8 to the still scene's light; ``gains`` where too little of it is visible."""
    step = max(3, round((raw.shape[0] * raw.shape[1] / SAMPLES) ** 0.5))
    now, then = (a[::step, ::step].reshape(-1, 3).astype(np.float32) for a in (raw, scene.pixels))
    usable = (now > 8).all(1) & (now < 250).all(1) & (then > 4).all(1)
    calm = usable & (scene.alive[::step, ::step].ravel() < 0.3)
    if np.count_nonzero(calm) > 0.25 * len(calm):
        usable = calm
    if np.count_nonzero(usable) < 60:
        return gains
    ratio = then[usable] / now[usable]
    middle = len(ratio) // 2
    fresh = np.partition(ratio, middle, axis=0)[middle]
    spread = np.partition(np.abs(ratio[:, 1] / fresh[1] - 1.0), middle)[middle]
    if spread > 0.25:  # another view, not another light
        return gains
    return np.clip(fresh, 0.15, 6.0)


def is_cut(pixels: np.ndarray, scene: Scene) -> bool:
    """Whether this is a picture of something else: most of it differs from the frame before."""
    luma = brightness(pixels)[::3, ::3]
    difference = np.abs(luma - scene.luma[::3, ::3])
    return np.count_nonzero(difference > 18.0 + 6.0 * scene.noise) > 0.5 * difference.size


def watch(pixels: np.ndarray, scene: Scene, kernel: int, dt: float, brighter: float = 1.0) -> tuple[Scene, np.ndarray]:
    """The scene after ``dt`` s with its motion; and (h, w) float32, 0 to 1, how surely each pixel shows what always stood there.

    ``brighter`` is the factor by which the gains have grown since the frame before: noise grows with them.
    """
    luma = brightness(pixels)
    # Beyond all of the neighbourhood then: an edge under a trembling camera is not motion.
    above = cv2.subtract(luma, cv2.dilate(scene.luma, _NEIGHBOURS))
    below = cv2.subtract(cv2.erode(scene.luma, _NEIGHBOURS), luma)
    difference = cv2.max(above, below)
    some = np.abs(luma[::6, ::6] - scene.luma[::6, ::6]).ravel()
    level = float(np.partition(some, len(some) // 2)[len(some) // 2]) * 1.5
    noise = max(1.0, brighter) * scene.noise
    noise = 0.9 * noise + 0.1 * min(max(level, 0.5), 12.0)
    moved = (difference > 3.0 + 2.5 * noise).astype(np.float32)
    # A lone noisy pixel is not motion: a third of the 3x3 neighbours must agree.
    moved *= cv2.blur(moved, (3, 3)) > 0.3
    motion = np.maximum(scene.motion * np.float32(0.5 ** (dt / MOTION_HALF_LIFE)), moved)
    near = np.minimum(cv2.blur(moved, (kernel, kernel)) * 6.0, 1.0)
    alive = np.maximum(scene.alive * np.float32(0.5 ** (dt / ALIVE_HALF_LIFE)), near)
    stood = np.where(_same(pixels, scene.pixels, luma, noise), scene.sure, np.float32(0.0))
    return Scene(scene.pixels, scene.sure, scene.luma, motion, alive, noise), stood


def _same(pixels: np.ndarray, then: np.ndarray, luma: np.ndarray, noise: float) -> np.ndarray:
    """(h, w) bool, where no channel differs by more than noise and a little of the brightness."""
    away = cv2.absdiff(pixels, then)
    most = np.maximum(np.maximum(away[:, :, 0], away[:, :, 1]), away[:, :, 2])
    return most < np.float32(5.0 + 4.0 * noise) + np.float32(0.04) * luma


def settle(scene: Scene, pixels: np.ndarray, person: np.ndarray, dt: float) -> Scene:
    """The scene after ``dt`` s in which pixels outside ``person`` (h, w) bool that did not change became surer background."""
    same = _same(pixels, scene.pixels, scene.luma, scene.noise)
    guarded = person | (scene.motion > 0.25)
    step = np.where(same, np.float32(dt / SETTLE), np.float32(-dt / FORGET))
    step[guarded] = -dt / (8 * FORGET)
    sure = np.clip(scene.sure + step, 0.0, 1.0)
    rate = np.where(same, np.float32(min(1.0, dt * 1.5)), np.float32(0.0))
    rate[sure <= 0.0] = 1.0
    picture = scene.pixels + rate[:, :, None] * (pixels - scene.pixels)
    return Scene(picture, sure, brightness(pixels), scene.motion, scene.alive, scene.noise)
