"""Epsilon of a wrench space, on grasps whose value is known."""

import numpy as np
import pytest

from vipr.systems.grasping.wrench import contact_wrenches, epsilon


def pushes(directions):
    points = -np.asarray(directions, float)
    return contact_wrenches(points, -points, np.full(len(points), 0.5), np.zeros(3), 1.0)


def test_two_points_without_torsion_do_not_close_the_grasp():
    assert epsilon(pushes([[1, 0, 0], [-1, 0, 0]])) == 0.0


def test_six_sides_of_a_cube_close_it_and_more_friction_helps():
    sides = np.vstack([np.eye(3), -np.eye(3)])
    weak, strong = (epsilon(contact_wrenches(sides, -sides, np.full(6, mu), np.zeros(3), 1.0)) for mu in (0.2, 0.8))
    assert 0 < weak < strong


def test_known_case_a_cross_polytope():
    assert epsilon(np.vstack([np.eye(6), -np.eye(6)])) == pytest.approx(1 / np.sqrt(6))


def test_pushes_from_one_side_close_nothing():
    assert epsilon(pushes([[1, 0.1, 0], [1, -0.1, 0], [1, 0, 0.1]])) == 0.0
