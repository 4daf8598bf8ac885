"""Poses from displacements, gradients and texture; the filter between frames."""

import numpy as np
import pytest
from drawn_objects import LENS, box, picture, pose_at

from vipr.systems import se3
from vipr.systems.camera.lens import Lens
from vipr.systems.tracking.displacements import corner_shift, difference, move, normal_jacobian, point_jacobian
from vipr.systems.tracking.gradient_fit import fit_gradients, search_steps
from vipr.systems.tracking.keyframes import choose_keyframe
from vipr.systems.tracking.learning import learn_keyframe
from vipr.systems.tracking.looks import pyramid
from vipr.systems.tracking.motion_filter import at_rest, correct, predict, settle
from vipr.systems.tracking.normal_flow import Matches, cut_patch
from vipr.systems.tracking.pose_fit import Prior, fit_points, fit_pose
from vipr.systems.tracking.texture import align
from vipr.systems.tracking.visible_edges import visible_nodes

X = pose_at(0.0)
WIDE = Lens(320, 240, 400.0, 400.0, 159.5, 119.5)


def small(rng, angle=0.02, distance=0.002):
    return np.r_[rng.normal(size=3) * angle, rng.normal(size=3) * distance]


def test_move_and_difference_are_each_others_inverse():
    d = small(np.random.default_rng(0), 0.5, 0.1)
    assert np.allclose(difference(X, move(X, d)), d)


def test_the_jacobians_agree_with_finite_differences():
    nodes = visible_nodes(box(), X, LENS, 50)
    J = point_jacobian(nodes.p_O, X, LENS)
    for k in range(6):
        step = np.eye(6)[k] * 1e-6
        ends = [LENS.project(nodes.p_O @ Y[:3, :3].T + Y[:3, 3]) for Y in (move(X, step), move(X, -step))]
        assert np.allclose(J[:, :, k], (ends[0] - ends[1]) / 2e-6, rtol=1e-5, atol=1e-4)
    assert np.allclose(normal_jacobian(nodes, X, LENS), (nodes.normal[:, :, None] * J).sum(1))


def exact_matches(nodes, J, d, rng, wrong=0.0):
    offset = np.stack([J @ d, rng.uniform(-6, 6, len(nodes))], 1)
    away = rng.random(len(nodes)) < wrong
    offset[away, 0] = rng.uniform(-8, 8, away.sum())
    return Matches(offset, np.full(offset.shape, 50.0), 8.0, 2)


def test_a_displacement_is_recovered_among_false_edges():
    rng = np.random.default_rng(1)
    nodes = visible_nodes(box(), X, LENS, 150)
    J = normal_jacobian(nodes, X, LENS)
    d = small(rng, 0.02, 0.002)
    fit = fit_pose(
        J, exact_matches(nodes, J, d, rng, 0.3), np.tile([1.0, 0.5], (len(nodes), 1)), (4.0, 2.0), edge=nodes.edge
    )
    assert np.abs(J @ (fit.d - d)).max() < 0.3


def test_what_the_nodes_do_not_show_follows_the_prior():
    nodes = visible_nodes(box(), X, LENS, 150)
    nodes = nodes.take(np.abs(nodes.normal[:, 0]) > 0.95)  # vertical edges only
    J = normal_jacobian(nodes, X, LENS)
    matches = Matches(np.zeros((len(nodes), 1)), np.full((len(nodes), 1), 50.0), 5.0, 1)
    up = np.array([0, 0, 0, 0, 0.01, 0])
    fit = fit_pose(J, matches, np.ones((len(nodes), 1)), (1.0,), Prior(up, np.diag([1e6] * 3 + [1e8] * 3)))
    assert fit.d[4] == pytest.approx(0.01, rel=0.05)


def test_what_is_wrong_with_whole_edges_is_told_as_lasting_and_more_nodes_do_not_lessen_it():
    told = []
    for count in (80, 320):
        nodes = visible_nodes(box(), X, LENS, count, 0.5)
        J, rng, square = normal_jacobian(nodes, X, LENS), np.random.default_rng(3), 0.0
        for _ in range(60):
            offset = 0.05 * rng.normal(size=nodes.edge.max() + 1)[nodes.edge][:, None]
            matches = Matches(offset, np.full(offset.shape, 50.0), 5.0, 1)
            fit = fit_pose(
                J, matches, np.ones(offset.shape), (1.0,), edge=nodes.edge, noise=0.05, model_error=0.05, spread=0.0
            )
            square += fit.d[5] ** 2 / 60
        inverse = np.linalg.inv(fit.information)
        told.append(np.sqrt((inverse @ fit.shared @ inverse)[5, 5]))
        assert 0.6 < np.sqrt(square) / told[-1] < 1.4
    assert told[1] > 0.8 * told[0]


def test_without_nodes_nothing_moves():
    none = visible_nodes(box(), se3.pose(np.eye(3), np.array([9.0, 0, 1.0])), LENS)
    empty = Matches(np.zeros((0, 4)), np.zeros((0, 4)), 5.0, 4)
    assert not fit_pose(normal_jacobian(none, X, LENS), empty, np.zeros((0, 4)), (2.0,)).d.any()


def test_moved_points_give_the_pose_that_moved_them():
    nodes = visible_nodes(box(), X, LENS, 60)
    Y = move(X, small(np.random.default_rng(2), 0.1, 0.01))
    found = fit_points(nodes.p_O, LENS.project(nodes.p_O @ Y[:3, :3].T + Y[:3, 3]), np.ones(len(nodes)), X, LENS, 8)
    assert corner_shift(box(), LENS, found, Y) < 0.05


def test_the_gradient_search_finds_the_drawn_edges():
    image = picture(box(), X, WIDE)
    patch = cut_patch(image, np.zeros(2), np.array([400.0, 400.0]))
    start = move(X, np.array([0.03, -0.02, 0.01, 0.002, -0.001, 0.004]))
    nodes = visible_nodes(box(), start, WIDE, 120)
    fit = fit_gradients(patch, nodes, start, WIDE, search_steps(nodes, start, WIDE, None, 0.04))
    assert corner_shift(box(), WIDE, fit.X_CO, X) < 0.4 * corner_shift(box(), WIDE, start, X)
    assert fit.cost < -20 and fit.tried > 12


def test_the_first_steps_of_the_search_follow_the_velocity():
    nodes = visible_nodes(box(), X, LENS, 60)
    fixed = search_steps(nodes, X, LENS, None, 0.04)
    still = search_steps(nodes, X, LENS, np.zeros(6), 0.04)
    spinning = search_steps(nodes, X, LENS, np.array([0, 12.0, 0, 0, 0, 0]), 0.04)
    assert np.allclose(still, fixed / 2)
    assert spinning[1] > 2 * still[1] and np.allclose(np.delete(spinning, 1), np.delete(still, 1))


def textured(X_CO, seed=0):
    """The box with blotches painted on its face towards -z in the picture of a pinhole (a homography of a random texture)."""
    import cv2

    rng = np.random.default_rng(seed)
    blotches = cv2.GaussianBlur(rng.uniform(0, 255, (60, 80)).astype(np.float32), (0, 0), 1.5)
    blotches = cv2.normalize(blotches, None, 40, 220, cv2.NORM_MINMAX).astype(np.uint8)
    image = picture(box(), X_CO, WIDE)
    corners = np.array([[-0.05, -0.035, -0.025], [0.05, -0.035, -0.025], [0.05, 0.035, -0.025], [-0.05, 0.035, -0.025]])
    pixel = WIDE.project(corners @ X_CO[:3, :3].T + X_CO[:3, 3]).astype(np.float32)
    source = np.array([[0, 0], [79, 0], [79, 59], [0, 59]], np.float32)
    H = cv2.getPerspectiveTransform(source, pixel)
    painted = cv2.warpPerspective(blotches, H, (WIDE.width, WIDE.height), flags=cv2.INTER_AREA)
    inside = cv2.warpPerspective(np.full_like(blotches, 255), H, (WIDE.width, WIDE.height)) > 250
    return np.where(inside, painted, image)


def sight(image):
    return pyramid(cut_patch(image, np.zeros(2), np.array([400.0, 400.0])))


SEEN = se3.pose(se3.exp_so3(np.array([0.2, 0.3, 0.05])), np.array([0.0, 0.0, 0.3]))


def test_texture_learnt_at_one_pose_finds_another_ten_pixels_away():
    keyframe = learn_keyframe(sight(textured(SEEN)), box(), SEEN, np.eye(6) * 1e-8, WIDE)
    assert len(keyframe) > 20
    Y = move(SEEN, np.array([0.05, -0.04, 0.08, 0.004, -0.003, 0.006]))
    assert corner_shift(box(), WIDE, SEEN, Y) > 8
    for gain, offset in ((1.0, 0), (0.5, 20)):  # light may change
        image = (gain * textured(Y) + offset).astype(np.uint8)
        fit = align(keyframe, sight(image), box(), SEEN, WIDE, (3, 2, 1, 0))
        assert corner_shift(box(), WIDE, fit.X_CO, Y) < 0.5
        assert fit.significance > 10


def test_another_texture_is_not_recognised():
    keyframe = learn_keyframe(sight(textured(SEEN)), box(), SEEN, np.eye(6) * 1e-8, WIDE)
    own, *others = (align(keyframe, sight(textured(SEEN, seed=k)), box(), SEEN, WIDE).significance for k in range(7))
    assert own > 10 and max(others) < own / 3


def test_a_bare_object_gives_no_keyframe_and_a_far_view_chooses_none():
    bare = sight(np.full((240, 320), 90, np.uint8))
    assert learn_keyframe(bare, box(), SEEN, np.eye(6), WIDE) is None
    keyframe = learn_keyframe(sight(textured(SEEN)), box(), SEEN, np.eye(6) * 1e-8, WIDE)
    assert choose_keyframe((keyframe,), move(SEEN, np.array([0, 0.1, 0, 0, 0, 0]))) is keyframe
    assert choose_keyframe((keyframe,), move(SEEN, np.array([0, 1.2, 0, 0, 0, 0]))) is None


@pytest.mark.parametrize("update", [correct, settle])
def test_the_filter_learns_a_constant_velocity(update):
    V = np.array([0.5, -0.3, 0.2, 0.1, 0.05, -0.02])
    motion, truth = at_rest(X), X
    for _ in range(20):
        truth = move(truth, V * 0.04)
        motion = update(predict(motion, 0.04, 1.0, 0.2), truth, np.diag([1e-6] * 3 + [1e-8] * 3))
    assert np.allclose(motion.V_CO, V, atol=0.02)
    assert np.allclose(difference(predict(motion, 0.04, 1.0, 0.2).X_CO, move(truth, V * 0.04)), 0, atol=1e-3)
    assert np.linalg.eigvalsh(motion.covariance).min() > 0


def test_uncertainty_grows_while_nothing_is_seen():
    motion = at_rest(X)
    later = predict(predict(motion, 0.04, 10.0, 1.0), 0.04, 10.0, 1.0)
    assert (later.covariance.diagonal() > motion.covariance.diagonal()).all()
