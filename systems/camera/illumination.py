"""The light of a room on a camera of fixed white balance: intensity and colour temperature as gains of the linear image.

Pure functions; :class:`~vipr.systems.camera.room_light.RoomLight` is the shell. One light for the whole scene (a diagonal change of
the three channels); the camera's response is linear and clips at 255.
"""

from functools import lru_cache

import cv2
import numpy as np

from vipr.systems.errors import InputError

# Sensor sensitivities as Gaussians over wavelength: centre and standard deviation [nm] for blue, green, red.
SENSITIVITY = ((460.0, 30.0), (540.0, 38.0), (605.0, 36.0))
WHITE_KELVIN = 5000.0  # colour temperature at which the camera's white is white
KELVIN_RANGE = (1500.0, 20000.0)


def planck(wavelength_nm: np.ndarray, kelvin: float) -> np.ndarray:
    """Relative spectral power of a black body (Planck's law, any common factor left out)."""
    metres = np.asarray(wavelength_nm, float) * 1e-9
    return metres**-5 / np.expm1(1.4388e-2 / (metres * kelvin))


@lru_cache(maxsize=512)
def _response(kelvin: float) -> tuple[float, ...]:
    nm = np.arange(380.0, 731.0, 5.0)
    power = planck(nm, kelvin)
    return tuple(float((power * np.exp(-0.5 * ((nm - c) / s) ** 2)).sum()) for c, s in SENSITIVITY)


def light_gains(intensity: float, kelvin: float, white_kelvin: float = WHITE_KELVIN) -> np.ndarray:
    """(3,) gains of B, G, R for a black-body light, against the light at which the camera shows white as white; mean gain = intensity."""
    if not np.isfinite(intensity) or intensity < 0:
        raise InputError(f"light: intensity must be 0 or more, got {intensity}")
    if not KELVIN_RANGE[0] <= kelvin <= KELVIN_RANGE[1]:
        raise InputError(
            f"light: colour temperature must be {KELVIN_RANGE[0]:.0f} to {KELVIN_RANGE[1]:.0f} K, got {kelvin} K"
        )
    gains = np.divide(_response(float(kelvin)), _response(float(white_kelvin)))
    return intensity * gains / gains.mean()


def illuminate(image: np.ndarray, intensity: float, kelvin: float) -> np.ndarray:
    """The image (h, w, 3) BGR uint8 as it looks under this light."""
    levels = np.arange(256.0)[:, None] * light_gains(intensity, kelvin)
    table = np.clip(np.rint(levels), 0, 255).astype(np.uint8).reshape(1, 256, 3)
    return cv2.LUT(image, table)
