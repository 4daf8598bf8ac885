"""Skin from frame to frame: light, segmentation, density, components, and what is learned from them. Pure.

:class:`~vipr.systems.skin.segmenter.SkinSegmenter` is the shell. All state is in :class:`SkinBelief`, a value.
"""

from collections.abc import Callable
from dataclasses import dataclass, field, replace

import cv2
import numpy as np

from vipr.systems.signals import HandTracks, SkinRegions
from vipr.systems.skin import colour_model, scene
from vipr.systems.skin.chromaticity import Chromaticity, chromaticity, lookup, quiet
from vipr.systems.skin.classifier import SkinOptions, classify, without_still
from vipr.systems.skin.colour_model import ColourModel, initial_model, possible_table
from vipr.systems.skin.density import DENSE, NEIGHBOURHOOD, components, density
from vipr.systems.skin.first_light import LightSearch, face_seen, first_light, light_again
from vipr.systems.skin.learning import histogram_of_rest, learn
from vipr.systems.skin.regions import Found, describe
from vipr.systems.skin.scene import Scene
from vipr.systems.skin.working_image import odd, reduce, unit

LEARN_EVERY = 0.1  # s


@dataclass(frozen=True, eq=False)
class SkinBelief:
    """All that the skin stage remembers between frames."""

    model: ColourModel = field(default_factory=initial_model)
    scene: Scene | None = None
    gains: np.ndarray = field(default_factory=lambda: np.ones(3))  # of B, G, R, that undo the present light
    light: LightSearch = LightSearch()
    regions: SkinRegions = field(default_factory=SkinRegions)
    learned: float = 0.0  # s, when the model was last adapted

    def __copy__(self):
        return self

    def __deepcopy__(self, memo):
        return self


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
    dt = min(max(time - belief.regions.time, 1e-3), 0.5)
    small, scale = reduce(image, options.working_area)
    small = quiet(small)
    u = unit(small.shape)
    mark("reduction")
    gains, cut = belief.gains, belief.scene is None or belief.scene.sure.shape != small.shape[:2]
    anew = cut  # nothing is known yet of the person under this light
    if not cut and options.follow_light:
        gains = scene.light_change(small, belief.scene, gains)
        correction, light = light_again(small, gains, belief.scene, belief.light, time)
        belief = replace(belief, light=light)
        if correction is not None:
            gains, belief, anew = gains * correction, _relit(belief, correction), True
        mark("light")
    colours = chromaticity(small, gains)
    if cut or scene.is_cut(colours, belief.scene):
        gains, light = first_light(small, time) if options.follow_light else (np.ones(3), LightSearch())
        belief, cut, anew = SkinBelief(light=light, learned=time), True, True
        colours = chromaticity(small, gains)
        still, stood = scene.new_scene(colours), np.zeros(small.shape[:2], np.float32)
        rest = histogram_of_rest(colours, colours.bright, still)
        model = colour_model.adapt(belief.model, np.zeros_like(rest), rest, 0.3)
    else:
        model = belief.model
        mark("segmentation")
        brighter = float(np.mean(gains / belief.gains))
        still, stood = scene.watch(colours, belief.scene, odd(11 * u), dt, brighter)
        mark("motion")
    skin = classify(small, colours, model, options)
    if options.classifier == "ratio" and model.share < 0.6:
        skin = _moving(skin, colours, still)
    by_colour = skin
    if options.still_scene:
        skin = without_still(skin, stood)
    mark("segmentation")
    dense = density(skin, odd(NEIGHBOURHOOD * u))
    mark("density")
    labels, _, boxes = components(dense, DENSE, 8.0 * u * u, options.most_regions)
    mark("components")
    found = describe(labels, boxes, skin, colours.luma, still)
    mark("description")
    light = face_seen(belief.light, found, dt, covered=tracks is not None and "face" in tracks.merged)
    learned = belief.learned
    if cut or time - learned >= LEARN_EVERY - 1e-6:
        since, learned = (0.04 if cut else min(time - learned, 0.5)), time
        known = None if anew else tracks
        still, model = learn(model, colours, skin, by_colour, labels, found, still, known, scale, since, options)
        mark("learning")
    regions = _regions(found, labels, boxes, still, scale, image.shape, cut=anew, time=time, number=number)
    return SkinBelief(model, still, gains, light, regions, learned)


def _relit(belief: SkinBelief, correction: np.ndarray) -> SkinBelief:
    """The belief after the light is believed to be another: the scene is kept, what skin looks like is learned anew."""
    relit = scene.relit(belief.scene, correction)
    return replace(belief, model=initial_model(), scene=relit, gains=belief.gains * correction)


def _moving(skin: np.ndarray, colours: Chromaticity, still: Scene) -> np.ndarray:
    """Before the person is known: what moves and could be skin under some light is ten times likelier to be."""
    p = skin.astype(np.float32)
    boost = 9.0 * still.motion * (lookup(possible_table(), colours.index) * (colours.total > 0))
    return cv2.convertScaleAbs(p * (1 + boost) / (1 + p * boost / 255.0))


def _regions(
    found: Found, labels: np.ndarray, boxes: np.ndarray, still: Scene, scale: float, shape, **when
) -> SkinRegions:
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
        **when,
    )
