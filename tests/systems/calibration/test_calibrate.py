"""Calibration on corners made from a known camera: exact without noise, honest about its errors with noise, plain about bad views."""

from dataclasses import replace

import numpy as np
import pytest

from vipr.diagrams.workcell_layout import fixed_camera
from vipr.systems import se3
from vipr.systems.calibration.board import Board, BoardView
from vipr.systems.calibration.bundle import ArmAccuracy, Model, Observations, _linearise, _moved
from vipr.systems.calibration.calibrate import calibrate
from vipr.systems.calibration.closed_form import camera_and_board, focal_lengths, homography, plane_pose
from vipr.systems.camera.lens import Lens
from vipr.systems.errors import InputError

BOARD = Board(7, 5, 34.0, marker_mm=25.0)
SIZE = (640, 480)
ARM = ArmAccuracy()
X_EB = se3.pose(se3.exp_so3(np.array([3.1, 0.05, -0.1])), [-0.12, 0.08, 0.05])


def cell(seed, count=20, noise=0.1, arm=ARM, radial=(0.0, 0.0), tilt=0.5):
    """(views, X_WE as the arm tells them, lens, X_WC): a camera somewhere near the workcell's, boards all over the image."""
    rng = np.random.default_rng(seed)
    lens = Lens(*SIZE, *(1930 * (1 + 0.03 * rng.normal(size=2))), *([320, 240] + 5 * rng.normal(size=2)))
    X_WC = fixed_camera() @ se3.exp(0.02 * rng.normal(size=6))
    views, poses = [], []
    while len(views) < count:
        R = se3.exp_so3(np.array([*(tilt * rng.normal(size=2)), rng.uniform(-1, 1)]))
        p = np.array([*rng.uniform([-0.12, -0.09], [0.12, 0.09]), 1.0]) * rng.uniform(1.7, 2.3)
        X_CB = se3.pose(R, p - R @ BOARD.middle_B)
        p_C = BOARD.corners_B @ R.T + X_CB[:3, 3]
        xy = p_C[:, :2] / p_C[:, 2:]
        r2 = (xy**2).sum(axis=1, keepdims=True)
        pixels = xy * (1 + radial[0] * r2 + radial[1] * r2**2) * [lens.fx, lens.fy] + [lens.cx, lens.cy]
        if (pixels < 5).any() or (pixels > np.array(SIZE) - 5).any():
            continue
        X_WE = X_WC @ X_CB @ se3.inverse(X_EB) @ se3.exp(arm.sigma * rng.normal(size=6))
        views.append(BoardView(f"{len(views)}.png", np.arange(24), pixels + noise * rng.normal(size=pixels.shape)))
        poses.append(X_WE)
    return views, poses, lens, X_WC


PERFECT = ArmAccuracy(1e-6, 1e-6)


def test_without_noise_everything_is_found_exactly():
    views, poses, lens, X_WC = cell(1, noise=0.0, arm=PERFECT)
    found = calibrate(BOARD, views, poses, SIZE)
    for name in ("fx", "fy", "cx", "cy"):
        assert getattr(found.lens, name) == pytest.approx(getattr(lens, name), abs=1e-4)
    assert np.allclose(found.X_WC, X_WC, atol=1e-6) and np.allclose(found.X_EB, X_EB, atol=1e-6)
    assert found.rms_px < 1e-4


def test_the_standard_errors_told_are_those_that_occur():
    ratios = []
    for seed in range(12):
        views, poses, lens, X_WC = cell(seed)
        found = calibrate(BOARD, views, poses, SIZE)
        wrong = [getattr(found.lens, name) - getattr(lens, name) for name in ("fx", "fy", "cx", "cy")]
        ratios.append(np.array(wrong) / list(found.intrinsics_error.values()))
        difference = se3.difference(X_WC, found.X_WC) / np.sqrt(np.diag(found.X_WC_covariance))
        ratios.append(difference)
        assert found.noise_px == pytest.approx(0.1, rel=0.15)
    assert 0.75 < np.sqrt(np.mean(np.concatenate(ratios) ** 2)) < 1.3


def test_an_arm_that_is_less_exact_makes_the_errors_told_larger():
    loose = ArmAccuracy(1.0, 0.1)
    views, poses, lens, _ = cell(3, arm=loose)
    found = calibrate(BOARD, views, poses, SIZE, arm=loose)
    exact = calibrate(BOARD, *cell(3)[:2], SIZE)
    assert found.intrinsics_error["fx"] > 2 * exact.intrinsics_error["fx"]
    assert abs(found.lens.fx - lens.fx) < 3 * found.intrinsics_error["fx"]


def test_radial_distortion_is_found_when_asked_for():
    views, poses, lens, _ = cell(4, count=30, noise=0.05, radial=(-0.8, 0.0))
    found = calibrate(BOARD, views, poses, SIZE, radial=1)
    assert found.lens.distortion[0] == pytest.approx(-0.8, abs=4 * found.intrinsics_error["k1"])
    assert found.intrinsics_error["k1"] < 0.1 and found.lens.distortion[1:] == (0.0,) * 4
    assert found.lens.fx == pytest.approx(lens.fx, abs=4 * found.intrinsics_error["fx"])


def test_wrong_corners_are_left_out():
    views, poses, lens, _ = cell(5)
    pixels = np.array(views[2].pixels)
    pixels[4:8] += [15.0, -9.0]
    views[2] = replace(views[2], pixels=pixels)
    found = calibrate(BOARD, views, poses, SIZE)
    assert 4 <= found.left_out <= 8
    assert found.lens.fx == pytest.approx(lens.fx, abs=4 * found.intrinsics_error["fx"])


def test_a_view_with_a_wrong_pose_is_left_out():
    views, poses, lens, _ = cell(5)
    poses[7] = poses[7] @ se3.exp(np.array([0, 0, 0, 0.02, -0.01, 0.015]))
    found = calibrate(BOARD, views, poses, SIZE)
    assert 15 <= found.left_out <= 26
    assert found.lens.fx == pytest.approx(lens.fx, abs=4 * found.intrinsics_error["fx"])


@pytest.mark.parametrize("spoil", ["millimetres", "order", "inverse"])
def test_poses_that_do_not_belong_to_the_images_are_refused(spoil):
    views, poses, *_ = cell(11)
    spoilt = {
        "millimetres": [se3.pose(X[:3, :3], 1e3 * X[:3, 3]) for X in poses],
        "order": poses[::-1],
        "inverse": [se3.inverse(X) for X in poses],
    }[spoil]
    with pytest.raises(InputError, match="the images and the poses of the hand do not agree"):
        calibrate(BOARD, views, spoilt, SIZE)


def test_derivatives_are_those_of_the_projection():
    _, poses, _, X_WC = cell(6, count=5)
    observations = Observations(
        np.repeat(np.arange(5), 24), np.concatenate([BOARD.corners_B] * 5), np.zeros((120, 2)), np.array(poses)
    )
    model = Model(np.array([1900, 1950, 320, 240, 0.3, -0.5]), se3.inverse(X_WC), X_EB, np.zeros((5, 6)))
    free = tuple(range(6))
    _, J = _linearise(observations, model, free)
    for k in range(J.shape[2]):
        step = np.zeros(J.shape[2])
        step[k] = 1e-6
        ahead, behind = (_linearise(observations, _moved(model, free, s), free)[0] for s in (step, -step))
        assert np.allclose((ahead - behind) / 2e-6, J[:, :, k], rtol=1e-4, atol=1e-3)


def test_the_closed_forms_are_exact():
    views, poses, lens, X_WC = cell(7, count=6, noise=0.0, arm=PERFECT)
    homographies = [homography(BOARD.corners_B[:, :2], view.pixels) for view in views]
    assert np.allclose(focal_lengths(homographies, (lens.cx, lens.cy)), (lens.fx, lens.fy), rtol=1e-6)
    X_CB = np.array([plane_pose(H, lens.K) for H in homographies])
    assert np.allclose(X_CB[0], se3.inverse(X_WC) @ poses[0] @ X_EB, atol=1e-6)
    X_CW, found = camera_and_board(X_CB, np.array(poses))
    assert np.allclose(X_CW, se3.inverse(X_WC), atol=1e-5) and np.allclose(found, X_EB, atol=1e-5)


def test_views_that_do_not_turn_are_refused():
    views, poses, *_ = cell(8)
    still = [se3.pose(poses[0][:3, :3], X[:3, 3]) for X in poses]
    with pytest.raises(InputError, match="the hand turns about two axes"):
        calibrate(BOARD, views, still, SIZE)


def test_parallel_boards_do_not_tell_the_focal_length():
    views, poses, *_ = cell(9, tilt=0.0, noise=0.0)
    with pytest.raises(InputError, match="turn"):
        calibrate(BOARD, views, poses, SIZE)


@pytest.mark.parametrize(
    "change, said",
    [
        (lambda v, p: (v[:3], p[:3]), "needs at least 4 views that show the board, got 3"),
        (lambda v, p: (v, p[:-1]), "20 views but 19 poses"),
        (lambda v, p: (v, [2.0 * p[0], *p[1:]]), "the pose of the hand for 0.png is not a rigid 4x4 pose"),
    ],
)
def test_bad_views_are_refused(change, said):
    views, poses, *_ = cell(10)
    with pytest.raises(InputError, match=said):
        calibrate(BOARD, *change(views, poses), SIZE)
