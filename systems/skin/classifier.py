"""Which pixels are skin by colour alone, and the options of the whole stage."""

from dataclasses import dataclass

import numpy as np

from vipr.systems.compiled import compiled
from vipr.systems.errors import InputError
from vipr.systems.skin.chromaticity import Chromaticity, hue_saturation, lookup
from vipr.systems.skin.colour_model import ColourModel
from vipr.systems.skin.locus import SkinBox, box_table

CLASSIFIERS = ("ratio", "box", "locus", "hsi")


@dataclass(frozen=True)
class SkinOptions:
    """How skin is found. The defaults are the full chain; the others are for comparison."""

    working_area: float = 160.0 * 120.0  # px, to which frames are reduced (never enlarged)
    classifier: str = "ratio"  # ratio (of histograms) | box (r-g, II-A.1) | locus (shell) | hsi (hue, saturation)
    adapt: bool = True  # feed the detected regions back to the model
    follow_light: bool = True  # undo changes of the light seen on the still scene
    still_scene: bool = True  # what never changes is not the person
    most_regions: int = 8

    def __post_init__(self):
        if self.classifier not in CLASSIFIERS:
            raise InputError(f"skin: classifier must be one of {', '.join(CLASSIFIERS)}, got {self.classifier}")
        if self.working_area < 400:
            raise InputError(f"skin: working area must be at least 400 px, got {self.working_area}")


def classify(image: np.ndarray, colours: Chromaticity, model: ColourModel, options: SkinOptions) -> np.ndarray:
    """(h, w) uint8: 255 times the probability that a pixel is skin, by colour alone."""
    if options.classifier == "hsi":
        hue, saturation = hue_saturation(image)
        skin = np.where(((hue <= 17) | (hue >= 173)) & (saturation >= 50) & (saturation <= 170), 255, 0).astype(
            np.uint8
        )
    elif options.classifier == "box":
        skin = lookup(box_table(model.box, locus=False), colours.index)
    elif options.classifier == "locus":
        skin = lookup(box_table(SkinBox(1.0 / 3.0, 1.0, 0.0, 1.0)), colours.index)
    else:
        skin = lookup(model.table, colours.index)
    return _bright_enough(skin, colours.total, np.float32(colours.darkest))


@compiled
def _bright_enough(skin, total, darkest):
    out = np.empty_like(skin)
    for i in range(skin.shape[0]):
        for j in range(skin.shape[1]):
            out[i, j] = skin[i, j] if total[i, j] >= darkest else 0
    return out


@compiled
def without_still(skin, stood):
    """Skin (h, w) uint8 less 0.95 of it where ``stood`` (h, w) float32, 0 to 1, says what always stood there."""
    out = np.empty_like(skin)
    for i in range(skin.shape[0]):
        for j in range(skin.shape[1]):
            out[i, j] = np.uint8(np.rint(skin[i, j] * (np.float32(1.0) - np.float32(0.95) * stood[i, j])))
    return out
