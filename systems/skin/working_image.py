"""Any picture as the chain works on it: 8-bit BGR, reduced to a working size."""

import cv2
import numpy as np

from vipr.systems.errors import InputError


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
    while (
        image.shape[0] % 2 == image.shape[1] % 2 == 0
        and image.shape[1] >= 2 * size[0]
        and image.shape[0] >= 2 * size[1]
    ):
        image = cv2.resize(
            image, None, fx=0.5, fy=0.5, interpolation=cv2.INTER_AREA
        )  # several times faster than all at once
    return cv2.resize(image, size, interpolation=cv2.INTER_AREA), float(factor)


def unit(shape) -> float:
    """1 at 160 x 120; lengths in pixels grow with it."""
    return float(np.sqrt(shape[0] * shape[1] / 19200.0))


def odd(x: float) -> int:
    """The odd number nearest to x, at least 3."""
    return max(3, 2 * int(x / 2) + 1)
