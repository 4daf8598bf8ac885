"""The skin stage: from camera frames to regions of skin colour."""

from pydrake.common.value import Value
from pydrake.systems.framework import LeafSystem

from vipr.systems.signals import CameraFrame, HandTracks, SkinRegions
from vipr.systems.skin.chain import SkinBelief, see_skin
from vipr.systems.skin.classifier import SkinOptions
from vipr.systems.skin.working_image import as_bgr
from vipr.systems.timing import LEDGER


class SkinSegmenter(LeafSystem):
    """Finds the regions of skin colour of each new camera frame, and learns this person's skin, this room and its light.

    .. pydrake_system::

        name: SkinSegmenter
        input_ports:
        - frame
        - hand_tracks
        output_ports:
        - regions

    Pixels of the camera frame, pixel centres at integers. ``hand_tracks`` (optional) is feedback: what was followed in the frame before is
    not taken for a thing of the room, however still it is. Updates every ``period`` s from ``offset`` on (place it after the camera's
    tick); ``regions`` holds what the last frame with pixels gave. Before the first frame, and while frames are missing, it is what it was:
    at first the default ``SkinRegions`` (no rows, number -1). Section II-A.1 of the paper; the chain is ``vipr.systems.skin.chain``.
    """

    def __init__(self, options: SkinOptions = SkinOptions(), *, period: float = 0.04, offset: float = 0.0):
        super().__init__()
        self._options = options
        self._frame = self.DeclareAbstractInputPort("frame", Value(CameraFrame()))
        self._tracks = self.DeclareAbstractInputPort("hand_tracks", Value(HandTracks()))
        self._belief = self.DeclareAbstractState(Value(SkinBelief()))
        self.DeclareAbstractOutputPort(
            "regions", lambda: Value(SkinRegions()), self._calc_regions, {self.abstract_state_ticket(self._belief)}
        )
        self.DeclarePeriodicUnrestrictedUpdateEvent(period, offset, self._update)

    def _update(self, context, state):
        frame = self._frame.Eval(context)
        belief = context.get_abstract_state(int(self._belief)).get_value()
        if frame.arrived and frame.number != belief.regions.number:
            tracks = self._tracks.Eval(context) if self._tracks.HasValue(context) else None
            with LEDGER.charge("people"):
                belief = see_skin(as_bgr(frame.image), frame.time, frame.number, belief, self._options, tracks)
            state.get_mutable_abstract_state(int(self._belief)).set_value(belief)

    def _calc_regions(self, context, output):
        output.set_value(context.get_abstract_state(int(self._belief)).get_value().regions)
