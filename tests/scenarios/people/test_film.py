"""Films of hand paths: hands go from one to the next and are followed all the way."""

import numpy as np
import pytest

from vipr.models.person.generate import BODIES
from vipr.scenarios.people.film import film_gestures
from vipr.scenarios.people.motion import SIDES, STRIDE, HandPaths, greeting, led_in, rest

BODY = BODIES["medium"]
HIGH = np.tile([0.36, -0.3, 0.1], (5, 1))


def test_a_hand_walks_to_where_its_path_begins_and_pauses_there():
    hanging = {s: rest(BODY, s) for s in SIDES}
    whole = led_in(HandPaths(right=HIGH), hanging, BODY, pause=6)
    assert whole.left is None  # goes on hanging
    np.testing.assert_allclose(whole.right[0], hanging["right"])
    np.testing.assert_allclose(whole.right[-11:], np.tile(HIGH[0], (11, 1)))
    steps = np.linalg.norm(np.diff(whole.right, axis=0), axis=1)
    assert 0.5 * STRIDE < steps.max() < 2.0 * STRIDE


def test_a_hand_that_is_no_longer_needed_goes_down():
    before = {"right": HIGH[0], "left": rest(BODY, "left")}
    whole = led_in(HandPaths(left=HIGH * (1, -1, 1)), before, BODY, pause=6)
    np.testing.assert_allclose(whole.right[0], HIGH[0])
    np.testing.assert_allclose(whole.right[-5:], np.tile(rest(BODY, "right"), (5, 1)))
    assert len(whole.left) == len(whole.right)


@pytest.fixture(scope="module")
def filmed():
    paths = [greeting(), HandPaths(right=HIGH), HandPaths(right=HIGH + (0.0, 0.2, -0.2))]
    return list(film_gestures(paths, seed=3))


def test_hands_are_known_from_the_first_frame_that_is_returned(filmed):
    for film in filmed[1:]:
        assert len(film.tracks.time) == len(film.truth.time) == 5
        assert film.tracks.seen[:, [0, 2]].all()
        assert np.abs(film.tracks.positions[:, 2] - film.truth.positions[:, 2]).max() < 4.0


def test_time_goes_on_from_film_to_film(filmed):
    times = np.concatenate([film.tracks.time for film in filmed])
    assert (np.diff(times) > 0.03).all()
