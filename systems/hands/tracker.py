"""The tracks of a face and two hands."""

from pydrake.common.value import Value
from pydrake.systems.framework import LeafSystem

from vipr.systems.hands.tracks import TracksBelief, follow
from vipr.systems.signals import HandTracks, SkinRegions
from vipr.systems.timing import LEDGER


class HandTracker(LeafSystem):
    """Follows face, left and right hand through the regions of skin by Kalman filters.

    .. pydrake_system::

        name: HandTracker
        input_ports:
        - regions
        output_ports:
        - hand_tracks

    Pixels of the camera frame, px/s; ``left`` is the person's left hand. Updates every ``period`` s from ``offset`` on (place it after
    the segmenter's tick); ``hand_tracks`` holds what the last new regions gave. Before them, the default ``HandTracks`` (nothing seen, NaN
    positions, number -1). Eq. (3) to (9); assignment, merging and births are in ``vipr.systems.hands.tracks``.
    """

    def __init__(self, *, period: float = 0.04, offset: float = 0.0):
        super().__init__()
        self._regions = self.DeclareAbstractInputPort("regions", Value(SkinRegions()))
        self._belief = self.DeclareAbstractState(Value(TracksBelief()))
        self.DeclareAbstractOutputPort(
            "hand_tracks", lambda: Value(HandTracks()), self._calc_tracks, {self.abstract_state_ticket(self._belief)}
        )
        self.DeclarePeriodicUnrestrictedUpdateEvent(period, offset, self._update)

    def _update(self, context, state):
        regions = self._regions.Eval(context)
        belief = context.get_abstract_state(int(self._belief)).get_value()
        if regions.number != belief.output.number:
            with LEDGER.charge("people"):
                belief = follow(regions, belief)
            state.get_mutable_abstract_state(int(self._belief)).set_value(belief)

    def _calc_tracks(self, context, output):
        output.set_value(context.get_abstract_state(int(self._belief)).get_value().output)
