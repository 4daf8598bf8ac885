"""The affine and quadratic motion from normal displacements."""

import numpy as np
import pytest

from vipr.systems.errors import InputError
from vipr.systems.tracking.affine import MotionModel, fit_affine, move_points


def box_nodes(n=200, centre=(320.0, 240.0), half=(60.0, 40.0)):
    """Points and normals on a rotated rectangle's outline and one inner edge."""
    rng = np.random.default_rng(0)
    side = np.arange(n) % 5
    t = rng.uniform(-1, 1, n)
    local = np.select(
        [(side == k)[:, None] for k in range(5)],
        [
            np.c_[t, -np.ones(n)],
            np.c_[t, np.ones(n)],
            np.c_[-np.ones(n), t],
            np.c_[np.ones(n), t],
            np.c_[t, 0.2 * np.ones(n)],
        ],
    ) * np.array(half)
    normal = np.where(((side == 2) | (side == 3))[:, None], [1.0, 0.0], [0.0, 1.0])
    a = 0.3
    R = np.array([[np.cos(a), -np.sin(a)], [np.sin(a), np.cos(a)]])
    return local @ R.T + centre, normal @ R.T


def affine(points, A, T):
    return points @ np.asarray(A).T + T


A_TRUE = np.array([[1.02, -0.05], [0.06, 0.97]])
T_TRUE = np.array([12.0, 2.0])


def test_exact_displacements_give_the_papers_theta():
    points, normals = box_nodes()
    d = np.sum(normals * (affine(points, A_TRUE, T_TRUE) - points), axis=1)
    motion = fit_affine(points, normals, d)
    assert motion.valid
    np.testing.assert_allclose(motion.Theta[:4], A_TRUE.ravel(), atol=2e-4)
    np.testing.assert_allclose(move_points(motion, points), affine(points, A_TRUE, T_TRUE), atol=0.02)
    # Equation 26 with the paper's Theta says the same as move_points.
    a1, a2, a3, a4, tx, ty = motion.Theta
    np.testing.assert_allclose(
        move_points(motion, points), points @ np.array([[a1, a2], [a3, a4]]).T + (tx, ty), atol=1e-9
    )


@pytest.mark.parametrize("estimator", ["tukey", "huber"])
def test_wrong_edges_do_not_pull_the_motion(estimator):
    rng = np.random.default_rng(1)
    points, normals = box_nodes()
    target = affine(points, A_TRUE, T_TRUE)
    d = np.sum(normals * (target - points), axis=1) + 0.2 * rng.normal(size=len(points))
    wrong = rng.permutation(len(points))[:60]
    d[wrong] = rng.uniform(-20, 20, 60)
    error = {
        e: np.sqrt(
            np.mean(np.sum((move_points(fit_affine(points, normals, d, estimator=e), points) - target) ** 2, axis=1))
        )
        for e in (estimator, "none")
    }
    assert error[estimator] < {"tukey": 0.15, "huber": 0.6}[estimator] and error["none"] > 2.0


def test_tukey_drops_wrong_edges_altogether():
    points, normals = box_nodes()
    d = np.sum(normals * (affine(points, A_TRUE, T_TRUE) - points), axis=1)
    d[:20] += 15.0
    motion = fit_affine(points, normals, d)
    assert (motion.weights[:20] == 0).all() and (motion.weights[20:] > 0.9).all()


def test_quadratic_model_follows_perspective_that_the_affine_one_misses():
    points, normals = box_nodes()
    x, y = ((points - (320, 240)) / 60).T
    target = points + np.c_[3 + x + 1.5 * x * x + 0.5 * x * y, -2 + y + 1.0 * x * y - 0.7 * y * y]
    d = np.sum(normals * (target - points), axis=1)
    quadratic = move_points(fit_affine(points, normals, d, model="quadratic", estimator="huber"), points)
    affine_only = move_points(fit_affine(points, normals, d), points)
    along = np.abs(np.sum(normals * (quadratic - target), axis=1))
    assert np.sqrt(np.mean(along**2)) < 0.05 < 0.3 < np.sqrt(np.mean(np.sum((affine_only - target) ** 2, axis=1)))


def test_what_the_edges_do_not_show_stays_still():
    points, _ = box_nodes(40)
    parallel = np.tile([0.0, 1.0], (40, 1))
    motion = fit_affine(points, parallel, np.full(40, 5.0))
    assert not motion.valid
    np.testing.assert_allclose(move_points(motion, points), points + np.array([0, 5.0]), atol=0.05)
    one = fit_affine(points[:1], parallel[:1], np.array([5.0]))
    assert not one.valid and np.abs(move_points(one, points[:1]) - points[:1] - (0, 5.0)).max() < 0.05


def test_nothing_seen_is_no_motion():
    points, normals = box_nodes(10)
    for found in (
        fit_affine(points, normals, np.full(10, np.nan)),
        fit_affine(points[:0], normals[:0], np.zeros(0)),
        MotionModel(),
    ):
        assert not found.valid
        np.testing.assert_array_equal(move_points(found, points), points)


def test_missing_displacements_are_left_out_and_keep_their_place():
    points, normals = box_nodes()
    d = np.sum(normals * (affine(points, A_TRUE, T_TRUE) - points), axis=1)
    d[::3] = np.nan
    motion = fit_affine(points, normals, d)
    assert (motion.weights[::3] == 0).all() and (motion.weights[1::3] > 0).all()
    np.testing.assert_allclose(move_points(motion, points), affine(points, A_TRUE, T_TRUE), atol=0.02)


def test_all_points_in_one_place_do_not_divide_by_zero():
    motion = fit_affine(np.full((20, 2), 7.0), np.tile([1.0, 0.0], (20, 1)), np.full(20, 3.0))
    assert not motion.valid and np.isfinite(motion.theta).all()
    np.testing.assert_allclose(move_points(motion, np.array([7.0, 7.0])), [10.0, 7.0], atol=0.05)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (dict(model="cubic"), "affine, quadratic"),
        (dict(estimator="mean"), "tukey, huber"),
        (dict(displacements=np.zeros(3)), "shapes|got"),
    ],
)
def test_wrong_use_is_said_clearly(arguments, message):
    points, normals = box_nodes(5)
    with pytest.raises(InputError, match=message):
        fit_affine(points, normals, **{"displacements": np.zeros(5), **arguments})
