"""Examples of the camera's systems for the laws."""

import numpy as np
from pydrake.systems.sensors import ImageRgba8U

from vipr.systems.camera.camera import Camera
from vipr.systems.camera.imperfections import Imperfection


def camera():
    system = Camera(64, 48, imperfection=Imperfection(noise=2.0, dropped=0.3, exposure=0.8), seed=5)

    def fix(context, t):
        image = ImageRgba8U(64, 48)
        image.mutable_data[:] = np.arange(64, dtype=np.uint8)[None, :, None] + np.uint8(10 * t)
        system.get_input_port().FixValue(context, image)

    return system, fix


EXAMPLES = {Camera: camera}
