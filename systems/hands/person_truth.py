"""Ground truth of face and hands from the label image of a rendered camera."""

from pydrake.common.value import Value
from pydrake.systems.framework import LeafSystem
from pydrake.systems.sensors import ImageLabel16I

from vipr.systems.hands.label_truth import tracks_from_labels
from vipr.systems.signals import HandTracks
from vipr.systems.timing import LEDGER


class PersonTruth(LeafSystem):
    """Reports the visible face and hands of the label image at each camera tick.

    .. pydrake_system::

        name: PersonTruth
        input_ports:
        - label_image
        output_ports:
        - hand_tracks_true

    Pixels of the label image, pixel centres at integers; labels as in :mod:`~vipr.systems.hands.label_truth`. Sampled every ``period`` s
    from ``offset`` on and held; before the first tick the default ``HandTracks`` (nothing seen, number -1). Velocities are zero.
    """

    def __init__(self, period: float = 0.04, offset: float = 0.0):
        super().__init__()
        self._period, self._offset = period, offset
        self._labels = self.DeclareAbstractInputPort("label_image", Value(ImageLabel16I(1, 1)))
        self._held = self.DeclareAbstractState(Value(HandTracks()))
        self.DeclareStateOutputPort("hand_tracks_true", self._held)
        self.DeclarePeriodicUnrestrictedUpdateEvent(period, offset, self._update)

    def _update(self, context, state):
        with LEDGER.charge("render"):
            labels = self._labels.Eval(context).data
        with LEDGER.charge("logging"):
            time = context.get_time()
            tracks = tracks_from_labels(labels[:, :, 0], time, round((time - self._offset) / self._period))
            state.get_mutable_abstract_state(int(self._held)).set_value(tracks)
