"""What always stood there, what moves, and how the light changed: the cues beside colour.

A running picture of the still scene gives two things that colour alone cannot: walls and wood of skin's colour are known by never
changing, and the ratio of the present picture to it is the change of the light (diagonal model), robustly by its median.
"""

from dataclasses import dataclass, replace

import cv2
import numpy as np

from vipr.systems.compiled import compiled

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
    ratio, usable = _ratios(raw, scene.pixels, scene.alive, step)
    calm = usable == 2
    if np.count_nonzero(calm) <= 0.25 * len(usable):
        calm = usable > 0
    if np.count_nonzero(calm) < 60:
        return gains
    ratio = ratio[calm]
    middle = len(ratio) // 2
    fresh = np.partition(ratio, middle, axis=0)[middle]
    spread = np.partition(np.abs(ratio[:, 1] / fresh[1] - 1.0), middle)[middle]
    if spread > 0.25:  # another view, not another light
        return gains
    return np.clip(fresh, 0.15, 6.0)


@compiled
def _ratios(raw, then, alive, step):
    """(n, 3) the scene over the picture at every ``step``-th place; and (n,) 2 where calm and well exposed, 1 well exposed, 0 not."""
    rows, columns = (raw.shape[0] + step - 1) // step, (raw.shape[1] + step - 1) // step
    ratio = np.ones((rows * columns, 3), np.float32)
    usable = np.zeros(rows * columns, np.uint8)
    for i in range(rows):
        for j in range(columns):
            now, was = raw[i * step, j * step], then[i * step, j * step]
            if (
                min(now[0], now[1], now[2]) > 8
                and max(now[0], now[1], now[2]) < 250
                and min(was[0], was[1], was[2]) > 4
            ):
                k = i * columns + j
                usable[k] = 2 if alive[i * step, j * step] < 0.3 else 1
                for c in range(3):
                    ratio[k, c] = was[c] / now[c]
    return ratio, usable


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
    some = np.abs(luma[::6, ::6] - scene.luma[::6, ::6]).ravel()
    level = float(np.partition(some, len(some) // 2)[len(some) // 2]) * 1.5
    noise = max(1.0, brighter) * scene.noise
    noise = 0.9 * noise + 0.1 * min(max(level, 0.5), 12.0)
    # Beyond all of the neighbourhood then: an edge under a trembling camera is not motion.
    highest, lowest = cv2.dilate(scene.luma, _NEIGHBOURS), cv2.erode(scene.luma, _NEIGHBOURS)
    moved = _beyond(luma, lowest, highest, np.float32(3.0 + 2.5 * noise))
    # A lone noisy pixel is not motion: a third of the 3x3 neighbours must agree.
    moved *= cv2.blur(moved, (3, 3)) > 0.3
    near = cv2.blur(moved, (kernel, kernel))
    fade, forget = np.float32(0.5 ** (dt / MOTION_HALF_LIFE)), np.float32(0.5 ** (dt / ALIVE_HALF_LIFE))
    motion, alive, stood = _remember(moved, near, scene.motion, scene.alive, scene.sure, fade, forget)
    _keep_same(stood, pixels, scene.pixels, luma, np.float32(5.0 + 4.0 * noise))
    return Scene(scene.pixels, scene.sure, scene.luma, motion, alive, noise), stood


@compiled
def _beyond(luma, lowest, highest, margin):
    moved = np.empty(luma.shape, np.float32)
    for i in range(luma.shape[0]):
        for j in range(luma.shape[1]):
            moved[i, j] = luma[i, j] > highest[i, j] + margin or luma[i, j] < lowest[i, j] - margin
    return moved


@compiled
def _remember(moved, near, motion, alive, sure, fade, forget):
    new_motion, new_alive, stood = np.empty_like(motion), np.empty_like(alive), np.empty_like(sure)
    for i in range(moved.shape[0]):
        for j in range(moved.shape[1]):
            new_motion[i, j] = max(motion[i, j] * fade, moved[i, j])
            new_alive[i, j] = max(alive[i, j] * forget, min(near[i, j] * np.float32(6.0), np.float32(1.0)))
            stood[i, j] = sure[i, j]
    return new_motion, new_alive, stood


@compiled
def _is_same(now, then, luma, margin):
    """Whether no channel differs by more than noise and a little of the brightness."""
    away = max(abs(now[0] - then[0]), abs(now[1] - then[1]), abs(now[2] - then[2]))
    return away < margin + np.float32(0.04) * luma


@compiled
def _keep_same(stood, pixels, then, luma, margin):
    for i in range(luma.shape[0]):
        for j in range(luma.shape[1]):
            if not _is_same(pixels[i, j], then[i, j], luma[i, j], margin):
                stood[i, j] = 0.0


def forget(scene: Scene, where: np.ndarray) -> Scene:
    """The scene of which nothing is known ``where`` (h, w) is not zero: what stood there has come alive."""
    return replace(scene, sure=scene.sure * (where == 0))


def settle(scene: Scene, pixels: np.ndarray, person: np.ndarray, dt: float) -> Scene:
    """The scene after ``dt`` s in which pixels outside ``person`` (h, w) bool that did not change became surer background."""
    picture, sure = _settle(
        scene.pixels,
        scene.sure,
        scene.luma,
        scene.motion,
        pixels,
        person,
        np.float32(5.0 + 4.0 * scene.noise),
        np.float32(dt),
    )
    return Scene(picture, sure, brightness(pixels), scene.motion, scene.alive, scene.noise)


@compiled
def _settle(then, sure, luma, motion, pixels, person, margin, dt):
    picture, surer = np.empty_like(then), np.empty_like(sure)
    for i in range(sure.shape[0]):
        for j in range(sure.shape[1]):
            same = _is_same(pixels[i, j], then[i, j], luma[i, j], margin)
            step = dt / SETTLE if same else -dt / FORGET
            if person[i, j] or motion[i, j] > 0.25:
                step = -dt / (8 * FORGET)
            surer[i, j] = min(max(sure[i, j] + step, 0.0), 1.0)
            rate = min(1.0, 1.5 * dt) if same else 0.0
            if surer[i, j] <= 0.0:
                rate = 1.0
            for c in range(3):
                picture[i, j, c] = then[i, j, c] + rate * (pixels[i, j, c] - then[i, j, c])
    return picture, surer
