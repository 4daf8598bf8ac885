"""Which pixels are skin by colour alone, and the options of the whole stage."""

from dataclasses import dataclass

import numpy as np

from vipr.systems.errors import InputError
from vipr.systems.skin.chromaticity import Chromaticity, hue_saturation, lookup
from vipr.systems.skin.colour_model import ColourModel, skin_table
from vipr.systems.skin.locus import SkinBox, box_table

DARKEST = 36.0  # R + G + B below which chromaticity is noise
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
        skin = lookup(skin_table(model), colours.index)
    skin[colours.total < DARKEST] = 0
    return skin
