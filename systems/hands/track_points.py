"""Tracks as plain numbers, for logs, plots and comparison with the truth."""

import numpy as np
from pydrake.common.value import Value
from pydrake.systems.framework import LeafSystem

from vipr.systems.hands.parts import PARTS
from vipr.systems.signals import HandTracks

POINTS = tuple(f"{part}_{axis}" for part in PARTS for axis in "xy")


class TrackPoints(LeafSystem):
    """Where face, left and right hand are seen.

    .. pydrake_system::

        name: TrackPoints
        input_ports:
        - hand_tracks
        output_ports:
        - points

    ``points`` (6,) is x, y [px of the frame] of each part in the order of ``POINTS``, NaN while it is not seen. Feedthrough, nothing is
    held.
    """

    def __init__(self):
        super().__init__()
        self._tracks = self.DeclareAbstractInputPort("hand_tracks", Value(HandTracks()))
        self.DeclareVectorOutputPort("points", len(POINTS), self._calc_points, {self._tracks.ticket()})

    def _calc_points(self, context, output):
        tracks = self._tracks.Eval(context)
        unseen = np.full(2, np.nan)
        output.SetFromVector(
            np.concatenate([getattr(tracks, p) if getattr(tracks, f"{p}_seen") else unseen for p in PARTS])
        )
