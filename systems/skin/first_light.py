"""The light of a first picture, which nothing is known about yet."""

import numpy as np

from vipr.systems.camera.illumination import light_gains
from vipr.systems.skin import colour_model, scene
from vipr.systems.skin.chromaticity import chromaticity
from vipr.systems.skin.classifier import DARKEST, SkinOptions, classify
from vipr.systems.skin.colour_model import initial_model
from vipr.systems.skin.density import components, density
from vipr.systems.skin.learning import histogram_of_rest
from vipr.systems.skin.regions import describe
from vipr.systems.skin.working_image import odd, unit


def first_light(small: np.ndarray) -> np.ndarray:
    """(3,) gains that undo the light of a first picture (h, w, 3) uint8: those under which some region looks most like a face.

    Black-body lights are tried beside none at all, which wins where nothing looks like a face under another by far.
    """
    u, best, gains = unit(small.shape), 0.0, np.ones(3)
    for kelvin in (None, 3000.0, 3600.0, 4300.0, 6200.0, 7600.0):
        tried = np.ones(3) if kelvin is None else 1.0 / light_gains(1.0, kelvin)
        colours = chromaticity(small, tried)
        model = initial_model()
        blank = scene.new_scene(colours)
        rest = histogram_of_rest(colours, colours.total >= DARKEST, blank)
        model = colour_model.adapt(model, np.zeros_like(rest), rest, 0.3)
        skin = classify(small, colours, model, SkinOptions())
        labels, areas, boxes = components(density(skin, odd(3.4 * u)), 120, 40.0 * u * u, 6)
        if not len(areas):
            continue
        found = describe(labels, boxes, skin, colours.luma, blank)
        compact = np.clip(4.0 - found.areas / (np.pi * np.maximum(found.cores[:, 2], 1.0) ** 2), 0.0, 2.0) / 2.0
        looks = float((found.faceness * (0.5 + 0.5 * compact)).max()) + (0.12 if kelvin is None else 0.0)
        if looks > best:
            best, gains = looks, tried
    return gains
