"""The tracked pose drawn into the camera's picture, for the film."""

from pydrake.common.value import Value
from pydrake.systems.framework import LeafSystem

from vipr.systems.camera.lens import Lens
from vipr.systems.signals import CameraFrame, ObjectPose
from vipr.systems.timing import LEDGER
from vipr.systems.tracking.cad_model import CadModel
from vipr.systems.tracking.overlay import draw_overlay


class PoseAnnotator(LeafSystem):
    """Draws the model's visible edges at the tracked pose over the frame they were found in.

    .. pydrake_system::

        name: PoseAnnotator
        input_ports:
        - frame
        - object_pose
        output_ports:
        - picture

    ``picture`` (CameraFrame, BGR) is ``frame`` with the edges in the colour of the tracker's state; a frame that did not arrive is passed
    on as it is. Feedthrough, nothing is held.
    """

    def __init__(self, model: CadModel, lens: Lens):
        super().__init__()
        self._model, self._lens = model, lens
        self._frame = self.DeclareAbstractInputPort("frame", Value(CameraFrame()))
        self._pose = self.DeclareAbstractInputPort("object_pose", Value(ObjectPose()))
        ticket = {self._frame.ticket(), self._pose.ticket()}
        self.DeclareAbstractOutputPort("picture", lambda: Value(CameraFrame()), self._calc_picture, ticket)

    def _calc_picture(self, context, output):
        with LEDGER.charge("logging"):
            frame, seen = self._frame.Eval(context), self._pose.Eval(context)
            if frame.arrived:
                image = draw_overlay(frame.image, self._model, self._lens, seen.X_CO, seen.state, f"{frame.time:.2f} s")
                frame = CameraFrame(image=image, time=frame.time, number=frame.number)
            output.set_value(frame)
