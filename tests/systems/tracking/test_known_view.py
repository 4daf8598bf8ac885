"""A pose that is known in a picture comes back where the picture does, whatever is wrong with the model's edges."""

import numpy as np
import pytest

from vipr.systems import se3
from vipr.systems.errors import InputError
from vipr.systems.tracking.ahead_of_time import CORNERS, FACES, LENS, picture
from vipr.systems.tracking.belief import start
from vipr.systems.tracking.cad_model import Shape, build_model
from vipr.systems.tracking.known_view import KnownView, known_keyframe
from vipr.systems.tracking.model_tracking import step

TOO_LARGE = build_model(Shape("box", 1.004 * CORNERS, FACES))
X_SHOWN = se3.pose(se3.exp_so3(np.array([0.5, 0.6, 0.1])), np.array([0.0, 0.0, 0.5]))
PRINTS = np.random.default_rng(1).integers(40, 220, (6, 8, 8)).astype(np.uint8)
VIEW = KnownView(picture(X_SHOWN, PRINTS), X_SHOWN)
COUNT = 64


def on_the_way(share):
    """From 20 degrees and 10 mm aside (0) to the shown place (1)."""
    away = 1.0 - share
    return se3.pose(
        se3.exp_so3(np.array([0.5, 0.6 + 0.35 * away, 0.1])), X_SHOWN[:3, 3] + away * np.array([0.01, 0, 0])
    )


def brought_there(keyframes):
    """Belief at the shown place after the way there."""
    poses = [on_the_way(share) for share in (*np.linspace(0.0, 1.0, 12), *np.ones(8))]
    belief = start(poses[0], keyframes=keyframes)
    for k, X_CO in enumerate(poses):
        belief = step(belief, picture(X_CO, PRINTS), 0.04 * k, TOO_LARGE, LENS)
    assert belief.state == "tracking"
    return belief


def test_a_model_that_is_too_large_seems_farther_away_but_not_where_it_was_shown():
    view = known_keyframe(VIEW, TOO_LARGE, LENS, COUNT)
    with_view, without = brought_there((view,)), brought_there(())
    off = [np.linalg.norm(belief.X_CO[:3, 3] - X_SHOWN[:3, 3]) for belief in (with_view, without)]
    assert off[1] > 1e-3 and off[0] < 0.25 * off[1]
    assert with_view.keyframes[0] is view, "it is never forgotten"


def test_an_object_without_print_has_no_known_view():
    plain = KnownView(picture(X_SHOWN, np.full((6, 8, 8), 120, np.uint8)), X_SHOWN)
    assert known_keyframe(plain, TOO_LARGE, LENS, COUNT) is None


@pytest.mark.parametrize(
    ("view", "message"),
    [
        (KnownView(VIEW.image[:100], X_SHOWN), "known view: its picture is 320 x 100 px, its lens is for 320 x 240 px"),
        (KnownView(VIEW.image, 2 * np.eye(4)), "known view: X_CO must be a rigid 4x4 pose of the object before"),
        (KnownView(VIEW.image, se3.pose(np.eye(3), [0, 0, -1.0])), "known view: X_CO must be a rigid 4x4 pose"),
    ],
)
def test_a_view_that_cannot_be_is_refused(view, message):
    with pytest.raises(InputError, match=message):
        known_keyframe(view, TOO_LARGE, LENS, COUNT)
