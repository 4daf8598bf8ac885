"""The stages that see a person: skin and hands, for a rendered room and for recorded video alike (paper II-A, Fig. 3)."""

from collections.abc import Mapping
from dataclasses import dataclass

from pydrake.systems.framework import Diagram, DiagramBuilder

from vipr.diagrams.stages import Maker, Stages, connect
from vipr.systems.hands.tracker import HandTracker
from vipr.systems.skin.classifier import SkinOptions
from vipr.systems.skin.segmenter import SkinSegmenter

STAGES: Mapping[str, Maker] = {"skin": SkinSegmenter, "hands": HandTracker}


@dataclass(frozen=True)
class Schedule:
    """Period and offsets [s] of the two stages."""

    period: float = 0.04
    skin_offset: float = 0.010
    hands_offset: float = 0.015

    def rows(self) -> dict[str, tuple[float, float]]:
        """(period, offset) [s] of each stage."""
        return {"skin": (self.period, self.skin_offset), "hands": (self.period, self.hands_offset)}


class SeeingPeople(Diagram):
    """Follows a face and two hands through the frames of one camera.

    .. pydrake_system::

        name: SeeingPeople
        input_ports:
        - frame
        output_ports:
        - regions
        - hand_tracks

    ::

        frame ──▶ ┌──────┐ regions ┌───────┐ hand_tracks
                  │ skin │────────▶│ hands │────┬───────▶
                  └──────┘         └───────┘    │
                     ▲──────────────────────────┘

    Schedule (ms, with the default period of 40 and an exposure at 0):

        skin   |10  regions of the frame, with the tracks of the frame before
        hands  |15  tracks

    Pixels of the frame. ``stages`` puts others in the place of some of ``STAGES``: makers called with the same arguments, whose systems
    have the same ports.
    """

    def __init__(
        self,
        options: SkinOptions = SkinOptions(),
        *,
        schedule: Schedule = Schedule(),
        stages: Mapping[str, Maker] | None = None,
    ):
        super().__init__()
        self.schedule = schedule.rows()
        builder, made = DiagramBuilder(), Stages(STAGES, stages)
        skin = made.add(builder, "skin", options, period=schedule.period, offset=schedule.skin_offset)
        hands = made.add(builder, "hands", period=schedule.period, offset=schedule.hands_offset)
        connect(builder, [(skin, "regions", hands, "regions"), (hands, "hand_tracks", skin, "hand_tracks")])
        builder.ExportInput(skin.GetInputPort("frame"), "frame")
        builder.ExportOutput(skin.GetOutputPort("regions"), "regions")
        builder.ExportOutput(hands.GetOutputPort("hand_tracks"), "hand_tracks")
        builder.BuildInto(self)
        self.set_name("seeing_people")
