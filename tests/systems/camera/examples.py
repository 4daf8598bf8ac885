"""Examples of the camera's systems for the laws."""

import numpy as np
from pydrake.systems.sensors import ImageRgba8U

from vipr.systems.camera.camera import Camera
from vipr.systems.camera.imperfections import Imperfection
from vipr.systems.camera.room_light import RoomLight


def camera():
    system = Camera(64, 48, imperfection=Imperfection(noise=2.0, dropped=0.3, exposure=0.8), seed=5)

    def fix(context, t):
        image = ImageRgba8U(64, 48)
        image.mutable_data[:] = np.arange(64, dtype=np.uint8)[None, :, None] + np.uint8(10 * t)
        system.GetInputPort("color_image").FixValue(context, image)
        system.GetInputPort("watching").FixValue(context, [float(t < 0.2)])

    return system, fix


def room_light():
    system = RoomLight()

    def fix(context, t):
        image = ImageRgba8U(32, 24)
        image.mutable_data[:] = 100
        system.GetInputPort("color_image").FixValue(context, image)
        system.GetInputPort("light").FixValue(context, [1.0 - t, 3000.0 + 1000 * t])

    return system, fix


EXAMPLES = {Camera: camera, RoomLight: room_light}
