"""Skin pixels: precision and recall of the classifiers on labelled pixels, photographs and rendered rooms."""

import gzip
from pathlib import Path

import cv2
import numpy as np

from vipr.diagrams.living_room import ROOM_LABEL
from vipr.scenarios.bench.people.rooms import film
from vipr.scenarios.people.scenes import random_scene
from vipr.systems.skin.chain import SkinBelief, see_skin
from vipr.systems.skin.chromaticity import chromaticity, lookup
from vipr.systems.skin.classifier import SkinOptions, classify
from vipr.systems.skin.colour_model import initial_model, skin_table
from vipr.systems.skin.locus import SkinBox, box_table

BARE = {
    "face": 1,
    "left_hand": 2,
    "right_hand": 3,
    "neck": 10,
    "left_forearm": 16,
    "right_forearm": 17,
}  # labels that can be skin


def scores(found: np.ndarray, true: np.ndarray) -> tuple[float, float]:
    """Precision and recall of boolean arrays."""
    hit = np.count_nonzero(found & true)
    return hit / max(np.count_nonzero(found), 1), hit / max(np.count_nonzero(true), 1)


def classifiers() -> dict:
    """Name of each classifier before it knows anybody: image (h, w, 3) -> boolean skin."""
    tables = {
        "box": box_table(SkinBox(), locus=False),
        "box and locus": box_table(SkinBox()),
        "prior": skin_table(initial_model(), prior_odds=1.0),
    }
    found = {name: lambda image, t=t: lookup(t, chromaticity(image).index) > 127 for name, t in tables.items()}
    hsi = SkinOptions(classifier="hsi")
    found["hue and saturation"] = lambda image: classify(image, chromaticity(image), initial_model(), hsi) > 127
    return found


def uci_pixels(data: Path) -> tuple[np.ndarray, np.ndarray]:
    """Pixels (n, 1, 3) BGR uint8 and whether they are skin (n, 1) of the UCI Skin Segmentation set."""
    with gzip.open(data / "skin" / "Skin_NonSkin.txt.gz", "rt") as file:
        table = np.loadtxt(file, dtype=np.int64)
    return table[:, None, :3].astype(np.uint8), table[:, 3:] == 1


def photographs(data: Path):
    """(name, photograph, boolean skin of the face) of the photographs with masks; each mask is a cut-out, found again in its photograph."""
    for path in sorted((data / "images" / "skin_masks").rglob("raw/*.png")):
        cut = cv2.imread(str(path.parents[1] / "mask" / path.name.replace("A", "B", 1)))
        photo = cv2.imread(str(path))
        if cut is None or photo is None:
            continue
        kept = ~((cut[:, :, 1] > 200) & (cut[:, :, 0] < 60) & (cut[:, :, 2] < 60))
        match = cv2.matchTemplate(
            photo, cut, cv2.TM_SQDIFF, mask=np.repeat(kept[:, :, None].astype(np.uint8), 3, axis=2)
        )
        _, _, (x, y), _ = cv2.minMaxLoc(match)
        skin = np.zeros(photo.shape[:2], bool)
        skin[y : y + cut.shape[0], x : x + cut.shape[1]] = kept
        yield path.stem, photo, skin


def room_pixels(decor: str, seeds, settle: int = 25, frames: int = 60) -> dict[str, tuple[float, float]]:
    """Precision and recall of skin pixels (face, neck, hands, bare forearms) per classifier in rooms of a decor, after the first second.

    ``chain`` is the whole first stage: adapted histograms, still scene, density and components.
    """
    hits = {}
    for seed in seeds:
        scene, belief = random_scene(seed, decors=(decor,)), SkinBelief()
        bare = [k for name, k in BARE.items() if scene.look.sleeves == "short" or not name.endswith("forearm")]
        for k, (image, labels) in enumerate(film(scene)):
            if k >= settle + frames:
                break
            belief = see_skin(image, k / 25.0, k, belief)
            if k < settle:
                continue
            true = np.isin(labels, bare)
            found = {name: f(image) for name, f in classifiers().items()} | {"chain": belief.regions.labels > 0}
            for name, mask in found.items():
                hit, claimed, existing = hits.get(name, (0, 0, 0))
                hits[name] = (hit + (mask & true).sum(), claimed + mask.sum(), existing + true.sum())
    assert ROOM_LABEL not in BARE.values()
    return {name: (hit / max(claimed, 1), hit / max(existing, 1)) for name, (hit, claimed, existing) in hits.items()}
