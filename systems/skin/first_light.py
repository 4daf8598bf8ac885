"""The light of a picture which nothing is known about yet: guessed from the first frame, and again as long as no face shows under it."""

from dataclasses import dataclass, replace

import numpy as np

from vipr.systems.camera.illumination import WHITE_KELVIN, light_gains
from vipr.systems.skin import colour_model, scene
from vipr.systems.skin.chromaticity import chromaticity
from vipr.systems.skin.classifier import DARKEST, SkinOptions, classify, without_still
from vipr.systems.skin.colour_model import initial_model
from vipr.systems.skin.density import components, density
from vipr.systems.skin.learning import SURE_FACE, histogram_of_rest
from vipr.systems.skin.regions import Found, describe
from vipr.systems.skin.scene import Scene
from vipr.systems.skin.working_image import odd, unit

KELVINS = (WHITE_KELVIN, 3000.0, 3600.0, 4300.0, 6200.0, 7600.0)  # tried beside the light that is believed, the first
BLUEST = (0.0, 0.7)  # log B/R of the bluest tenth of a room under its own light: something in it is grey, and seldom much is blue
UNLIKELY = 0.6  # looks of a face that a unit of log B/R beyond these limits takes away
HEAD_START = 0.12  # looks of a face, by which another light must beat the one that is believed
FACE_SEEN = 0.5  # s, in which the memory of a face's looks halves
FIRST_WAIT, LONGEST_WAIT, LONGER = 0.2, 1.0, 1.2  # s between guesses, and by how much it grows


@dataclass(frozen=True, eq=False)
class LightSearch:
    """What has been seen of a face under the light that is believed, and how faces looked under others."""

    face: float = 0.0  # looks of the best face of late
    looks: np.ndarray | None = None  # (k,) under each light that is tried, over some guesses; None before the first
    due: float = 0.0  # s, when to guess again
    wait: float = FIRST_WAIT  # s


def first_light(small: np.ndarray, time: float) -> tuple[np.ndarray, LightSearch]:
    """(3,) gains that undo the light of a first picture (h, w, 3) uint8: those under which some region looks most like a face."""
    corrections = _corrections()
    looks = _looks_under(small, np.ones(3), None, corrections)
    best = _chosen(looks)
    return corrections[best], LightSearch(float(looks[best]), None, time + FIRST_WAIT)


def seen(search: LightSearch, found: Found, dt: float) -> LightSearch:
    """The search after a frame in which ``found`` was seen."""
    keep = 0.5 ** (dt / FACE_SEEN)
    return replace(search, face=keep * search.face + (1.0 - keep) * _best_look(found))


def light_again(
    small: np.ndarray, gains: np.ndarray, still: Scene, search: LightSearch, time: float
) -> tuple[np.ndarray | None, LightSearch]:
    """(3,) by what the gains should be multiplied, None to leave them: another light if, over several guesses, a face shows under it only."""
    if search.face > SURE_FACE or time < search.due:
        return None, search
    corrections = _corrections()
    fresh = _looks_under(small, gains, still, corrections)
    looks = fresh if search.looks is None else search.looks + 0.4 * (fresh - search.looks)
    search = replace(search, looks=looks, due=time + search.wait, wait=min(LONGER * search.wait, LONGEST_WAIT))
    best = _chosen(looks)
    if best == 0 or looks[best] < SURE_FACE:
        return None, search
    return corrections[best], LightSearch(float(looks[best]), None, time + FIRST_WAIT, search.wait)


def _corrections() -> np.ndarray:
    return np.array([1.0 / light_gains(1.0, kelvin) for kelvin in KELVINS])


def _chosen(looks: np.ndarray) -> int:
    return int(np.argmax(looks + HEAD_START * (np.arange(len(looks)) == 0)))


def _looks_under(small: np.ndarray, gains: np.ndarray, still: Scene | None, corrections: np.ndarray) -> np.ndarray:
    """(k,) how much the best region looks like a face after each correction, less what the colours of the room say against it."""
    bluest = _bluest(small) + np.log(corrections[:, 0] * gains[0] / (corrections[:, 2] * gains[2]))
    strange = np.maximum(BLUEST[0] - bluest, 0.0) + np.maximum(bluest - BLUEST[1], 0.0)
    return np.array([_look(small, gains * c, still and scene.relit(still, c)) for c in corrections]) - UNLIKELY * strange


def _bluest(small: np.ndarray) -> float:
    """log B/R that a tenth of the well exposed pixels exceeds; in the middle of what is usual where there are none."""
    some = small[::3, ::3].reshape(-1, 3).astype(np.float32)
    some = some[(some.min(1) > 8) & (some.max(1) < 250)]
    if len(some) < 60:
        return 0.5 * sum(BLUEST)
    return float(np.quantile(np.log(some[:, 0] / some[:, 2]), 0.9))


def _look(small: np.ndarray, gains: np.ndarray, still: Scene | None) -> float:
    u = unit(small.shape)
    colours = chromaticity(small, gains)
    skin_apart = still is not None
    still = scene.new_scene(colours) if still is None else still
    rest = histogram_of_rest(colours, colours.total >= DARKEST, still)
    model = colour_model.adapt(initial_model(), np.zeros_like(rest), rest, 0.3)
    skin = classify(small, colours, model, SkinOptions())
    if skin_apart:
        skin = without_still(skin, scene.stood(colours, still))
    labels, areas, boxes = components(density(skin, odd(3.4 * u)), 120, 40.0 * u * u, 6)
    return _best_look(describe(labels, boxes, skin, colours.luma, still)) if len(areas) else 0.0


def _best_look(found: Found) -> float:
    """0 to 1, how much the best of the regions looks like a face that is one compact region."""
    compact = np.clip(4.0 - found.areas / (np.pi * np.maximum(found.cores[:, 2], 1.0) ** 2), 0.0, 2.0) / 2.0
    return float((found.faceness * (0.5 + 0.5 * compact)).max(initial=0.0))
