"""The compiled algebra against numpy's, and compilation itself."""

import numpy as np
import pytest

from vipr.systems.compiled import compiled
from vipr.systems.tracking.small_algebra import invert, kth_smallest, solve


def positive(seed, n=6):
    A = np.random.default_rng(seed).normal(size=(2 * n, n)) * np.logspace(-2, 3, n)
    return A.T @ A


@pytest.mark.parametrize("seed", range(3))
def test_solutions_and_inverses_are_those_of_numpy_though_units_differ_by_a_million(seed):
    H, g = positive(seed), np.arange(1.0, 7.0)
    assert solve(H, g) == pytest.approx(np.linalg.solve(H, g), rel=1e-9)
    assert invert(H) @ H == pytest.approx(np.eye(6), abs=1e-7)


def test_what_the_information_says_nothing_of_stays_zero():
    H, g = positive(0), np.ones(6)
    H[2] = H[:, 2] = 0.0
    rest = [0, 1, 3, 4, 5]
    x = solve(H, g)
    assert x[2] == 0.0
    assert x[rest] == pytest.approx(np.linalg.solve(H[np.ix_(rest, rest)], g[rest]), rel=1e-9)


@pytest.mark.parametrize("count", [1, 2, 7, 100])
def test_the_kth_smallest_is_that_of_a_sorted_copy_and_leaves_the_values_alone(count):
    values = np.random.default_rng(count).integers(0, 20, count).astype(float)
    before = values.copy()
    assert [kth_smallest(values, k) for k in range(count)] == sorted(before)
    assert (values == before).all()


def test_a_function_compiles_where_nothing_can_be_kept_and_divides_as_numpy_does():
    scope = {}
    exec("def ratio(a, b):\n    return a / b", scope)  # no file, so no place beside it
    assert compiled(scope["ratio"])(1.0, 0.0) == np.inf
