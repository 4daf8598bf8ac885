"""The light of the room between the rendered image and the camera frame."""

import numpy as np
from pydrake.common.value import Value
from pydrake.systems.framework import LeafSystem
from pydrake.systems.sensors import ImageRgba8U

from vipr.systems.camera.illumination import WHITE_KELVIN, illuminate
from vipr.systems.camera.imperfections import ImperfectCamera
from vipr.systems.signals import CameraFrame
from vipr.systems.timing import LEDGER


class RoomLight(LeafSystem):
    """Turns a rendered image into the camera frame that this light would give, at each camera tick.

    .. pydrake_system::

        name: RoomLight
        input_ports:
        - color_image
        - light
        output_ports:
        - frame

    ``light`` is (intensity, colour temperature [K]); unconnected, it is (1, 5000 K), at which the frame is the image. ``electronics`` add
    what a camera adds (none if not given). Sampled every ``period`` s from ``offset`` on and held; before the first tick, and at a tick
    whose frame is dropped, the ``CameraFrame`` is empty.
    """

    def __init__(self, period: float = 0.04, offset: float = 0.0, electronics: ImperfectCamera | None = None):
        super().__init__()
        self._period, self._offset, self._electronics = period, offset, electronics
        self._image = self.DeclareAbstractInputPort("color_image", Value(ImageRgba8U(1, 1)))
        self._light = self.DeclareVectorInputPort("light", 2)
        self._held = self.DeclareAbstractState(Value(CameraFrame()))
        self.DeclareStateOutputPort("frame", self._held)
        self.DeclarePeriodicUnrestrictedUpdateEvent(period, offset, self._update)

    def _update(self, context, state):
        time = context.get_time()
        number, image = round((time - self._offset) / self._period), np.zeros((0, 0, 3), np.uint8)
        if self._electronics is None or not self._electronics.drops(number):
            with LEDGER.charge("render"):
                rgba = self._image.Eval(context).data
            light = self._light.Eval(context) if self._light.HasValue(context) else (1.0, WHITE_KELVIN)
            with LEDGER.charge("camera"):
                image = illuminate(rgba[:, :, 2::-1].copy(), *light)
                image = image if self._electronics is None else self._electronics.expose(image, number)
        state.get_mutable_abstract_state(int(self._held)).set_value(CameraFrame(image, time, number))
