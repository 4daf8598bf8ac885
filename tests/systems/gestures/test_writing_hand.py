"""The hand that writes is found among the hands' tracks, whatever they are called."""

import numpy as np
import pytest

from vipr.systems.gestures.writing_hand import writing_hand

T = 60


@pytest.fixture
def hands():
    """(T, 2, 2) faces: one hand draws a loop, the other hangs and trembles."""
    rng, turn = np.random.default_rng(5), np.linspace(0.0, 2.0 * np.pi, T)
    draws = np.column_stack([np.cos(turn), np.sin(turn)]) * 1.5 + (-2.0, -2.0)
    hangs = np.tile([2.2, -5.0], (T, 1))
    return np.stack([draws, hangs], axis=1) + rng.normal(0.0, 0.05, (T, 2, 2))


def test_either_hand_may_write(hands):
    np.testing.assert_array_equal(writing_hand(hands), hands[:, 0])
    np.testing.assert_array_equal(writing_hand(hands[:, ::-1]), hands[:, 0])


def test_names_that_change_on_the_way_do_not_matter(hands):
    mistaken = hands.copy()
    for a, b in ((0, 9), (31, 46)):
        mistaken[a:b] = hands[a:b, ::-1]
    np.testing.assert_array_equal(writing_hand(mistaken), hands[:, 0])


def test_a_track_that_flickers_between_two_places_does_not_write(hands):
    flickers = hands.copy()
    flickers[:, 1] += np.where(np.arange(T) % 2, 0.35, -0.35)[:, None]
    np.testing.assert_array_equal(writing_hand(flickers), hands[:, 0])


def test_a_hand_that_was_lost_for_a_while_is_gone_on_with_where_it_is_found(hands):
    lost = hands.copy()
    lost[20:32, 0] = hands[20, 0]
    np.testing.assert_array_equal(writing_hand(lost), lost[:, 0])
    lost[:6] = np.nan
    np.testing.assert_array_equal(writing_hand(lost)[6:], lost[6:, 0])


def test_a_hand_that_is_taken_for_the_face_writes_all_the_same(hands):
    parts = np.concatenate([np.tile([[[0.0, 0.0]]], (T, 1, 1)), hands], axis=1)
    parts[:25, 0], parts[:25, 1] = hands[:25, 0], (0.0, 0.0)
    np.testing.assert_array_equal(writing_hand(parts), hands[:, 0])


@pytest.mark.parametrize("unseen", [slice(6, 6), slice(4, 8)])
def test_where_a_track_lay_before_it_jumped_onto_the_hand_is_not_writing(hands, unseen):
    jumps = hands.copy()
    jumps[:7, 0] = (3.0, 2.0)
    jumps[unseen, 0] = np.nan
    way = writing_hand(jumps)
    assert np.isnan(way[:7]).all()
    np.testing.assert_array_equal(way[8:], hands[8:, 0])


@pytest.mark.parametrize("frames", [0, 1, 2])
def test_short_tracks_are_returned_as_they_are(hands, frames):
    assert writing_hand(hands[:frames]).shape == (frames, 2)
    assert writing_hand(np.full((frames, 2, 2), np.nan)).shape == (frames, 2)
