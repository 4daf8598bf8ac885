"""What skin and the rest of this scene look like now: two histograms in the r-g plane and the table that their ratio gives.

The paper feeds the boundaries of the histogram of the detected regions back to the box. The box here follows the same way; beside it
the ratio of the two histograms says how much more likely a colour is on this person than elsewhere in this room, which is what
tells a face from a wall of nearly its colour. Both are bounded: regions move the model only within ``REACH`` of where it started
(in coordinates freed of the light), and no more than a share each second.
"""

import math
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache

import cv2
import numpy as np

from vipr.systems.compiled import compiled
from vipr.systems.skin.chromaticity import G_BINS, R_BINS, bin_centres, by_index
from vipr.systems.skin.locus import SkinBox, box_table, skin_prior

REACH = 0.09  # how far in r or g regions may pull the model from its anchor
RATE = 2.5  # 1/s, at which regions replace the model
LEARN = 3.0  # 1/s, at which the regions' share of the skin histogram grows at first
LARGEST_SHARE = 0.9  # of the skin histogram that the regions may take; the rest stays the prior


@lru_cache(maxsize=1)
def _prior() -> np.ndarray:
    table = skin_prior()
    table.setflags(write=False)
    return table


@lru_cache(maxsize=1)
def _uniform() -> np.ndarray:
    table = np.full((R_BINS, G_BINS), 1.0 / (R_BINS * G_BINS), np.float32)
    table.setflags(write=False)
    return table


@lru_cache(maxsize=1)
def doubt_table() -> np.ndarray:
    """(256, 256) float32 by index, 0 to 1: how far a colour may be anybody's skin, so that it need not belong to the room."""
    return by_index((0.55 * _prior() / (_prior() + np.float32(0.6 / (R_BINS * G_BINS)))).astype(np.float32))


@lru_cache(maxsize=1)
def possible_table() -> np.ndarray:
    """(256, 256) float32 by index, 1 where the prior leaves some chance for skin."""
    return by_index((_prior() > 2e-6).astype(np.float32))


@lru_cache(maxsize=1)
def usual_table() -> np.ndarray:
    """(256, 256) float32 by index, 0 to 1: how usual a colour is for skin."""
    return by_index(np.sqrt(_prior() / _prior().max()))


@dataclass(frozen=True, eq=False)
class ColourModel:
    """Histograms of skin and of the rest, normalised to 1, in chromaticity freed of the light."""

    skin: np.ndarray  # (R_BINS, G_BINS) float32
    rest: np.ndarray  # (R_BINS, G_BINS) float32
    share: float = 0.0  # 0 to LARGEST_SHARE of ``skin`` that comes from this person
    anchor: tuple[float, float] | None = None  # r, g about which the model is bounded; None before it has seen a person
    box: SkinBox = SkinBox()

    @cached_property
    def table(self) -> np.ndarray:
        """(256, 256) uint8 by index: 255 times the probability that a colour is skin."""
        return by_index(skin_table(self))


def initial_model() -> ColourModel:
    """Skin of anybody against an even background."""
    return ColourModel(_prior(), _uniform())


def skin_table(model: ColourModel, prior_odds: float = 0.45) -> np.ndarray:
    """(R_BINS, G_BINS) uint8: 255 times the probability that a colour is skin, at the given odds of skin before colour is seen."""
    skin = (1.0 - model.share) * _prior() + model.share * model.skin if model.share else _prior()
    odds = prior_odds * (skin + np.float32(2e-6))
    return np.rint(255.0 * odds / (odds + model.rest + np.float32(2e-5))).astype(np.uint8)


def adapt(model: ColourModel, skin: np.ndarray, rest: np.ndarray, dt: float, trust: float = 1.0) -> ColourModel:
    """The model after ``dt`` s with histograms of pixels on the person and elsewhere (sums of weights); trust 0 to 1 in the regions."""
    rest_total = float(rest.sum())
    if rest_total > 0:
        rate = 1.0 - math.exp(-dt * RATE)
        seen = 0.85 * cv2.GaussianBlur(rest, (3, 3), 0.8) / rest_total + 0.15 * _uniform()
        model = replace(model, rest=(1 - rate) * model.rest + rate * seen)
    total = float(skin.sum())
    if total < 12.0 or trust <= 0.0:
        return model
    r, g = bin_centres()
    anchor = model.anchor
    if anchor is None:
        anchor = (float((skin.sum(1) * r[:, 0]).sum() / total), float((skin.sum(0) * g[0]).sum() / total))
    bounded = skin * ((abs(r - anchor[0]) < REACH) & (abs(g - anchor[1]) < REACH) & (_prior() > 1e-7))
    total = float(bounded.sum())
    if total < 12.0:
        return model
    bounded = cv2.GaussianBlur(bounded, (5, 5), 1.1) / total
    rate = trust * (1.0 - math.exp(-dt * RATE))
    old = model.skin if model.share else bounded
    share = min(LARGEST_SHARE, model.share + trust * dt * LEARN)
    adapted = (1 - rate) * old + rate * bounded
    return replace(model, skin=adapted, share=share, anchor=anchor, box=_adapted_box(model.box, bounded, rate))


def _adapted_box(box: SkinBox, histogram: np.ndarray, rate: float) -> SkinBox:
    """The box moved towards the 2 and 98 percent points of the histogram (with a margin of one bin), at the given rate."""
    new = []
    for profile, centres in zip((histogram.sum(1), histogram.sum(0)), bin_centres(), strict=True):
        low, high = centres.ravel()[_middle(profile, 0.02)]
        new += [low - 0.006, high + 0.006]
    old = (box.r_low, box.r_high, box.g_low, box.g_high)
    return SkinBox(*(min(max((1 - rate) * a + rate * float(b), 0.0), 1.0) for a, b in zip(old, new, strict=True)))


@compiled
def _middle(profile, beyond):
    """First and last bin of a profile without the shares ``beyond`` at either end."""
    total, so_far = max(profile.sum(), 1e-9), 0.0
    bins = np.full(2, len(profile) - 1)
    for k in range(len(profile) - 1, -1, -1):
        bins[1] = k if so_far <= beyond * total else bins[1]
        so_far += profile[k]
    so_far = 0.0
    for k in range(len(profile)):
        bins[0] = k if so_far < beyond * total else bins[0]
        so_far += profile[k]
    return bins


__all__ = ["ColourModel", "adapt", "box_table", "initial_model", "skin_table"]
