"""What a camera adds to a perfect picture: blur, exposure, colour cast, gamma, noise, dropped frames."""

from dataclasses import dataclass

import cv2
import numpy as np

from vipr.systems.errors import InputError


@dataclass(frozen=True)
class Imperfection:
    """How imperfect the camera is; the default is a good video camera (Sony XC-77: 50 dB, about 0.8 grey levels of noise)."""

    noise: float = 0.8  # grey levels RMS of 255, each pixel and channel
    blur: float = 0.5  # px, standard deviation of the optical blur
    exposure: float = 1.0  # gain on intensity
    colour_cast: tuple[float, float, float] = (1.0, 1.0, 1.0)  # gains of red, green, blue
    gamma: float = 1.0  # output = input ** (1 / gamma)
    dropped: float = 0.0  # share of frames that never arrive

    def __post_init__(self):
        for name, low, high in (("noise", 0, 255), ("blur", 0, 50), ("dropped", 0, 1)):
            value = getattr(self, name)
            if not low <= value <= high:
                raise InputError(f"camera: {name} must be {low} to {high}, got {value}")
        if len(self.colour_cast) != 3:
            raise InputError(f"camera: colour_cast needs 3 gains (red, green, blue), got {len(self.colour_cast)}")
        if not (self.exposure > 0 and self.gamma > 0 and min(self.colour_cast) > 0):
            raise InputError(
                f"camera: exposure, gamma and colour_cast must be positive, got {self.exposure}, {self.gamma}, {self.colour_cast}"
            )


class ImperfectCamera:
    """Applies an Imperfection to images of one size; the k-th frame of a seed is always the same.

    The noise is Gaussian, cut from a bank at a place that depends on seed and frame number: a fresh draw would cost ten times as much.
    """

    _MARGIN = 97  # px; the bank is this much larger than the image, which gives 97^2 different fields of noise

    def __init__(self, imperfection: Imperfection, width: int, height: int, seed: int):
        self._imperfection, self._seed = imperfection, seed
        ramp = np.arange(256) / 255.0
        gains = imperfection.exposure * np.array(imperfection.colour_cast[::-1])  # B, G, R
        tone = np.clip(ramp[:, None] * gains, 0.0, 1.0) ** (1.0 / imperfection.gamma)
        self._table = np.round(255.0 * tone).astype(np.uint8)[None]
        self._linear = np.array_equal(self._table[0], np.tile(np.arange(256, dtype=np.uint8)[:, None], 3))
        self._bank = None
        if imperfection.noise > 0:
            shape = (height + self._MARGIN, width + self._MARGIN, 3)
            noise = np.random.default_rng(seed).normal(0.0, imperfection.noise, shape)
            self._bank = np.round(noise).astype(np.int16)

    def drops(self, number: int) -> bool:
        """Whether frame ``number`` never arrives."""
        p = self._imperfection.dropped
        return p > 0 and np.random.default_rng((self._seed, number, 1)).random() < p

    def expose(self, image: np.ndarray, number: int) -> np.ndarray:
        """The picture (h, w, 3) BGR uint8 as frame ``number`` of this camera shows it."""
        if self._imperfection.blur > 0:
            image = cv2.GaussianBlur(image, (0, 0), self._imperfection.blur)
        if not self._linear:
            image = cv2.LUT(image, self._table)
        if self._bank is not None:
            y, x = np.random.default_rng((self._seed, number)).integers(self._MARGIN, size=2)
            height, width = image.shape[:2]
            image = cv2.add(image, self._bank[y : y + height, x : x + width], dtype=cv2.CV_8U)
        return image
