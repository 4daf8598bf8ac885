"""Every interaction matrix against finite differences through the projection; columns in Drake's order (w, v)."""

import numpy as np
import pytest

from vipr.systems import se3
from vipr.systems.errors import InputError
from vipr.systems.servo.interaction import (
    line_interaction,
    log_depth_interaction,
    point_interaction,
    theta_u_interaction,
)

STEP = 1e-6
POINTS = np.array([[0.2, -0.1, 1.3], [-0.3, 0.25, 0.8], [0.0, 0.0, 2.0]])


def differences(feature, points=POINTS):
    """(m, 6) d feature / d V_C by central differences: the camera moves by exp(h V), the points stand still."""

    def seen(V):
        X_CC = se3.exp(V)
        return feature((points - X_CC[:3, 3]) @ X_CC[:3, :3])

    return np.column_stack([(seen(STEP * axis) - seen(-STEP * axis)) / (2 * STEP) for axis in np.eye(6)])


def test_points():
    L = point_interaction(POINTS[:, :2] / POINTS[:, 2:], POINTS[:, 2])
    assert np.allclose(L, differences(lambda p: (p[:, :2] / p[:, 2:]).ravel()), atol=1e-8)


def test_log_depth():
    p = POINTS[1]
    L = log_depth_interaction(p[:2] / p[2], p[2])
    assert np.allclose(L, differences(lambda q: np.log(q[1:2, 2]))[0], atol=1e-8)


@pytest.mark.parametrize("third", [[0.3, 0.2, 1.0], [-1.0, 0.4, 0.5]])
def test_lines_whatever_plane_through_them_is_given(third):
    def rho_theta(p):
        a, b, c = np.cross(p[0], p[1])
        return np.array([-c, np.arctan2(b, a) * np.hypot(a, b)]) / np.hypot(a, b)

    normal = np.cross(POINTS[1] - POINTS[0], third)
    L = line_interaction(*rho_theta(POINTS), np.append(normal, -normal @ POINTS[0]))
    assert np.allclose(L, differences(rho_theta), atol=1e-8)


@pytest.mark.parametrize("angle", [1e-6, 0.3, 2.0, 3.1])
def test_theta_u(angle):
    theta_u = angle * np.array([2.0, -1.0, 2.0]) / 3.0
    R_GC = se3.exp_so3(theta_u)
    L = theta_u_interaction(theta_u)
    turned = [
        (se3.log_so3(R_GC @ se3.exp_so3(STEP * w)) - se3.log_so3(R_GC @ se3.exp_so3(-STEP * w))) / (2 * STEP)
        for w in np.eye(3)
    ]
    assert np.allclose(L, np.column_stack([*turned, np.zeros((3, 3))]), atol=1e-6)


def test_twists_are_ordered_angular_first():
    along_z = point_interaction(np.array([0.1, 0.2]), 2.0) @ [0, 0, 0, 0, 0, 1.0]
    assert np.allclose(along_z, [0.05, 0.1]), "a camera that comes nearer sees a point move outwards"


@pytest.mark.parametrize("Z", [0.0, -1.0, float("nan")])
def test_depth_must_be_positive(Z):
    with pytest.raises(InputError, match=r"depths must be positive, got .* m at point 2 of 2"):
        point_interaction(np.zeros((2, 2)), [1.0, Z])


def test_plane_through_the_cameras_centre_is_refused():
    with pytest.raises(InputError, match="must not pass through the camera's centre"):
        line_interaction(0.1, 0.2, np.array([1.0, 0.0, 0.0, 0.0]))
