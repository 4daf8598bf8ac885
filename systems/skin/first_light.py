"""The light of a picture which nothing is known about yet: guessed from the first frame, and again as long as no face shows under it.

Lights are black bodies, judged by how much the best region of skin under each looks like a face, how usual its colour then is for skin, and
whether anything in the room is as blue as grey is.
"""

from dataclasses import dataclass, replace

import numpy as np

from vipr.systems.camera.illumination import WHITE_KELVIN, light_gains
from vipr.systems.skin import colour_model, scene
from vipr.systems.skin.chromaticity import Chromaticity, chromaticity, lookup, nearest_index
from vipr.systems.skin.classifier import SkinOptions, classify, without_still
from vipr.systems.skin.colour_model import initial_model, usual_table
from vipr.systems.skin.density import large_patches
from vipr.systems.skin.learning import SURE_FACE, histogram_of_rest
from vipr.systems.skin.regions import Found, describe
from vipr.systems.skin.scene import Scene

KELVINS = (WHITE_KELVIN, 3000.0, 3600.0, 4300.0, 6200.0, 7600.0)  # the first is the light that is believed
# Looks of a face by which others must beat it: in one frame, over several guesses.
HEAD_START, HEAD_START_LATER = 0.12, 0.05
GREY = 0.0  # log B/R that the bluest tenth of a room reaches under white light: something in it is grey
STRANGE = 0.1  # of log B/R below, from which a light is given up for one that is less strange, though no face shows
FACE_SEEN = 0.5  # s, in which the memory of a face's looks halves
FIRST_WAIT, LONGEST_WAIT, LONGER = 0.2, 1.0, 1.2  # s between guesses, and by how much they grow
FRESH = 0.4  # share of the newest guess in the looks


@dataclass(frozen=True, eq=False)
class LightSearch:
    """What has been seen of a face under the light that is believed, and how faces looked under others."""

    face: float = 0.0  # looks of the best face of late
    looks: np.ndarray | None = None  # (k,) under each light that is tried, over some guesses; None before the first
    due: float = 0.0  # s, when to guess again
    wait: float = FIRST_WAIT  # s, from there to the guess after that


def first_light(small: np.ndarray, time: float) -> tuple[np.ndarray, LightSearch]:
    """(3,) gains that undo the light of a first picture (h, w, 3) uint8; white light wins where nothing is better by far."""
    corrections = _corrections()
    looks = _looks_under(small, np.ones(3), None, corrections)
    best = _likeliest(looks, HEAD_START)
    return corrections[best], LightSearch(float(looks[best]), due=time + FIRST_WAIT)


def light_again(
    small: np.ndarray, gains: np.ndarray, still: Scene, search: LightSearch, time: float
) -> tuple[np.ndarray | None, LightSearch]:
    """(3,) by what the gains should be multiplied, None to leave them: another light, if no face shows under this one.

    Over several guesses, a face must show under the other; or the room must look strange in this one.
    """
    if search.face > SURE_FACE or time < search.due:
        return None, search
    corrections = _corrections()
    looks = _looks_under(small, gains, still, corrections)
    if search.looks is not None:
        looks = search.looks + FRESH * (looks - search.looks)
    wait = min(LONGER * search.wait, LONGEST_WAIT)
    best = _likeliest(looks, HEAD_START_LATER)
    if best == 0 or (looks[best] < SURE_FACE and looks[0] > -STRANGE):
        return None, LightSearch(search.face, looks, time + search.wait, wait)
    return corrections[best], LightSearch(float(looks[best]), due=time + search.wait, wait=wait)


def face_seen(search: LightSearch, found: Found, dt: float, covered: bool = False) -> LightSearch:
    """The search ``dt`` s later, when ``found`` was seen under the light that is believed.

    A face that was sure before a hand ``covered`` it is not forgotten: it shows no marks, whatever the light.
    """
    if covered and search.face > SURE_FACE:
        return search
    keep = 0.5 ** (dt / FACE_SEEN)
    return replace(search, face=keep * search.face + (1.0 - keep) * float(_looks(found).max(initial=0.0)))


def _corrections() -> np.ndarray:
    return np.array([1.0 / light_gains(1.0, kelvin) for kelvin in KELVINS])


def _likeliest(looks: np.ndarray, head_start: float) -> int:
    best = int(np.argmax(looks))
    return best if looks[best] > looks[0] + head_start else 0


def _looks_under(small: np.ndarray, gains: np.ndarray, still: Scene | None, corrections: np.ndarray) -> np.ndarray:
    """(k,) how much the best region looks like a face after each correction of the gains, less how strange the room's colours are then."""
    bluest = _bluest(small) + np.log(corrections[:, 0] * gains[0] / (corrections[:, 2] * gains[2]))
    looks = np.array([_look(small, gains * c, still and scene.relit(still, c)) for c in corrections])
    return looks - np.maximum(GREY - bluest, 0.0)


def _bluest(small: np.ndarray) -> float:
    """log B/R that a tenth of the well exposed pixels exceeds; that of grey where there are hardly any."""
    some = small[::3, ::3].reshape(-1, 3).astype(np.float32)
    some = some[(some.min(1) > 8) & (some.max(1) < 250)]
    return float(np.quantile(np.log(some[:, 0] / some[:, 2]), 0.9)) if len(some) > 60 else GREY


def _look(small: np.ndarray, gains: np.ndarray, still: Scene | None) -> float:
    """0 to 1, how much some region under these gains looks like a face, without what always stood there if that is known."""
    colours = chromaticity(small, gains)
    room = scene.new_scene(colours) if still is None else still
    rest = histogram_of_rest(colours, colours.bright, room)
    skin = classify(small, colours, colour_model.adapt(initial_model(), np.zeros_like(rest), rest, 0.3), SkinOptions())
    if still is not None:
        skin = without_still(skin, scene.stood(colours, still))
    labels, areas, boxes = large_patches(skin)
    if not len(areas):
        return 0.0
    found = describe(labels, boxes, skin, colours.luma, room)
    return float((_looks(found) * _usual(labels, len(areas), colours)).max())


def _looks(found: Found) -> np.ndarray:
    """(n,) 0 to 1, how much each region looks like a face that is one compact region."""
    compact = np.clip(4.0 - found.areas / (np.pi * np.maximum(found.cores[:, 2], 1.0) ** 2), 0.0, 2.0) / 2.0
    return found.faceness * (0.5 + 0.5 * compact)


def _usual(labels: np.ndarray, n: int, colours: Chromaticity) -> np.ndarray:
    """(n,) 0 to 1, how usual the mean colour of each region is for skin."""
    sums = [np.bincount(labels.ravel(), colours.pixels[:, :, c].ravel(), n + 1)[1:] for c in range(3)]
    total = np.maximum(sum(sums), 1e-6)
    return lookup(usual_table(), nearest_index(sums[2] / total, sums[1] / total)[None])[0]
