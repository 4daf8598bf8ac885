"""Homographies of a plane: the true motion is among the readings, and impossible sets are refused."""

import numpy as np
import pytest

from vipr.systems import se3
from vipr.systems.errors import InputError
from vipr.systems.servo.homography import decompose, depth_ratio, homography

rng = np.random.default_rng(3)
PLANE = np.column_stack([rng.uniform(-0.1, 0.1, (6, 2)), np.zeros(6)])


def seen(X_CO):
    p = PLANE @ X_CO[:3, :3].T + X_CO[:3, 3]
    return p[:, :2] / p[:, 2:], p[:, 2]


@pytest.mark.parametrize("w", [[0.5, 0.2, 0.3], [0.0, 0.0, 3.0], [-0.6, 0.1, -1.2]])
def test_true_motion_is_one_of_at_most_two_readings(w):
    X_CO = se3.pose(se3.exp_so3(np.array(w)), [0.1, 0.05, 1.0])
    X_GO = se3.pose(se3.exp_so3(np.array([-0.2, 0.3, -0.1])), [-0.1, 0.05, 0.7])
    (x, Z), (x_goal, Z_goal) = seen(X_CO), seen(X_GO)
    readings = decompose(homography(x, x_goal), x)
    assert 1 <= len(readings) <= 2
    R = X_GO[:3, :3] @ X_CO[:3, :3].T
    best = min(readings, key=lambda reading: se3.angle_between(reading.R, R))
    assert se3.angle_between(best.R, R) < 1e-9
    ratios = [depth_ratio(best, a, b) for a, b in zip(x, x_goal, strict=True)]
    assert np.allclose(ratios, Z / Z_goal)
    assert abs(best.normal @ X_CO[:3, 2]) == pytest.approx(1.0)


def test_no_motion_reads_as_none():
    x, _ = seen(se3.pose(np.eye(3), [0.0, 0.0, 1.0]))
    (only,) = decompose(homography(x, x), x)
    assert np.allclose(only.R, np.eye(3)) and np.allclose(only.t_over_d, 0)


@pytest.mark.parametrize(
    ("x", "message"),
    [
        (np.zeros((3, 2)), "4 or more pairs"),
        (np.zeros((5, 2)), "all points are in one place"),
        (np.outer(np.arange(5.0), [1.0, 2.0]), "on a line"),
    ],
)
def test_points_that_determine_no_homography_are_refused(x, message):
    with pytest.raises(InputError, match=message):
        homography(x, x)
