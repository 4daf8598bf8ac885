"""Edges are found where they are, to a fraction of a pixel, in noise, colour and beside other edges."""

import numpy as np
import pytest

from vipr.systems.tracking.normal_flow import cut_patch, find_edges, noise_px, quantised
from vipr.systems.tracking.visible_edges import Nodes

ALL = np.zeros(2), np.array([200.0, 200.0])


def step_image(place, angle=0.0, low=60.0, high=180.0, noise=0.0, seed=0):
    """A straight edge whose distance from the middle of a 120 x 120 image is place [px], normal at angle [rad]."""
    y, x = np.mgrid[0:480, 0:480] / 4.0 + (0.125 - 0.5)
    side = (x - 60) * np.cos(angle) + (y - 60) * np.sin(angle) - place
    image = np.where(side > 0, high, low).reshape(120, 4, 120, 4).mean((1, 3))
    return image + np.random.default_rng(seed).normal(0.0, 1.0, image.shape) * noise


def grey(image):
    return np.clip(np.round(image), 0, 255).astype(np.uint8)


def nodes_on_line(angle, count=40):
    n = np.array([np.cos(angle), np.sin(angle)])
    pixel = 60 + np.linspace(-40, 40, count)[:, None] * np.array([-n[1], n[0]])
    zero = np.zeros(count, int)
    normal = np.tile(n, (count, 1))
    return Nodes(np.zeros((count, 3)), pixel, normal, np.ones(count), np.ones((count, 2), bool), zero, 2.0)


def strongest(matches):
    best = np.abs(matches.strength).argmax(1)
    return matches.offset[np.arange(len(best)), best]


@pytest.mark.parametrize("angle", [0.0, 0.3, 1.2, np.pi / 2, 2.5])
@pytest.mark.parametrize("sharp", [0.0, 3.0])
def test_an_edge_is_found_to_a_twentieth_of_a_pixel(angle, sharp):
    for place in (-2.25, 0.0, 1.75):
        matches = find_edges(
            cut_patch(grey(step_image(place, angle)), *ALL), nodes_on_line(angle), 6.0, sharp_reach=sharp
        )
        assert abs(np.median(strongest(matches)) - place) < 0.05


def test_the_sign_tells_on_which_side_it_is_brighter():
    patch = cut_patch(grey(step_image(0.0)), *ALL)
    matches = find_edges(patch, nodes_on_line(0.0), 5.0)
    assert np.allclose(matches.strength[np.abs(matches.strength) > 0], 120, atol=25)
    assert (find_edges(patch, nodes_on_line(np.pi), 5.0).strength <= 0).all()


def test_noise_spreads_the_place_and_does_not_shift_it():
    patch = cut_patch(grey(step_image(1.5, 0.2, noise=2.0)), *ALL)
    found = strongest(find_edges(patch, nodes_on_line(0.2), 5.0))
    assert abs(found.mean() - 1.5) < 0.05 and found.std() < 0.1
    assert 1.0 < patch.noise < 3.0


def test_a_line_beside_an_edge_hardly_moves_the_sharp_peak():
    image = step_image(0.0, high=100.0)
    image[:, 64:] = 220.0  # a much stronger edge 3.5 px away
    nodes = nodes_on_line(0.0)
    wide = find_edges(cut_patch(grey(image), *ALL), nodes, 5.0)
    both = find_edges(cut_patch(grey(image), *ALL), nodes, 5.0, sharp_reach=3.0)
    sharp = both.offset[:, wide.wide :][both.strength[:, wide.wide :] != 0]
    assert np.abs(np.median(sharp)) < 0.15
    assert wide.offset.shape[1] == wide.wide < both.offset.shape[1]


def test_an_edge_of_colour_alone_is_found():
    bgr = np.zeros((120, 120, 3), np.uint8)
    bgr[:, :60], bgr[:, 60:] = (40, 140, 60), (40, 100, 138)  # green and brown of the same grey
    nodes = nodes_on_line(0.0)
    assert strongest(find_edges(cut_patch(bgr, *ALL), nodes, 5.0)) == pytest.approx(-0.5, abs=0.05)
    assert not find_edges(cut_patch(bgr, *ALL, colour=False), nodes, 5.0).strength.any()


def test_nothing_is_found_without_contrast_outside_the_image_or_for_no_nodes():
    flat = np.full((120, 120), 90, np.uint8)
    assert not find_edges(cut_patch(flat, *ALL), nodes_on_line(0.0), 5.0).strength.any()
    away = cut_patch(flat, np.array([500.0, 500.0]), np.array([600.0, 600.0]))
    assert not find_edges(away, nodes_on_line(0.0), 5.0).strength.any()
    assert find_edges(away, nodes_on_line(0.0).take(slice(0, 0)), 5.0, sharp_reach=3.0).offset.shape[0] == 0


def test_quantised_normals_are_the_papers_four_directions():
    angles = np.radians([0, 20, 30, 50, 80, 130, 170, -100])
    steps = quantised(np.stack([np.cos(angles), np.sin(angles)], 1))
    assert np.array_equal(steps, [[1, 0], [1, 0], [1, 1], [1, 1], [0, 1], [-1, 1], [-1, 0], [0, -1]])
    patch = cut_patch(grey(step_image(2.0, 0.3)), *ALL)
    found = strongest(find_edges(patch, nodes_on_line(0.3), 6.0, quantise=True))
    assert abs(np.median(found) - 2.0) < 0.6


@pytest.mark.parametrize("angle", [0.0, 0.01, np.pi / 2, 0.4])
def test_a_sharp_edge_is_found_to_a_thirtieth_of_a_pixel_wherever_in_a_pixel_it_lies(angle):
    for place in (-0.5, -0.25, 0.0, 0.25):  # in quarters of a pixel, as the picture is drawn
        found = find_edges(cut_patch(grey(step_image(place, angle)), *ALL), nodes_on_line(angle), 4.0, sharp_reach=3.0)
        assert abs(np.median(found.offset[:, found.wide]) - place) < 0.033


@pytest.mark.parametrize("step", [12.0, 20.0, 40.0])
def test_the_noise_of_a_place_is_told_from_strength_and_pixel_noise(step):
    patch = cut_patch(grey(step_image(0.3, 0.35, 100.0, 100.0 + step, noise=1.5)), *ALL)
    matches = find_edges(patch, nodes_on_line(0.35, 26), 4.0, contrast=3.0, sharp_reach=3.0)
    near = np.abs(matches.offset[:, matches.wide] - 0.3) < 1.0
    told = noise_px(matches.strength, matches.wide, patch.noise)[near, matches.wide]
    off = matches.offset[near, matches.wide] - 0.3
    assert near.mean() > 0.8 and 0.5 < np.sqrt(np.mean((off / told) ** 2)) < 1.6
