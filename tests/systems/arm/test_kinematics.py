"""The Jacobian against finite differences of the forward kinematics, and twists (w, v) through rigid motions."""

import numpy as np
import pytest

from vipr.systems import se3
from vipr.systems.arm.kinematics import SerialArm

ARM = SerialArm(
    d=np.array([0.67, 0, 0.15, 0.43, 0, 0]),
    a=np.array([0, 0.43, 0.02, 0, 0, 0]),
    alpha=np.deg2rad([90, 0, -90, 90, -90, 0]),
    X_6E=se3.exp(np.array([0.1, 0.2, 0.3, 0.01, 0.02, 0.15])),
)


def test_jacobian_is_the_derivative_of_the_tool_pose():
    rng = np.random.default_rng(1)
    for q in rng.uniform(-2, 2, (5, 6)):
        X, J = ARM.tool_pose_and_jacobian(q)
        assert np.allclose(X, ARM.tool_pose(q))
        for j in range(6):
            step = np.zeros(6)
            step[j] = 1e-6
            plus, minus = ARM.tool_pose(q + step), ARM.tool_pose(q - step)
            w = se3.log_so3(plus[:3, :3] @ minus[:3, :3].T) / 2e-6
            v = (plus[:3, 3] - minus[:3, 3]) / 2e-6
            assert np.allclose(J[:, j], [*w, *v], atol=1e-8)


@pytest.mark.parametrize("angle", [0.0, 1e-9, 0.3, 3.0, np.pi - 1e-9, np.pi])
def test_log_inverts_exp_at_every_angle(angle):
    axis = np.array([2.0, -1.0, 0.5]) / np.linalg.norm([2.0, -1.0, 0.5])
    R = se3.exp_so3(angle * axis)
    assert np.allclose(se3.exp_so3(se3.log_so3(R)), R, atol=1e-7)
    assert np.linalg.norm(se3.log_so3(R)) == pytest.approx(angle, abs=1e-7)


def test_exp_and_log_of_motions_are_inverse():
    V = np.array([0.4, -0.2, 0.9, 1.0, 2.0, -3.0])
    assert np.allclose(se3.log(se3.exp(V)), V)
    assert np.allclose(se3.inverse(se3.exp(V)), se3.exp(-V))


def test_adjoint_moves_a_twist_to_another_frame():
    X_AB = se3.exp(np.array([0.4, -0.2, 0.9, 1.0, 2.0, -3.0]))
    V_B = np.array([0.1, 0.2, 0.3, 0.4, 0.5, 0.6])
    assert np.allclose(se3.exp(se3.adjoint(X_AB) @ V_B), X_AB @ se3.exp(V_B) @ se3.inverse(X_AB))
