"""What is understood is told in words, in numbers and in the picture."""

import numpy as np
import pytest

from vipr.systems.gestures.announcer import ANSWER, GestureAnnouncer

from examples import EXAMPLES


@pytest.fixture
def at():
    """The outputs at a time, by name."""
    system, fix = EXAMPLES[GestureAnnouncer]()
    context = system.CreateDefaultContext()

    def outputs(t):
        fix(context, t)
        return {name: system.GetOutputPort(name).Eval(context) for name in ("picture", "understood", "answer")}

    return outputs


def test_before_the_first_movement_nothing_is_said(at):
    told = at(0.04)
    assert told["understood"].text == ""
    assert told["answer"][0] == -1 and told["answer"][ANSWER.index("accepted")] == 0


def test_a_gesture_is_told_in_words_and_numbers(at):
    told = at(0.12)
    assert told["understood"].text == "out (90 %), from 0.02 to 0.06 s"
    assert dict(zip(ANSWER, told["answer"], strict=True)) == {
        "number": 3, "name": 1, "accepted": 1, "start": 0.02, "end": 0.06, "named": 0.1, "direction_x": -1, "direction_y": 0,
    }  # fmt: skip


def test_the_picture_is_enlarged_and_shows_the_name_for_a_moment(at):
    without, with_name, later = (at(t)["picture"].image[200:, :60] for t in (0.08, 0.12, 4.0))
    assert at(0.08)["picture"].image.shape == (240, 320, 3)
    assert (with_name == 255).all(axis=2).sum() > 20
    assert np.array_equal(without, later)
