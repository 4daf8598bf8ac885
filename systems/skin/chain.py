"""Skin from frame to frame: light, segmentation, density, components, and what is learned from them. Pure.

:class:`~vipr.systems.skin.segmenter.SkinSegmenter` is the shell. All state is in :class:`SkinBelief`, a value.
"""

from collections.abc import Callable
from dataclasses import dataclass, field, replace

import cv2
import numpy as np

from vipr.systems.camera.illumination import light_gains
from vipr.systems.errors import InputError
from vipr.systems.signals import HandTracks, SkinRegions
from vipr.systems.skin import colour_model, scene
from vipr.systems.skin.chromaticity import Chromaticity, chromaticity, histogram, hue_saturation, lookup
from vipr.systems.skin.colour_model import ColourModel, doubt_table, initial_model, possible_table, skin_table
from vipr.systems.skin.density import components, density
from vipr.systems.skin.locus import SkinBox, box_table
from vipr.systems.skin.regions import Found, describe
from vipr.systems.skin.scene import Scene

LEARN_EVERY = 0.1  # s
DARKEST = 36.0  # R + G + B below which chromaticity is noise
CLASSIFIERS = ("ratio", "box", "hsi")


@dataclass(frozen=True)
class SkinOptions:
    """How skin is found. The defaults are the full chain; the others are for comparison."""

    working_area: float = 160.0 * 120.0  # px, to which frames are reduced (never enlarged)
    classifier: str = "ratio"  # ratio (of histograms) | box (r-g, section II-A.1) | hsi (hue and saturation)
    adapt: bool = True  # feed the detected regions back to the model
    follow_light: bool = True  # undo changes of the light seen on the still scene
    still_scene: bool = True  # what never changes is not the person
    most_regions: int = 8

    def __post_init__(self):
        if self.classifier not in CLASSIFIERS:
            raise InputError(f"skin: classifier must be one of {', '.join(CLASSIFIERS)}, got {self.classifier}")
        if self.working_area < 400:
            raise InputError(f"skin: working area must be at least 400 px, got {self.working_area}")


@dataclass(frozen=True, eq=False)
class SkinBelief:
    """All that the skin stage remembers between frames."""

    model: ColourModel = field(default_factory=initial_model)
    scene: Scene | None = None
    gains: np.ndarray = field(default_factory=lambda: np.ones(3))  # of B, G, R, that undo the present light
    regions: SkinRegions = field(default_factory=SkinRegions)
    learned: float = 0.0  # s, when the model was last adapted

    def __copy__(self):
        return self

    def __deepcopy__(self, memo):
        return self


def as_bgr(image: np.ndarray) -> np.ndarray:
    """Any picture as (h, w, 3) uint8 BGR: grey and four channels are converted, 16 bits and floats (0 to 1) scaled."""
    image = np.asarray(image)
    if image.ndim == 3 and image.shape[2] == 1:
        image = image[:, :, 0]
    if image.ndim not in (2, 3) or (image.ndim == 3 and image.shape[2] not in (3, 4)) or 0 in image.shape:
        raise InputError(f"image: must be (h, w), (h, w, 3) BGR or (h, w, 4) BGRA, got shape {image.shape}")
    if image.dtype == np.uint16:
        image = (image >> 8).astype(np.uint8)
    elif image.dtype in (np.float32, np.float64):
        image = np.rint(255.0 * np.clip(np.nan_to_num(image), 0.0, 1.0)).astype(np.uint8)
    elif image.dtype == bool:
        image = image.astype(np.uint8) * 255
    elif image.dtype != np.uint8:
        raise InputError(f"image: must be of 8 or 16 bits or float, got {image.dtype}")
    if image.ndim == 2:
        return cv2.cvtColor(image, cv2.COLOR_GRAY2BGR)
    return image if image.shape[2] == 3 else np.ascontiguousarray(image[:, :, :3])


def reduce(image: np.ndarray, area: float) -> tuple[np.ndarray, float]:
    """The image at about ``area`` px and the pixels of the image in one of its pixels; an image that is small enough as it is."""
    h, w = image.shape[:2]
    factor = np.sqrt(h * w / area)
    if factor <= 1.05:
        return image, 1.0
    size = (max(8, round(w / factor)), max(8, round(h / factor)))
    return cv2.resize(image, size, interpolation=cv2.INTER_AREA), float(factor)


def unit(shape) -> float:
    """1 at 160 x 120; lengths in pixels grow with it."""
    return float(np.sqrt(shape[0] * shape[1] / 19200.0))


def odd(x: float) -> int:
    """The odd number nearest to x, at least 3."""
    return max(3, 2 * int(x / 2) + 1)


def classify(image: np.ndarray, colours: Chromaticity, model: ColourModel, options: SkinOptions) -> np.ndarray:
    """(h, w) uint8: 255 times the probability that a pixel is skin, by colour alone."""
    if options.classifier == "hsi":
        hue, saturation = hue_saturation(image)
        skin = np.where(((hue <= 17) | (hue >= 173)) & (saturation >= 50) & (saturation <= 170), 255, 0).astype(
            np.uint8
        )
    elif options.classifier == "box":
        skin = lookup(box_table(model.box), colours.index)
    else:
        skin = lookup(skin_table(model), colours.index)
    skin[colours.total < DARKEST] = 0
    return skin


def see_skin(
    image: np.ndarray,
    time: float,
    number: int,
    belief: SkinBelief,
    options: SkinOptions = SkinOptions(),
    tracks: HandTracks | None = None,
    mark: Callable[[str], None] = lambda stage: None,
) -> SkinBelief:
    """The belief after a frame (h, w, 3) BGR uint8 exposed at ``time`` [s]; its ``regions`` are the frame's.

    ``tracks`` are those of the frame before: what is followed is not taken for a thing of the room, however still it is. ``mark`` is called
    with the name of each stage when it is done, for whoever wants to time it.
    """
    small, scale = reduce(image, options.working_area)
    u = unit(small.shape)
    mark("reduction")
    gains, cut = belief.gains, belief.scene is None or belief.scene.sure.shape != small.shape[:2]
    if not cut and options.follow_light:
        gains = scene.light_change(small, belief.scene, gains)
        mark("light")
    colours = chromaticity(small, gains)
    if cut or scene.is_cut(colours.pixels, belief.scene):
        belief, cut = SkinBelief(learned=time), True
        gains = first_light(small) if options.follow_light else np.ones(3)
        colours = chromaticity(small, gains)
        still, stood = scene.new_scene(colours.pixels), np.zeros(small.shape[:2], np.float32)
        rest = _rest(colours, colours.total >= DARKEST, still)
        model = colour_model.adapt(belief.model, np.zeros_like(rest), rest, 0.3)
    else:
        model, dt = belief.model, min(max(time - belief.regions.time, 1e-3), 0.5)
        mark("segmentation")
        brighter = float(np.mean(gains / belief.gains))
        still, stood = scene.watch(colours.pixels, belief.scene, odd(11 * u), dt, brighter)
        mark("motion")
    skin = classify(small, colours, model, options)
    if options.classifier == "ratio" and model.share < 0.6:
        skin = _moving(skin, colours, still)
    if options.still_scene:
        skin = cv2.multiply(skin, 1.0 - 0.95 * stood, dtype=cv2.CV_8U)
    mark("segmentation")
    dense = density(skin, odd(3.4 * u))
    mark("density")
    labels, _, boxes = components(dense, 120, 8.0 * u * u, options.most_regions)
    mark("components")
    found = describe(labels, boxes, skin, scene.brightness(colours.pixels), still)
    mark("description")
    learned = belief.learned
    if cut or time - learned >= LEARN_EVERY - 1e-6:
        since, learned = (0.04 if cut else min(time - learned, 0.5)), time
        still, model = _learn(
            model, colours, skin, labels, found, still, tracks if not cut else None, scale, since, options
        )
        mark("learning")
    regions = _regions(found, labels, boxes, still, scale, image.shape)
    regions = replace(regions, cut=cut, time=time, number=number)
    return SkinBelief(model, still, gains, regions, learned)


def _regions(found: Found, labels: np.ndarray, boxes: np.ndarray, still: Scene, scale: float, shape) -> SkinRegions:
    """What was found as a signal, in pixels of the frame, by falling evidence."""
    order = np.argsort(-found.person * np.sqrt(found.areas), kind="stable")
    rename = np.zeros(256, np.uint8)
    rename[order + 1] = np.arange(1, len(order) + 1)
    cores = found.cores[order]
    return SkinRegions(
        centres=(found.centres[order] + 0.5) * scale - 0.5,
        areas=found.areas[order] * scale**2,
        boxes=boxes[order] * scale,
        person=found.person[order],
        faceness=found.faceness[order],
        cores=np.column_stack([(cores[:, :2] + 0.5) * scale - 0.5, cores[:, 2] * scale]),
        moving=found.moving[order],
        labels=cv2.LUT(labels, rename),
        motion=cv2.convertScaleAbs(still.motion, alpha=255.0),
        scale=scale,
        size=(shape[1], shape[0]),
    )


def first_light(small: np.ndarray) -> np.ndarray:
    """(3,) gains that undo the light of a first picture (h, w, 3) uint8: those under which some region looks most like a face.

    Black-body lights are tried beside none at all, which wins where nothing looks like a face under another by far.
    """
    u, best, gains = unit(small.shape), 0.0, np.ones(3)
    for kelvin in (None, 3000.0, 3600.0, 4300.0, 6200.0, 7600.0):
        tried = np.ones(3) if kelvin is None else 1.0 / light_gains(1.0, kelvin)
        colours = chromaticity(small, tried)
        model = initial_model()
        blank = scene.new_scene(colours.pixels)
        rest = _rest(colours, colours.total >= DARKEST, blank)
        model = colour_model.adapt(model, np.zeros_like(rest), rest, 0.3)
        skin = classify(small, colours, model, SkinOptions())
        labels, areas, boxes = components(density(skin, odd(3.4 * u)), 120, 40.0 * u * u, 6)
        if not len(areas):
            continue
        found = describe(labels, boxes, skin, scene.brightness(colours.pixels), blank)
        compact = np.clip(4.0 - found.areas / (np.pi * np.maximum(found.cores[:, 2], 1.0) ** 2), 0.0, 2.0) / 2.0
        looks = float((found.faceness * (0.5 + 0.5 * compact)).max()) + (0.12 if kelvin is None else 0.0)
        if looks > best:
            best, gains = looks, tried
    return gains


def _moving(skin: np.ndarray, colours: Chromaticity, still: Scene) -> np.ndarray:
    """Before the person is known: what moves and could be skin under some light is ten times likelier to be."""
    p = skin.astype(np.float32)
    boost = 9.0 * still.motion * (lookup(possible_table(), colours.index) * (colours.total > 0))
    return cv2.convertScaleAbs(p * (1 + boost) / (1 + p * boost / 255.0))


def _person_pixels(labels: np.ndarray, person: np.ndarray) -> np.ndarray:
    """(h, w) uint8, 1 on regions that are rather the person than not."""
    table = np.zeros(256, np.uint8)
    table[1 : len(person) + 1] = person > 0.5
    return cv2.LUT(labels, table)


def _followed(labels: np.ndarray, tracks: HandTracks, scale: float) -> np.ndarray:
    """(h, w) uint8, 1 on regions that hold a part seen in the frame before, about that part."""
    about = np.zeros_like(labels)
    for name, area in zip(("face", "left", "right"), tracks.areas, strict=True):
        if getattr(tracks, f"{name}_seen"):
            x, y = (getattr(tracks, name) + 0.5) / scale - 0.5
            cv2.circle(
                about, (round(float(x)), round(float(y))), max(2, round(1.1 * float(np.sqrt(area)) / scale)), 1, -1
            )
    return about & np.minimum(labels, 1)


def _learn(model, colours, skin, labels, found: Found, still, tracks, scale, dt, options):
    """The still scene and the colour model after ``dt`` s.

    Skin is learned from the face and from what moves in the person's regions, the rest from outside them and from the still scene.
    """
    on_person = _person_pixels(labels, found.person)
    if options.still_scene or options.adapt:
        kept = on_person
        if tracks is not None:
            kept = _followed(labels, tracks, scale) | _person_pixels(
                labels, np.where(found.faceness > 0.25, found.person, 0.0)
            )
        still = scene.settle(still, colours.pixels, cv2.dilate(kept, np.ones((3, 3), np.uint8)) > 0, dt)
    if not options.adapt:
        return still, model
    bright, person = colours.total >= DARKEST, on_person > 0
    sample, trust = (skin > 60) & (still.motion > 0.25) & person, 0.6
    if len(found.faceness) and found.faceness.max() > 0.25:
        best = int(np.argmax(found.faceness))
        x, y, r = found.cores[best]
        ellipse = np.zeros_like(skin)
        cv2.ellipse(ellipse, (round(x), round(y)), (max(1, round(0.95 * r)), max(1, round(1.2 * r))), 0, 0, 360, 1, -1)
        sample |= (ellipse > 0) & (labels == best + 1) & (skin > 40)
        trust = float(np.clip(found.faceness[best] / 0.4, 0.6, 1.0))
    rest = _rest(colours, bright & ~person, still)
    return still, colour_model.adapt(model, histogram(colours.index[sample & bright]), rest, dt, trust)


def _rest(colours: Chromaticity, outside: np.ndarray, still: Scene) -> np.ndarray:
    """Histogram of what is not the person: what could be skin by its colour counts as far as it is known to stand still."""
    return histogram(
        colours.index, np.where(outside, 1.0 - lookup(doubt_table(), colours.index) * (1.0 - still.sure), 0.0)
    )


__all__ = ["SkinBelief", "SkinBox", "SkinOptions", "as_bgr", "reduce", "see_skin"]
