"""The filter against the matrices of eq. (3) to (9)."""

import numpy as np
import pytest

from vipr.systems.hands import kalman

DT, SIGMA_W, SIGMA_N = 0.04, 700.0, 0.8


def test_it_is_the_filter_of_the_matrices():
    A = np.kron([[1, DT], [0, 1]], np.eye(2))
    C = np.kron([[DT**2 / 2], [DT]], np.eye(2))
    H = np.kron([[1, 0]], np.eye(2))
    x = np.array([10.0, 20.0, 0.0, 0.0])
    P = np.diag([SIGMA_N**2] * 2 + [60.0**2] * 2)
    k = kalman.start(10.0, 20.0, SIGMA_N, 60.0)
    rng = np.random.default_rng(0)
    for step in range(30):
        z = np.array([10 + 3 * step, 20 - step]) + rng.normal(0, 1, 2)
        x, P = A @ x, A @ P @ A.T + C @ C.T * SIGMA_W**2
        k = kalman.predict(k, DT, SIGMA_W)
        S = H @ P @ H.T + np.eye(2) * SIGMA_N**2
        assert kalman.distance2(k, *z, SIGMA_N) == pytest.approx((z - H @ x) @ np.linalg.solve(S, z - H @ x))
        gain = P @ H.T @ np.linalg.inv(S)
        x, P = x + gain @ (z - H @ x), (np.eye(4) - gain @ H) @ P
        k = kalman.update(k, *z, SIGMA_N)
        assert np.allclose((k.x, k.y, k.vx, k.vy), x)
        assert np.allclose([k.pp, k.pv, k.vv], [P[0, 0], P[0, 2], P[2, 2]])


def test_a_damped_track_comes_to_rest():
    k = kalman.Kalman(0.0, 0.0, 100.0, 0.0, 1.0, 0.0, 100.0)
    for _ in range(50):
        k = kalman.predict(k, DT, 0.0, damping=25.0)
    assert abs(k.vx) < 1e-6 and 4.0 < k.x < 10.0
