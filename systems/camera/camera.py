"""The camera as a stage: exposes a rendered picture at its own clock."""

import cv2
import numpy as np
from pydrake.common.value import Value
from pydrake.systems.framework import LeafSystem
from pydrake.systems.sensors import ImageRgba8U

from vipr.systems.camera.imperfections import ImperfectCamera, Imperfection
from vipr.systems.signals import CameraFrame
from vipr.systems.timing import LEDGER


class Camera(LeafSystem):
    """Takes a picture at each tick, with the imperfections of a real camera.

    .. pydrake_system::

        name: Camera
        input_ports:
        - color_image
        - watching
        output_ports:
        - frame

    ``color_image`` is Drake's rendered ImageRgba8U, evaluated (and so rendered) at the ticks only, with ``supersampling`` times as many
    pixels each way; a pixel of the frame is the mean of its pixels, as a sensor's cell integrates over its area. ``frame`` (CameraFrame,
    BGR) holds the last tick's picture; before the first tick, and after a tick whose frame is dropped, its image is empty. While
    ``watching`` (1) is 0 no picture is taken and the last one is kept; left unconnected, all are. Same seed, same bytes.
    """

    def __init__(
        self,
        width: int,
        height: int,
        *,
        imperfection: Imperfection = Imperfection(),
        supersampling: int = 1,
        seed: int = 0,
        period: float = 0.04,
        offset: float = 0.0,
    ):
        super().__init__()
        self._electronics = ImperfectCamera(imperfection, width, height, seed)
        self._period, self._offset = period, offset
        self._size, k = (width, height), supersampling
        self._picture = self.DeclareAbstractInputPort("color_image", Value(ImageRgba8U(k * width, k * height)))
        self._watching = self.DeclareVectorInputPort("watching", 1)
        state = self.DeclareAbstractState(Value(CameraFrame()))
        self._frame = state
        self.DeclareStateOutputPort("frame", state)
        self.DeclarePeriodicUnrestrictedUpdateEvent(period, offset, self._update)

    def _update(self, context, state):
        if self._watching.HasValue(context) and self._watching.Eval(context)[0] < 0.5:
            return
        number = round((context.get_time() - self._offset) / self._period)
        image = np.zeros((0, 0, 3), np.uint8)
        if not self._electronics.drops(number):
            with LEDGER.charge("render"):
                rendered = self._picture.Eval(context)
            with LEDGER.charge("camera"):
                picture = cv2.resize(rendered.data, self._size, interpolation=cv2.INTER_AREA)
                image = self._electronics.expose(cv2.cvtColor(picture, cv2.COLOR_RGBA2BGR), number)
        frame = CameraFrame(image=image, time=context.get_time(), number=number)
        state.get_mutable_abstract_state(self._frame).set_value(frame)
