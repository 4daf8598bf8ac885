"""The target filter against what it claims."""

import numpy as np
import pytest

from vipr.systems import se3
from vipr.systems.errors import InputError
from vipr.systems.servo.target_filter import TargetBelief, TargetMotion, predict_pose, update


def test_filter_finds_the_speed_of_a_moving_object_and_predicts_it():
    V = np.array([0, 0, 0.3, 0.05, -0.02, 0.0])
    rng = np.random.default_rng(2)
    belief, noise = TargetBelief(), np.repeat([2e-3, 5e-4], 3)
    for k in range(50):
        t = 0.04 * k
        X = se3.pose(se3.exp_so3(t * V[:3]), t * V[3:])
        n = rng.normal(0, noise)
        X = se3.pose(se3.exp_so3(n[:3]) @ X[:3, :3], X[:3, 3] + n[3:])
        belief = update(belief, X, np.diag(noise**2), t, TargetMotion())
    assert np.allclose(belief.V_WO, V, atol=0.03)
    ahead = predict_pose(belief, 2.0)
    assert np.allclose(ahead[:3, 3], 2.0 * V[3:], atol=2e-3)
    assert se3.angle_between(ahead, se3.exp(2.0 * np.array([*V[:3], 0, 0, 0]))) < 0.01


def test_filter_covariance_is_honest():
    """Normalised estimation error squared over many runs of the filter's own motion model is near its 12 degrees of freedom."""
    rng = np.random.default_rng(4)
    motion, noise, dt = TargetMotion(), np.repeat([2e-3, 5e-4], 3), 0.04
    accelerations = np.repeat([motion.angular_acceleration, motion.acceleration], 3)
    nees = []
    for _ in range(60):
        V, X, belief = np.zeros(6), np.eye(4), TargetBelief()
        for k in range(30):
            n = rng.normal(0, noise)
            seen = se3.pose(se3.exp_so3(n[:3]) @ X[:3, :3], X[:3, 3] + n[3:])
            belief = update(belief, seen, np.diag(noise**2), k * dt, motion)
            if k == 29:
                break
            a = rng.normal(0, accelerations)
            step = dt * V + 0.5 * dt**2 * a
            X = se3.pose(se3.exp_so3(step[:3]) @ X[:3, :3], X[:3, 3] + step[3:])
            V = V + dt * a
        e = np.concatenate(
            [se3.log_so3(X[:3, :3] @ belief.X_WO[:3, :3].T), X[:3, 3] - belief.X_WO[:3, 3], V - belief.V_WO]
        )
        nees.append(e @ np.linalg.solve(belief.P, e))
    assert 9.5 < np.mean(nees) < 15.0


@pytest.mark.parametrize("bad", [{"acceleration": 0}, {"least_position_noise": float("nan")}])
def test_impossible_motions_are_refused(bad):
    with pytest.raises(InputError, match="must be positive"):
        TargetMotion(**bad)
