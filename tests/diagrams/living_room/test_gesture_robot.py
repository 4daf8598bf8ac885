"""The map of the robot that watches a person."""

from vipr.diagrams.gesture_robot import GestureRobot

import laws
from examples import EXAMPLES

WIRES = [
    "gestures.gesture -> announcer.gesture",
    "living_room.frame -> announcer.frame",
    "living_room.frame -> seeing_people.frame",
    "living_room.hand_tracks_true -> points_true.hand_tracks",
    "seeing_people.hand_tracks -> announcer.hand_tracks",
    "seeing_people.hand_tracks -> gestures.hand_tracks",
    "seeing_people.hand_tracks -> points.hand_tracks",
    "seeing_people.regions -> announcer.regions",
]


def test_the_person_is_seen_by_these_wires_and_no_others():
    robot, _ = EXAMPLES[GestureRobot]()
    assert laws.wires(robot) == WIRES
    assert laws.wires(robot.GetSubsystemByName("seeing_people")) == [
        "hands.hand_tracks -> skin.hand_tracks",
        "skin.regions -> hands.regions",
    ]
