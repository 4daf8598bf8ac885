"""A robot that watches a person in the living room and names the gestures (paper II-A, Fig. 1 to 4)."""

from collections.abc import Mapping
from dataclasses import dataclass

from pydrake.systems.framework import Diagram, DiagramBuilder

from vipr.diagrams import seeing_people
from vipr.diagrams.living_room import LivingRoom
from vipr.diagrams.seeing_people import SeeingPeople
from vipr.diagrams.stages import Maker, Stages, connect
from vipr.systems.gestures.announcer import GestureAnnouncer
from vipr.systems.gestures.classifier import GestureClassifier
from vipr.systems.gestures.recogniser import GestureRecogniser
from vipr.systems.hands.track_points import TrackPoints

STAGES: Mapping[str, Maker] = {**seeing_people.STAGES, "gestures": GestureRecogniser}


@dataclass(frozen=True)
class Schedule:
    """Periods and offsets [s]; one camera tick every 40 ms."""

    camera: float = 0.04
    gestures_offset: float = 0.020

    def rows(self) -> dict[str, tuple[float, float]]:
        """(period, offset) [s] of each stage that is no diagram with a schedule of its own."""
        return {"living_room": (self.camera, 0.0), "gestures": (self.camera, self.gestures_offset)}


class GestureRobot(Diagram):
    """The living room with its gesture camera, and the stages that see a person in it.

    .. pydrake_system::

        name: GestureRobot
        input_ports:
        - person_positions
        - light
        output_ports:
        - picture
        - understood
        - answer
        - hand_points
        - hand_points_true

    ::

        person ──▶ ┌─────────────┐ frame ┌───────────────┐ hand_tracks ┌──────────┐ gesture
        light  ──▶ │ living_room │──────▶│ seeing_people │────────────▶│ gestures │────────▶ announcer
                   └─────────────┘       └───────────────┘             └──────────┘
                          │
                          └─ hand_tracks_true ─▶ points_true          (beside it: hand_tracks ─▶ points)

    Schedule (ms; the camera's period is 40):

        living_room |0   exposure, and the truth of it
        skin        |10  of seeing_people: regions of the frame of 0
        hands       |15  of seeing_people: tracks
        gestures    |20  a movement that ends with this frame is named

    Pixels of the frame. ``hand_points_true`` is what ``hand_points`` is compared with; no stage sees it. ``stages`` puts others in the
    place of some of ``STAGES``: makers called with the same arguments, whose systems have the same ports.
    """

    def __init__(
        self,
        room: LivingRoom,
        classifier: GestureClassifier,
        names: tuple[str, ...],
        *,
        schedule: Schedule = Schedule(),
        stages: Mapping[str, Maker] | None = None,
    ):
        super().__init__()
        self.schedule = schedule.rows()
        builder, made = DiagramBuilder(), Stages(STAGES, stages)
        room = builder.AddNamedSystem("living_room", room)
        seen = {name: make for name, make in (stages or {}).items() if name in seeing_people.STAGES}
        seeing = builder.AddNamedSystem(
            "seeing_people",
            SeeingPeople(schedule=seeing_people.Schedule(period=schedule.camera), stages=seen),
        )
        gestures = made.add(builder, "gestures", classifier, period=schedule.camera, offset=schedule.gestures_offset)
        announcer = builder.AddNamedSystem("announcer", GestureAnnouncer(names))
        points = builder.AddNamedSystem("points", TrackPoints())
        points_true = builder.AddNamedSystem("points_true", TrackPoints())
        connect(
            builder,
            [
                (room, "frame", seeing, "frame"),
                (seeing, "hand_tracks", gestures, "hand_tracks"),
                (room, "frame", announcer, "frame"),
                (seeing, "regions", announcer, "regions"),
                (seeing, "hand_tracks", announcer, "hand_tracks"),
                (gestures, "gesture", announcer, "gesture"),
                (seeing, "hand_tracks", points, "hand_tracks"),
                (room, "hand_tracks_true", points_true, "hand_tracks"),
            ],
        )
        for name in ("person_positions", "light"):
            builder.ExportInput(room.GetInputPort(name), name)
        for name in ("picture", "understood", "answer"):
            builder.ExportOutput(announcer.GetOutputPort(name), name)
        builder.ExportOutput(points.GetOutputPort("points"), "hand_points")
        builder.ExportOutput(points_true.GetOutputPort("points"), "hand_points_true")
        builder.BuildInto(self)
        self.set_name("gesture_robot")
