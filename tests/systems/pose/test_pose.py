"""POSIT, the refinements and the robust estimate against exact projections, published figures and OpenCV."""

from itertools import product

import cv2
import numpy as np
import pytest

from vipr.systems import se3
from vipr.systems.camera.lens import Lens
from vipr.systems.errors import InputError
from vipr.systems.pose import lowe, posit
from vipr.systems.pose.estimate import estimate_pose

XC77 = Lens(640, 480, 1948.05, 1923.08, 319.5, 239.5)
CUBE = (np.array(list(product([0.0, 1.0], repeat=3))) - 0.5) * 0.1
SQUARE = np.array([[-1, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0], [0.3, 0.2, 0.0]]) * 0.05


def random_rotation(rng):
    axis = rng.normal(size=3)
    return se3.exp_so3(axis / np.linalg.norm(axis) * rng.uniform(0, np.pi))


def see(points_O, X_CO, lens=XC77, noise=0.0, rng=None):
    pixels = lens.project(points_O @ X_CO[:3, :3].T + X_CO[:3, 3])
    return pixels + (noise * rng.normal(size=pixels.shape) if noise else 0.0)


def normalised(pixels, lens=XC77):
    return (pixels - (lens.cx, lens.cy)) / (lens.fx, lens.fy)


def degrees_between(X, Y):
    return np.degrees(se3.angle_between(X[:3, :3], Y[:3, :3]))


def test_posit_finds_a_cube_at_two_metres_in_a_few_iterations():
    rng = np.random.default_rng(0)
    for _ in range(10):
        X_CO = se3.pose(random_rotation(rng), np.array([0.03, -0.02, 2.0]))
        (solution,) = posit.posit(CUBE, normalised(see(CUBE, X_CO)))
        assert solution.iterations <= 9
        np.testing.assert_allclose(solution.X_CO, X_CO, atol=1e-8)


def test_coplanar_posit_gives_both_mirror_poses_and_one_is_the_truth():
    X_CO = se3.pose(se3.exp_so3(np.array([0.7, 0.4, -0.3])), np.array([0.05, 0.02, 1.5]))
    near, far = posit.posit(SQUARE, normalised(see(SQUARE, X_CO)), iterations=100)
    np.testing.assert_allclose(near.X_CO, X_CO, atol=1e-8)
    assert near.error < 1e-9 < 1e-5 < far.error
    # The other pose tilts the plane the other way about the line of sight: nearly a mirror image in depth.
    line_of_sight = X_CO[:3, 3] / np.linalg.norm(X_CO[:3, 3])
    tilt = [s.X_CO[:3, 2] @ line_of_sight for s in (near, far)]
    assert abs(abs(tilt[0]) - abs(tilt[1])) < 0.05 and degrees_between(near.X_CO, far.X_CO) > 30


@pytest.mark.parametrize("method", ["projective", "lowe"])
def test_jacobian_equals_finite_differences(method):
    rng = np.random.default_rng(3)
    R, D = random_rotation(rng), np.array([0.1, -0.05, 1.7])
    if method == "lowe":
        D = lowe.to_lowe(D, XC77)
    J = lowe.jacobian(CUBE, R, D, XC77, method)
    for k in range(6):
        d = np.zeros(6)
        d[k] = 1e-6
        plus, _ = lowe.project(CUBE, se3.exp_so3(d[:3]) @ R, D + d[3:], XC77, method)
        minus, _ = lowe.project(CUBE, se3.exp_so3(-d[:3]) @ R, D - d[3:], XC77, method)
        np.testing.assert_allclose(J[:, :, k], (plus - minus) / 2e-6, rtol=1e-6, atol=2e-5)


@pytest.mark.parametrize(("off_axis", "degrees"), [(0.05, 1.43), (0.1, 2.86), (0.2, 5.71)])
def test_lowe_turns_by_the_line_of_sight_and_the_projective_method_does_not(off_axis, degrees):
    X_CO = se3.pose(se3.exp_so3(np.array([0.3, 0.5, 0.2])), np.array([off_axis, 0.0, 2.0]))
    pixels = see(CUBE, X_CO)
    biased = estimate_pose(CUBE, pixels, XC77, method="lowe", robust=False)
    exact = estimate_pose(CUBE, pixels, XC77, method="projective", robust=False)
    assert degrees_between(biased.X_CO, X_CO) == pytest.approx(degrees, abs=0.05)
    assert biased.residual_px < 0.3
    np.testing.assert_allclose(exact.X_CO, X_CO, atol=1e-8)


def test_refined_pose_is_as_good_as_opencv_and_better_than_posit():
    rng = np.random.default_rng(4)
    rotation = {"posit": [], "projective": [], "opencv": []}
    depth = []
    for _ in range(120):
        X_CO = se3.pose(random_rotation(rng), np.array([0.0, 0.0, 2.0]))
        pixels = see(CUBE, X_CO, noise=0.5, rng=rng)
        for method in ("posit", "projective"):
            found = estimate_pose(CUBE, pixels, XC77, method=method, robust=False)
            assert found.valid
            rotation[method].append(degrees_between(found.X_CO, X_CO))
        depth.append(found.X_CO[2, 3] - 2.0)
        start = cv2.Rodrigues(X_CO[:3, :3])[0], X_CO[:3, 3:].copy()
        _, w, _ = cv2.solvePnP(CUBE, pixels, XC77.K, None, start[0], start[1], True)
        rotation["opencv"].append(degrees_between(cv2.Rodrigues(w)[0], X_CO))
        assert degrees_between(found.X_CO, cv2.Rodrigues(w)[0]) < 0.01
    median = {name: np.median(values) for name, values in rotation.items()}
    assert 0.2 < median["projective"] < median["posit"] < 0.45
    assert np.std(depth) < 1.15 * 5.1e-3  # Cramer-Rao: 5.1 mm


def test_covariance_tells_the_scatter_of_the_pose():
    rng = np.random.default_rng(5)
    X_CO = se3.pose(se3.exp_so3(np.array([0.5, 0.7, 0.1])), np.array([0.1, -0.05, 2.0]))
    points = (rng.random((40, 3)) - 0.5) * 0.1
    errors, predicted = [], []
    for _ in range(150):
        found = estimate_pose(points, see(points, X_CO, noise=0.5, rng=rng), XC77, X_CO_start=X_CO)
        w = se3.log_so3(found.X_CO[:3, :3] @ X_CO[:3, :3].T)
        errors.append(np.concatenate([w, found.X_CO[:3, 3] - X_CO[:3, 3]]))
        predicted.append(np.diag(found.covariance))
    np.testing.assert_allclose(np.std(errors, axis=0), np.sqrt(np.mean(predicted, axis=0)), rtol=0.25)
    assert found.sigma_px == pytest.approx(0.5, rel=0.25)


@pytest.mark.parametrize(
    "points", [CUBE, np.random.default_rng(9).uniform(-0.05, 0.05, (60, 3))], ids=["cube", "cloud"]
)
def test_four_wrong_matches_in_ten_do_not_spoil_the_pose(points):
    rng = np.random.default_rng(6)
    for _ in range(15):
        X_CO = se3.pose(random_rotation(rng), np.array([0.05, 0.03, 2.0]))
        pixels = see(points, X_CO, noise=0.5, rng=rng)
        wrong = rng.permutation(len(points))[: int(0.4 * len(points))]
        pixels[wrong] += rng.choice([-1, 1], (len(wrong), 2)) * rng.uniform(15, 80, (len(wrong), 2))
        found = estimate_pose(points, pixels, XC77)
        assert found.valid and degrees_between(found.X_CO, X_CO) < 2.5
        assert not found.inliers[wrong].any()


def test_plane_seen_from_afar_is_reported_ambiguous_and_from_near_it_is_not():
    rng = np.random.default_rng(7)
    R = se3.exp_so3(np.array([0.35, 0.2, 0.0]))
    far, near = se3.pose(R, np.array([0.0, 0.0, 5.0])), se3.pose(R, np.array([0.0, 0.0, 0.4]))
    doubts = 0
    for _ in range(20):
        seen = estimate_pose(SQUARE, see(SQUARE, far, noise=0.3, rng=rng), XC77, robust=False)
        doubts += seen.ambiguous
        assert min(degrees_between(X, far) for X in [seen.X_CO, *(X for X, _ in seen.alternatives)]) < 15
        seen = estimate_pose(SQUARE, see(SQUARE, near, noise=0.3, rng=rng), XC77, robust=False)
        assert seen.valid and not seen.ambiguous and degrees_between(seen.X_CO, near) < 2
    assert doubts >= 16


def test_object_nearly_as_deep_as_it_is_far_is_found():
    rng = np.random.default_rng(8)
    wide = Lens(640, 480, 400.0, 400.0, 319.5, 239.5)
    for _ in range(20):
        X_CO = se3.pose(random_rotation(rng), np.array([0.02, 0.0, 0.16]))
        found = estimate_pose(CUBE, see(CUBE, X_CO, wide), wide)
        assert found.valid and degrees_between(found.X_CO, X_CO) < 0.01


@pytest.mark.parametrize(
    ("points", "pixels", "message"),
    [
        (CUBE[:3], np.zeros((3, 2)), "at least 4 points, got 3"),
        (CUBE, np.zeros((7, 2)), r"got \(8, 3\) and \(7, 2\)"),
        (CUBE, np.full((8, 2), np.nan), "NaN"),
        (np.full((8, 3), np.inf), np.zeros((8, 2)), "infinity"),
        ([["a"]], [["b"]], "numbers"),
    ],
)
def test_bad_input_is_said_clearly(points, pixels, message):
    with pytest.raises(InputError, match=message):
        estimate_pose(points, pixels, XC77)


def test_unknown_method_names_the_allowed_ones():
    with pytest.raises(InputError, match="projective, lowe, posit"):
        estimate_pose(CUBE, np.zeros((8, 2)), XC77, method="magic")


@pytest.mark.parametrize("method", ["projective", "lowe", "posit"])
@pytest.mark.parametrize("robust", [True, False])
def test_degenerate_sets_are_flagged_invalid(method, robust):
    line = np.outer(np.arange(6.0), [0.01, 0.02, 0.0])
    for points, reason in ((np.zeros((6, 3)), "one place"), (line, "one line")):
        found = estimate_pose(
            points, np.random.default_rng(0).uniform(0, 400, (6, 2)), XC77, method=method, robust=robust
        )
        assert not found.valid and reason in found.reason
    found = estimate_pose(CUBE, np.full((8, 2), 100.0), XC77, method=method, robust=robust)
    assert not found.valid and "one place" in found.reason


def test_any_finite_input_gives_an_answer_and_no_numpy_error():
    rng = np.random.default_rng(10)
    for k in range(30):
        n = int(rng.integers(4, 9))
        points = rng.normal(size=(n, 3)) * 10.0 ** rng.uniform(-6, 3)
        if k % 3 == 0:
            points[:, 2] = 0.0
        if k % 5 == 0:
            points[1:] = points[:-1].copy()
        pixels = rng.normal(size=(n, 2)) * 10.0 ** rng.uniform(-3, 5)
        if k % 4 == 0:
            pixels[:, 1] = 3.0
        for method in ("projective", "lowe", "posit"):
            found = estimate_pose(points, pixels, XC77, method=method)
            assert found.valid == np.isfinite(found.covariance).all()
            assert not found.valid or se3.is_pose(found.X_CO)
    behind = se3.pose(np.eye(3), np.array([0.0, 0.0, -1.0]))
    assert not estimate_pose(CUBE, see(CUBE, se3.pose(np.eye(3), np.array([0, 0, 1.0]))), XC77, X_CO_start=behind).valid
