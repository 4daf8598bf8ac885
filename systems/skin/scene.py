"""What always stood there, what moves, and how the light changed: the cues beside colour.

A running picture of the still scene gives two things that colour alone cannot: walls and wood of skin's colour are known by never
changing, and the ratio of the present picture to it is the change of the light (diagonal model), robustly by its median.
"""

from dataclasses import dataclass, replace

import cv2
import numpy as np

from vipr.systems.compiled import compiled
from vipr.systems.skin.chromaticity import LUMA, Chromaticity

SETTLE = 1.2  # s after which an unchanging pixel is surely background
FORGET = 0.6  # s after which a changed pixel is no longer
MOTION_HALF_LIFE = 0.35  # s, of the motion energy
ALIVE_HALF_LIFE = 4.0  # s, for which a place where something moved is kept out of the background
SAMPLES = 1200  # pixels that the light is judged by


@dataclass(frozen=True, eq=False)
class Scene:
    """The still scene at working resolution, in the light's coordinates (pixels times gains)."""

    pixels: np.ndarray  # (h, w, 3) float32 BGR
    sure: np.ndarray  # (h, w) float32, 0 to 1: known to be background
    luma: np.ndarray  # (h, w) float32 of about 0.1 s before
    motion: np.ndarray  # (h, w) float32, 0 to 1: moved just now
    alive: np.ndarray  # (h, w) float32, 0 to 1: something moved near here in the last seconds
    noise: float = 2.0  # grey levels, of the difference of two frames


def new_scene(colours: Chromaticity) -> Scene:
    """The scene after its first frame: nothing is known to be background."""
    zero = np.zeros(colours.luma.shape, np.float32)
    return Scene(colours.pixels, zero, colours.luma, zero, zero)


def light_change(raw: np.ndarray, scene: Scene, gains: np.ndarray) -> np.ndarray:
    """(3,) gains that bring the picture raw (h, w, 3) uint8 to the still scene's light; ``gains`` where too little of it is visible."""
    step = max(3, round((raw.shape[0] * raw.shape[1] / SAMPLES) ** 0.5))
    places = (-(raw.shape[0] // -step)) * (-(raw.shape[1] // -step))
    ratio = _ratios(raw, scene.pixels, scene.alive, step, np.float32(0.3))
    if ratio.shape[1] <= 0.25 * places:
        ratio = _ratios(raw, scene.pixels, scene.alive, step, np.float32(np.inf))
    if ratio.shape[1] < 60:
        return gains
    fresh, spread = _medians(ratio)
    return np.clip(fresh, 0.15, 6.0) if spread <= 0.25 else gains  # beyond, it is another view, not another light


@compiled
def _ratios(raw, then, alive, step, calm):
    """(3, n) the scene over the picture at every ``step``-th place that is well exposed and where less than ``calm`` is alive."""
    rows, columns = (raw.shape[0] + step - 1) // step, (raw.shape[1] + step - 1) // step
    ratio = np.empty((3, rows * columns), np.float32)
    n = 0
    for i in range(0, raw.shape[0], step):
        for j in range(0, raw.shape[1], step):
            b, g, r = raw[i, j, 0], raw[i, j, 1], raw[i, j, 2]
            if alive[i, j] < calm and min(b, g, r) > 8 and max(b, g, r) < 250:
                was = then[i, j]
                if min(was[0], was[1], was[2]) > 4:
                    ratio[0, n], ratio[1, n], ratio[2, n] = was[0] / b, was[1] / g, was[2] / r
                    n += 1
    return ratio[:, :n]


@compiled
def _medians(ratio):
    """(3,) of the channels, and that of how far green is from its own, as a share of it."""
    middle, fresh = ratio.shape[1] // 2, np.empty(3)
    for c in range(3):
        fresh[c] = np.partition(ratio[c], middle)[middle]
    return fresh, np.partition(np.abs(ratio[1] / np.float32(fresh[1]) - np.float32(1.0)), middle)[middle]


def is_cut(colours: Chromaticity, scene: Scene) -> bool:
    """Whether this is a picture of something else: most of it differs from the frame before."""
    return bool(_differing(colours.luma, scene.luma, np.float32(18.0 + 6.0 * scene.noise)) > 0.5)


@compiled
def _differing(now, then, margin):
    """The share of every third pixel that differs by more than the margin."""
    n, rows, columns = 0, (now.shape[0] + 2) // 3, (now.shape[1] + 2) // 3
    for i in range(0, now.shape[0], 3):
        for j in range(0, now.shape[1], 3):
            n += abs(now[i, j] - then[i, j]) > margin
    return n / (rows * columns)


def watch(
    colours: Chromaticity, scene: Scene, kernel: int, dt: float, brighter: float = 1.0
) -> tuple[Scene, np.ndarray]:
    """The scene after ``dt`` s with its motion; and (h, w) float32, 0 to 1, how surely each pixel shows what always stood there.

    ``brighter`` is the factor by which the gains have grown since the frame before: noise grows with them.
    """
    luma = colours.luma
    level = 1.5 * float(_usual_change(luma, scene.luma))
    noise = max(1.0, brighter) * scene.noise
    noise = 0.9 * noise + 0.1 * min(max(level, 0.5), 12.0)
    moved = _beyond(luma, scene.luma, np.float32(3.0 + 2.5 * noise))
    moved = _together(moved, _sum_about(moved, 3))
    near, nearly_all = _sum_about(moved, kernel), np.float32(6.0 / kernel**2)
    fade, forget = np.float32(0.5 ** (dt / MOTION_HALF_LIFE)), np.float32(0.5 ** (dt / ALIVE_HALF_LIFE))
    margin = np.float32(5.0 + 4.0 * noise)
    motion, alive, stood = _remember(
        moved, near, nearly_all, scene.motion, scene.alive, scene.sure, fade, forget,
        colours.pixels, scene.pixels, luma, margin,
    )  # fmt: skip
    return Scene(scene.pixels, scene.sure, scene.luma, motion, alive, noise), stood


def _sum_about(moved: np.ndarray, kernel: int) -> np.ndarray:
    """(h, w) uint16: how many pixels moved in the square of ``kernel`` about each."""
    return cv2.boxFilter(moved, cv2.CV_16U, (kernel, kernel), normalize=False)


@compiled
def _usual_change(now, then):
    """Median difference of every sixth pixel of two pictures [grey levels]."""
    rows, columns = (now.shape[0] + 5) // 6, (now.shape[1] + 5) // 6
    some = np.empty(rows * columns, np.float32)
    for i in range(rows):
        for j in range(columns):
            some[i * columns + j] = abs(now[6 * i, 6 * j] - then[6 * i, 6 * j])
    return np.partition(some, len(some) // 2)[len(some) // 2]


@compiled
def _beyond(luma, before, margin):
    """(h, w) uint8, 1 where a pixel is darker or brighter than all of its neighbourhood was before, by more than the margin.

    An edge under a trembling camera is not motion then.
    """
    rows, columns = luma.shape
    moved = np.empty(luma.shape, np.uint8)
    highest, lowest = np.empty(columns + 2, np.float32), np.empty(columns + 2, np.float32)
    for i in range(rows):
        above, here, below = before[max(i - 1, 0)], before[i], before[min(i + 1, rows - 1)]
        for j in range(columns):
            a, b, c = above[j], here[j], below[j]
            high, low = (a, b) if a > b else (b, a)
            highest[j + 1], lowest[j + 1] = c if c > high else high, c if c < low else low
        highest[0], lowest[0], highest[columns + 1], lowest[columns + 1] = -np.inf, np.inf, -np.inf, np.inf
        for j in range(columns):
            a, b, c = highest[j], highest[j + 1], highest[j + 2]
            high = a if a > b else b
            high = c if c > high else high
            a, b, c = lowest[j], lowest[j + 1], lowest[j + 2]
            low = a if a < b else b
            low = c if c < low else low
            moved[i, j] = (luma[i, j] > high + margin) | (luma[i, j] < low - margin)
    return moved


@compiled
def _together(moved, about):
    """What moved without lone noisy pixels: a third of the 3x3 neighbours must agree."""
    out = np.empty_like(moved)
    for i in range(moved.shape[0]):
        for j in range(moved.shape[1]):
            out[i, j] = moved[i, j] if about[i, j] >= 3 else 0
    return out


@compiled
def _remember(moved, near, nearly_all, motion, alive, sure, fade, forget, pixels, then, luma, margin):
    """Motion, what is alive and what stood; flat and by choices, as the processor does many pixels at a time."""
    n, one = moved.size, np.float32(1.0)
    moved_, near_, motion_, alive_ = moved.reshape(n), near.reshape(n), motion.reshape(n), alive.reshape(n)
    new_motion, new_alive = np.empty(n, np.float32), np.empty(n, np.float32)
    for k in range(n):
        before, now = motion_[k] * fade, np.float32(moved_[k])
        new_motion[k] = before if before > now else now
        before, now = alive_[k] * forget, np.float32(near_[k]) * nearly_all
        now = now if now < one else one
        new_alive[k] = before if before > now else now
    stood = _same(pixels, then, luma, margin) * sure
    return new_motion.reshape(moved.shape), new_alive.reshape(moved.shape), stood


@compiled
def _same(pixels, then, luma, margin):
    """(h, w) float32, 1 where no channel differs by more than noise and a little of the brightness, else 0."""
    n = luma.size
    now, was, bright = pixels.reshape(3 * n), then.reshape(3 * n), luma.reshape(n)
    same = np.empty(n, np.float32)
    for k in range(n):
        away = abs(now[3 * k] - was[3 * k])
        green, red = abs(now[3 * k + 1] - was[3 * k + 1]), abs(now[3 * k + 2] - was[3 * k + 2])
        away = away if away > green else green
        away = away if away > red else red
        same[k] = np.float32(1.0) if away < margin + np.float32(0.04) * bright[k] else np.float32(0.0)
    return same.reshape(luma.shape)


def stood(colours: Chromaticity, scene: Scene) -> np.ndarray:
    """(h, w) float32, 0 to 1, how surely each pixel shows what always stood there."""
    margin = np.float32(5.0 + 4.0 * scene.noise)
    return _same(colours.pixels, scene.pixels, colours.luma, margin) * scene.sure


def relit(scene: Scene, correction: np.ndarray) -> Scene:
    """The scene after the gains have been multiplied by a correction (3,), because the light is believed to be another."""
    pixels = scene.pixels * correction.astype(np.float32)
    return replace(scene, pixels=pixels, luma=cv2.transform(pixels, LUMA))


def forget(scene: Scene, where: np.ndarray) -> Scene:
    """The scene of which nothing is known ``where`` (h, w) is not zero: what stood there has come alive."""
    return replace(scene, sure=scene.sure * (where == 0))


def settle(scene: Scene, colours: Chromaticity, person: np.ndarray, dt: float) -> Scene:
    """The scene after ``dt`` s in which pixels outside ``person`` (h, w) bool that did not change became surer background."""
    margin = np.float32(5.0 + 4.0 * scene.noise)
    picture, sure = _settle(
        scene.pixels, scene.sure, scene.luma, scene.motion, colours.pixels, person, margin, np.float32(dt)
    )
    return Scene(picture, sure, colours.luma, scene.motion, scene.alive, scene.noise)


@compiled
def _settle(then, sure, luma, motion, pixels, person, margin, dt):
    n, zero, one = sure.size, np.float32(0.0), np.float32(1.0)
    same = _same(pixels, then, luma, margin).reshape(n)
    sure_, motion_, person_ = sure.reshape(n), motion.reshape(n), person.reshape(n)
    was, now = then.reshape(3 * n), pixels.reshape(3 * n)
    picture, surer, rate = np.empty(3 * n, np.float32), np.empty(n, np.float32), np.empty(n, np.float32)
    settled, changed, covered = dt / np.float32(SETTLE), -dt / np.float32(FORGET), -dt / np.float32(8 * FORGET)
    keep = min(one, np.float32(1.5) * dt)
    for k in range(n):
        step = settled if same[k] > zero else changed
        step = covered if person_[k] | (motion_[k] > np.float32(0.25)) else step
        known = sure_[k] + step
        known = known if known < one else one
        known = known if known > zero else zero
        surer[k] = known
        kept = keep if same[k] > zero else zero
        rate[k] = one if known <= zero else kept
    for k in range(n):
        for c in range(3):
            picture[3 * k + c] = was[3 * k + c] + rate[k] * (now[3 * k + c] - was[3 * k + c])
    return picture.reshape(then.shape), surer.reshape(sure.shape)
