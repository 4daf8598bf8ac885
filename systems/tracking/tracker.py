"""The model-based tracker as a system: frames in, pose of one object out."""

from dataclasses import dataclass, field, replace

import numpy as np
from pydrake.common.value import Value
from pydrake.systems.framework import LeafSystem

from vipr.systems.camera.lens import Lens
from vipr.systems.signals import CameraFrame, ObjectPose, Occluders
from vipr.systems.timing import LEDGER
from vipr.systems.tracking.belief import Belief, start
from vipr.systems.tracking.cad_model import CadModel
from vipr.systems.tracking.known_view import KnownView, known_keyframe
from vipr.systems.tracking.model_tracking import step
from vipr.systems.tracking.settings import TrackerSettings


@dataclass(frozen=True, eq=False)
class _Memory:
    """What the system keeps between ticks: the belief, and the last re-initialisation that was taken up."""

    belief: Belief = field(default_factory=Belief)
    frame_number: int = -1
    initial_time: float = -np.inf

    def __deepcopy__(self, memo):
        return self  # immutable


class ModelTracker(LeafSystem):
    """Tracks an object of known CAD model through the frames of one camera.

    .. pydrake_system::

        name: ModelTracker
        input_ports:
        - frame
        - initial_pose
        - occluders
        output_ports:
        - object_pose

    Frames: O the object's (of its model file), C the camera's (x right, y down, z forward). At each tick (period, offset [s]) a new frame
    is taken up: one step of ``model_tracking``; a dropped frame (no pixels) only predicts; the same frame again does nothing. The pose is
    held between ticks. Before the first frame it is lost. ``X_CO_initial`` (4, 4) starts the search in the first frame; an
    ``initial_pose`` (may be left unconnected) whose state is not lost and whose time is new starts it afresh. ``occluders`` (may be left
    unconnected) are bodies known to stand in front. ``views`` are pictures of the object whose poses are known.

    Source: paper III-B, Fig. 6, equations 25 to 35.
    """

    def __init__(
        self,
        model: CadModel,
        lens: Lens,
        *,
        X_CO_initial: np.ndarray | None = None,
        settings: TrackerSettings | None = None,
        views: tuple[KnownView, ...] = (),
        period: float = 0.04,
        offset: float = 0.0,
    ):
        super().__init__()
        self._model, self._lens = model, lens
        self._settings = settings or TrackerSettings()
        known = [known_keyframe(view, model, lens, self._settings.patches) for view in views if self._settings.texture]
        self._known = tuple(keyframe for keyframe in known if keyframe is not None)
        self._frame = self.DeclareAbstractInputPort("frame", Value(CameraFrame()))
        self._initial = self.DeclareAbstractInputPort("initial_pose", Value(ObjectPose()))
        self._occluders = self.DeclareAbstractInputPort("occluders", Value(Occluders()))
        belief = Belief() if X_CO_initial is None else start(X_CO_initial, keyframes=self._known)
        self._memory = self.DeclareAbstractState(Value(_Memory(belief)))
        self.DeclarePeriodicUnrestrictedUpdateEvent(period, offset, self._update)
        self.DeclareAbstractOutputPort(
            "object_pose",
            lambda: Value(ObjectPose()),
            self._calc_object_pose,
            prerequisites_of_calc={self.abstract_state_ticket(self._memory)},
        )

    def _update(self, context, state):
        with LEDGER.charge("vision"):
            memory = context.get_abstract_state(self._memory).get_value()
            frame = self._frame.Eval(context)
            if self._initial.HasValue(context):
                initial = self._initial.Eval(context)
                if initial.state != "lost" and initial.time > memory.initial_time:
                    belief = start(initial.X_CO, keyframes=self._known)
                    memory = replace(memory, belief=belief, initial_time=initial.time)
            if frame.number > memory.frame_number and memory.belief.started:
                occluders = self._occluders.Eval(context).triangles_C if self._occluders.HasValue(context) else None
                image = self._lens.undistort(frame.image) if frame.arrived else frame.image
                belief = step(
                    memory.belief, image, frame.time, self._model, self._lens, self._settings, occluders, frame.number
                )
                memory = replace(memory, belief=belief, frame_number=frame.number)
            state.get_mutable_abstract_state(self._memory).set_value(memory)

    def _calc_object_pose(self, context, output):
        output.set_value(object_pose(context.get_abstract_state(self._memory).get_value().belief))


def object_pose(belief: Belief) -> ObjectPose:
    """The belief as the signal that the other systems read."""
    if belief.number < 0:
        return ObjectPose()
    return ObjectPose(
        X_CO=belief.X_CO.copy(),
        V_CO=belief.V_CO.copy(),
        covariance=belief.covariance.copy(),
        state=belief.state,
        time=belief.time,
        number=belief.number,
        nodes=belief.nodes,
        residual_px=belief.residual_px,
        score=belief.score,
    )
