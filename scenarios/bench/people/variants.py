"""The real clips as other cameras would have taken them: how far hit rates hang on what should not matter."""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np

from vipr.scenarios.bench.people.clips import REFERENCE, Hits, clips_with_reference, score_clip
from vipr.systems.camera.illumination import WHITE_KELVIN, illuminate
from vipr.systems.camera.video_frames import open_video
from vipr.systems.hands.pipeline import PeopleBelief, see_people
from vipr.systems.skin.working_image import as_bgr

SIDE, TOP = 0.05, 0.06  # of the picture, cut off by ``cropped`` at either side and above
MARGIN = 0.2  # of its width, added at either side by ``beige margin``
BEIGE = (150, 180, 205)  # BGR
SMALLER = 0.9


@dataclass(frozen=True)
class Variant:
    """What is done to every picture of a clip, and where that puts a point of it."""

    picture: Callable[[np.ndarray], np.ndarray] = lambda image: image
    scale: float = 1.0
    cut: tuple[float, float] = (0.0, 0.0)  # off the left side and the top, in widths and heights; less than 0: added
    mirrored: bool = False
    every: int = 1  # frames


def _crop(image: np.ndarray) -> np.ndarray:
    height, width = image.shape[:2]
    return image[int(TOP * height) :, int(SIDE * width) : width - int(SIDE * width)]


def _margin(image: np.ndarray) -> np.ndarray:
    side = int(MARGIN * image.shape[1])
    return cv2.copyMakeBorder(image, 0, 0, side, side, cv2.BORDER_CONSTANT, value=BEIGE)


def _gamma(power: float) -> Callable[[np.ndarray], np.ndarray]:
    table = np.rint(255.0 * (np.arange(256) / 255.0) ** power).astype(np.uint8)
    return lambda image: cv2.LUT(image, table)


def _jpeg(image: np.ndarray, quality: int = 30) -> np.ndarray:
    return cv2.imdecode(cv2.imencode(".jpg", image, [cv2.IMWRITE_JPEG_QUALITY, quality])[1], cv2.IMREAD_COLOR)


VARIANTS = {
    "as it is": Variant(),
    "mirrored": Variant(lambda i: np.ascontiguousarray(i[:, ::-1]), mirrored=True),
    "cropped": Variant(_crop, cut=(SIDE, TOP)),
    "smaller": Variant(lambda i: cv2.resize(i, None, fx=SMALLER, fy=SMALLER, interpolation=cv2.INTER_AREA), SMALLER),
    "beige margin": Variant(_margin, cut=(-MARGIN, 0.0)),
    "gamma 0.75": Variant(_gamma(0.75)),
    "gamma 1.35": Variant(_gamma(1.35)),
    "darker": Variant(lambda i: illuminate(i, 0.6, WHITE_KELVIN)),
    "warmer": Variant(lambda i: illuminate(i, 1.0, 4300.0)),
    "cooler": Variant(lambda i: illuminate(i, 1.0, 6000.0)),
    "JPEG 30": Variant(_jpeg),
    "every other frame": Variant(every=2),
}


def moved(row: dict, variant: Variant, size: tuple[int, int]) -> dict:
    """A row of the reference of a clip of ``size`` (width, height) px, for a variant of it."""
    other = {"left": "right", "right": "left"} if variant.mirrored else {}
    cut = [int(share * length) for share, length in zip(variant.cut, size, strict=True)]
    out = {"shoulder_px": variant.scale * row["shoulder_px"]}
    for part, column in REFERENCE.items():
        source = REFERENCE[other.get(part, part)]
        x, y = row[f"{source}_x"], row[f"{source}_y"]
        x = size[0] - 1 - x if variant.mirrored else x
        out |= {f"{column}_x": variant.scale * x - cut[0], f"{column}_y": variant.scale * y - cut[1]}
        out[f"{column}_vis"] = row[f"{source}_vis"]
    return out


def run_variant(data: Path, variant: Variant, most: int | None = None) -> list[Hits]:
    """Hits in a variant of every clip below ``data``/video that has a reference beside it."""
    result = []
    for name, video, rows in clips_with_reference(data):
        tracks, size = [], None
        belief = PeopleBelief()
        for number, (image, at) in enumerate(open_video(video).frames):
            image = as_bgr(image)
            size = image.shape[1::-1]
            if number % variant.every == 0:
                belief = see_people(variant.picture(image), at, number, belief)
                tracks.append(belief.tracks)
            if number + 1 == most:
                break
        rows = [moved(row, variant, size) for row in rows[:most][:: variant.every]]
        result += score_clip(name, tracks, rows)
    return result
