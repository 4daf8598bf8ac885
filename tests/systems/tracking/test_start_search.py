"""From tens of pixels away the search finds the object, and nowhere to look is no error."""

import numpy as np
import pytest
from drawn_objects import LENS, box, picture, pose_at

from vipr.systems import se3
from vipr.systems.tracking.acquire import ELSEWHERE, elsewhere
from vipr.systems.tracking.displacements import corner_shift, move
from vipr.systems.tracking.start_search import field_around, pose_cost, search_start


@pytest.mark.parametrize("seed", range(4))
def test_the_object_is_among_the_places_found_and_has_the_lowest_cost(seed):
    model, X_CO = box(), pose_at(0.0)
    rng = np.random.default_rng(seed)
    turn, shift = (v / np.linalg.norm(v) for v in rng.normal(size=(2, 3)))
    across = 18.0 * X_CO[2, 3] / LENS.fx  # 18 px
    X_given = move(X_CO, np.concatenate([np.deg2rad(5.0) * turn, across * shift]))
    field = field_around(picture(model, X_CO), model, LENS, X_given)
    poses = search_start(field, model, LENS, X_given)
    best = min(poses, key=lambda X: pose_cost(field, model, LENS, X))
    assert corner_shift(model, LENS, best, X_CO) < 2.0
    assert pose_cost(field, model, LENS, best) < 0.5 * pose_cost(field, model, LENS, X_given)


def test_an_object_out_of_view_has_no_field():
    X_CO = pose_at(0.0).copy()
    X_CO[0, 3] += 100.0
    assert field_around(np.zeros((LENS.height, LENS.width), np.uint8), box(), LENS, X_CO) is None


def test_an_empty_image_gives_poses_without_proof():
    model, X_CO = box(), pose_at(0.0)
    field = field_around(np.full((LENS.height, LENS.width, 3), 90, np.uint8), model, LENS, X_CO)
    assert pose_cost(field, model, LENS, X_CO) == pytest.approx(4.0)


def test_what_was_not_found_where_it_was_said_to_be_is_sought_nearer_farther_and_tilted():
    X_CO = se3.pose(se3.exp_so3(np.array([1.2, -0.3, 0.4])), [0.05, -0.02, 2.0])
    np.testing.assert_array_equal(elsewhere(X_CO, 0), X_CO)
    tries = [elsewhere(X_CO, k) for k in range(len(ELSEWHERE))]
    assert all(se3.is_pose(X) for X in tries)
    depths = [X[2, 3] for X in tries]
    assert min(depths) < 1.97 and max(depths) > 2.03
    assert max(se3.angle_between(X, X_CO) for X in tries) > np.deg2rad(4)
    assert len({X.tobytes() for X in tries}) == len(tries)
    np.testing.assert_array_equal(elsewhere(X_CO, len(tries)), X_CO)
