"""Gestures as they are made: movements cut out of the tracks of face and hands, named as soon as they end."""

from dataclasses import dataclass, field

import numpy as np
from pydrake.common.value import Value
from pydrake.systems.framework import LeafSystem

from vipr.systems.gestures.body import BodyBelief, direction, seen_from_face, told_apart
from vipr.systems.gestures.classifier import GestureClassifier
from vipr.systems.gestures.segmentation import MotionBelief, PauseSettings, advance
from vipr.systems.signals import Gesture, HandTracks
from vipr.systems.timing import LEDGER

POINTING = ("fetch", "put")


@dataclass(frozen=True, eq=False)
class RecogniserBelief:
    """What the recogniser knows after a frame."""

    body: BodyBelief = field(default_factory=BodyBelief)
    motion: MotionBelief = field(default_factory=MotionBelief)
    gesture: Gesture = field(default_factory=Gesture)
    number: int = -1  # of the last frame


def watch(
    belief: RecogniserBelief,
    tracks: HandTracks,
    classifier: GestureClassifier,
    settings: PauseSettings,
    pointing=POINTING,
) -> RecogniserBelief:
    """The belief after one more frame's tracks."""
    body, point = seen_from_face(belief.body, tracks)
    if point is None:
        return RecogniserBelief(body, belief.motion, belief.gesture, tracks.number)
    motion, movement = advance(belief.motion, tracks.time, point, settings)
    gesture = belief.gesture
    if movement is not None:
        movement = told_apart(movement)
        (name,), (probability,), (rejected,) = classifier.recognise([movement])
        gesture = Gesture(
            name=str(name),
            probability=float(probability),
            rejected=bool(rejected),
            start=float(movement.times[0]),
            end=float(movement.times[-1]),
            named=tracks.time,
            direction=direction(movement.points) if str(name) in pointing else np.full(2, np.nan),
            number=gesture.number + 1,
        )
    return RecogniserBelief(body, motion, gesture, tracks.number)


class GestureRecogniser(LeafSystem):
    """Cuts the tracks of face and hands into movements at pauses and names each by hidden Markov models.

    .. pydrake_system::

        name: GestureRecogniser
        input_ports:
        - hand_tracks
        output_ports:
        - gesture

    Tracks in pixels; inside, points are in faces from the face, y up. Updates every ``period`` s from ``offset`` on (place it after the
    tracker's tick). ``gesture`` holds the last movement that ended, named within 200 ms of its end, a rejected one included; its ``number``
    counts movements. Before the first, the default ``Gesture`` (number -1, no name). Sections II-A.3 and II-A.4 of the paper, eq. (10) to
    (24).
    """

    def __init__(
        self, classifier: GestureClassifier, *, settings: PauseSettings | None = None, pointing: tuple[str, ...] = POINTING,
        period: float = 0.04, offset: float = 0.0,
    ):  # fmt: skip
        super().__init__()
        self._classifier, self._settings, self._pointing = classifier, settings or PauseSettings(), pointing
        self._tracks = self.DeclareAbstractInputPort("hand_tracks", Value(HandTracks()))
        self._belief = self.DeclareAbstractState(Value(RecogniserBelief()))
        self.DeclareAbstractOutputPort(
            "gesture", lambda: Value(Gesture()), self._calc_gesture, {self.abstract_state_ticket(self._belief)}
        )
        self.DeclarePeriodicUnrestrictedUpdateEvent(period, offset, self._update)

    def _update(self, context, state):
        tracks = self._tracks.Eval(context)
        belief = context.get_abstract_state(int(self._belief)).get_value()
        if tracks.number != belief.number:
            with LEDGER.charge("people"):
                belief = watch(belief, tracks, self._classifier, self._settings, self._pointing)
            state.get_mutable_abstract_state(int(self._belief)).set_value(belief)

    def _calc_gesture(self, context, output):
        output.set_value(context.get_abstract_state(int(self._belief)).get_value().gesture)
