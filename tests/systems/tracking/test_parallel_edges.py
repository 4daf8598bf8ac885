"""Edges of the model side by side: which edges of the image are whose."""

import numpy as np

from vipr.systems.tracking.normal_flow import Matches
from vipr.systems.tracking.parallel_edges import UNSURE, told_apart
from vipr.systems.tracking.visible_edges import Nodes


def two_edges(apart: float, seen: tuple) -> tuple[Matches, Nodes]:
    """Five nodes on each of two upright edges so far apart [px], which see edges of the image at these places [px] from the first one."""
    y = 3.0 * np.arange(5)
    pixel = np.concatenate([np.column_stack([np.full(5, x), y]) for x in (100.0, 100.0 + apart)])
    normal = np.tile([1.0, 0.0], (10, 1))
    nodes = Nodes(np.zeros((10, 3)), pixel, normal, np.ones(10), np.ones((10, 2), bool), np.repeat([0, 1], 5), 3.0)
    offset = 100.0 + np.array(seen) - pixel[:, :1]
    return Matches(offset, np.full(offset.shape, 50.0), 5.0, 0), nodes


def test_of_two_edges_in_the_image_each_belongs_to_one_of_the_model():
    matches, weight = told_apart(*two_edges(3.0, (1.2, 4.2)), 2)  # both 1.2 px off
    assert (weight == 1.0).all()
    np.testing.assert_array_equal(matches.strength[:5] != 0, np.tile([True, False], (5, 1)))
    np.testing.assert_array_equal(matches.strength[5:] != 0, np.tile([False, True], (5, 1)))


def test_one_edge_in_the_image_of_two_says_little():
    matches, nodes = two_edges(3.0, (1.5,))
    assert (told_apart(matches, nodes, 2)[1] == UNSURE).all()


def test_edges_far_apart_and_edges_that_coincide_are_left_alone():
    for apart in (8.0, 0.3):
        matches, nodes = two_edges(apart, (0.1,))
        kept, weight = told_apart(matches, nodes, 2)
        assert (weight == 1.0).all()
        np.testing.assert_array_equal(kept.strength, matches.strength)
