"""Ways between gestures, made up from where a person's gestures begin and end."""

import numpy as np

from vipr.systems.gestures.trajectories import Trajectory
from vipr.systems.gestures.ways import LEAST_WAY, NOISE, PACE, RATE, ways


def gesture(start, end):
    """From start to end (x, y of two hands, faces) in a second."""
    share = np.linspace(0.0, 1.0, 26)[:, None]
    return Trajectory(np.array(start) + share * (np.array(end, float) - start), share[:, 0])


PEOPLE = np.array(["a", "a", "b", "b"])
GESTURES = [
    gesture((0, 0, 0, 0), (4, 0, 0, 0)),
    gesture((0, 3, 0, 0), (0, 6, 0, 0)),
    gesture((20, 0, 0, 0), (25, 0, 0, 0)),
    gesture((20, 4, 0, 0), (20, 9, 0, 0)),
]


def test_a_way_leads_from_the_end_of_a_gesture_to_the_beginning_of_one_of_the_same_person():
    found = ways(GESTURES, PEOPLE, 40, np.random.default_rng(1))
    assert len(found) == 40
    for way in found:
        near = [
            (p, q)
            for p, a in zip(PEOPLE, GESTURES, strict=True)
            for q, b in zip(PEOPLE, GESTURES, strict=True)
            if np.abs(way.points[0] - a.points[-1]).max() < 5 * NOISE
            and np.abs(way.points[-1] - b.points[0]).max() < 5 * NOISE
        ]
        assert near and all(p == q for p, q in near)


def test_hands_on_their_way_keep_the_pace_of_people():
    for way in ways(GESTURES, PEOPLE, 40, np.random.default_rng(2)):
        distance = np.linalg.norm((way.points[-1] - way.points[0]).reshape(-1, 2), axis=1).max()
        assert distance > LEAST_WAY - 10 * NOISE
        assert PACE[0] * 0.7 < distance / way.times[-1] < PACE[1] * 1.1
        np.testing.assert_allclose(np.diff(way.times), 1.0 / RATE)


def test_gestures_that_end_where_they_begin_leave_no_way_between_them():
    still = [gesture((0, 0, 0, 0), (0, 0, 0, 0))] * 3
    assert ways(still, np.zeros(3), 10, np.random.default_rng(3)) == []
    assert ways([], np.zeros(0), 10, np.random.default_rng(3)) == []
