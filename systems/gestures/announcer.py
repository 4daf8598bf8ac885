"""What was seen of a person, for people: the picture with the tracks and the last gesture, and what was understood in words and numbers."""

from dataclasses import replace

import cv2
import numpy as np
from pydrake.common.value import Value
from pydrake.systems.framework import LeafSystem

from vipr.systems.hands.overlay import draw_people
from vipr.systems.hands.parts import PARTS
from vipr.systems.signals import CameraFrame, Gesture, HandTracks, SkinRegions, Status
from vipr.systems.timing import LEDGER

ANSWER = ("number", "name", "accepted", "start", "end", "named", "direction_x", "direction_y")
ANSWER_UNITS = ("", "", "", "s", "s", "s", "", "")
SHOWN_FOR = 1.5  # s that a gesture's name stays in the picture


class GestureAnnouncer(LeafSystem):
    """Draws regions, tracks and the last gesture into the frame, and says what was understood.

    .. pydrake_system::

        name: GestureAnnouncer
        input_ports:
        - frame
        - regions
        - hand_tracks
        - gesture
        output_ports:
        - picture
        - understood
        - answer

    ``picture`` (CameraFrame, BGR) is ``frame`` enlarged ``zoom`` times, with outlines, rings and the name of the last accepted gesture;
    ``understood`` (Status) changes with each movement that ended; ``answer`` (8,) is that movement in numbers, in the order of ``ANSWER``:
    its number, which of ``names`` (-1: none of them), 1 if it is accepted as a gesture, times [s], and where it points to (x right, y up;
    NaN where it does not). Feedthrough, nothing is held.
    """

    def __init__(self, names: tuple[str, ...], *, zoom: int = 4):
        super().__init__()
        self._names, self._zoom = tuple(names), zoom
        self._frame = self.DeclareAbstractInputPort("frame", Value(CameraFrame()))
        self._regions = self.DeclareAbstractInputPort("regions", Value(SkinRegions()))
        self._tracks = self.DeclareAbstractInputPort("hand_tracks", Value(HandTracks()))
        self._gesture = self.DeclareAbstractInputPort("gesture", Value(Gesture()))
        seen = {p.ticket() for p in (self._frame, self._regions, self._tracks, self._gesture)}
        last = {self._gesture.ticket()}
        self.DeclareAbstractOutputPort("picture", lambda: Value(CameraFrame()), self._calc_picture, seen)
        self.DeclareAbstractOutputPort("understood", lambda: Value(Status()), self._calc_understood, last)
        self.DeclareVectorOutputPort("answer", len(ANSWER), self._calc_answer, last)

    def _calc_picture(self, context, output):
        frame, gesture = self._frame.Eval(context), self._gesture.Eval(context)
        regions, tracks = self._regions.Eval(context), self._tracks.Eval(context)
        if frame.arrived:
            with LEDGER.charge("logging"):
                large = cv2.resize(frame.image, None, fx=self._zoom, fy=self._zoom, interpolation=cv2.INTER_CUBIC)
                image = draw_people(large, regions, _enlarged(tracks, self._zoom))
                if not gesture.rejected and frame.time - gesture.named < SHOWN_FOR:
                    _write(image, gesture.name)
            frame = replace(frame, image=image)
        output.set_value(frame)

    def _calc_understood(self, context, output):
        gesture = self._gesture.Eval(context)
        if gesture.number < 0:
            text = ""
        else:
            name = "no gesture" if gesture.rejected else f"{gesture.name} ({100 * gesture.probability:.0f} %)"
            text = f"{name}, from {gesture.start:.2f} to {gesture.end:.2f} s"
        output.set_value(Status(text))

    def _calc_answer(self, context, output):
        gesture = self._gesture.Eval(context)
        name = self._names.index(gesture.name) if gesture.name in self._names else -1
        accepted = gesture.number >= 0 and not gesture.rejected
        times = (gesture.start, gesture.end, gesture.named)
        output.SetFromVector([gesture.number, name, accepted, *times, *gesture.direction])


def _enlarged(tracks: HandTracks, zoom: int) -> HandTracks:
    """The tracks in a picture enlarged ``zoom`` times (pixel centres at integers)."""
    return replace(tracks, **{part: zoom * getattr(tracks, part) + 0.5 * (zoom - 1) for part in PARTS})


def _write(image: np.ndarray, text: str) -> None:
    """A line of text at the picture's foot, readable on any ground."""
    height, place = image.shape[0], (12, image.shape[0] - 16)
    for colour, thick in (((0, 0, 0), 5), ((255, 255, 255), 2)):
        cv2.putText(image, text, place, cv2.FONT_HERSHEY_SIMPLEX, height / 400, colour, thick, cv2.LINE_AA)
