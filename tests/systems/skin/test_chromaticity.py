"""Chromaticity and what is built on it: tables, the box, the shell, hue."""

import numpy as np
import pytest

from vipr.systems.camera.illumination import light_gains
from vipr.systems.errors import InputError
from vipr.systems.skin.chromaticity import bin_centres, chromaticity, histogram, lookup, quiet
from vipr.systems.skin.classifier import SkinOptions, classify
from vipr.systems.skin.colour_model import initial_model
from vipr.systems.skin.locus import SkinBox, box_table, in_locus

RNG = np.random.default_rng(4)
IMAGE = RNG.integers(20, 250, (40, 50, 3), dtype=np.uint8)


def r_g(image):
    b, g, r = np.moveaxis(image.astype(float), 2, 0)
    return r / (b + g + r), g / (b + g + r)


def test_a_pixel_is_found_in_the_bin_nearest_to_its_r_and_g():
    r_bins, g_bins = bin_centres()
    index = chromaticity(IMAGE).index
    r, g = r_g(IMAGE)
    inside = (r > 0.17) & (r < 0.7) & (g > 0.12) & (g < 0.48)
    assert inside.sum() > 1000
    assert np.abs(r_bins[(index >> 8)[inside], 0] - r[inside]).max() < 0.51 / 160
    assert np.abs(g_bins[0, (index & 255)[inside]] - g[inside]).max() < 0.51 / 160


def test_gains_undo_the_light_they_belong_to():
    grey = np.full((4, 4, 3), 120, np.uint8)
    gains = light_gains(0.8, 3200.0)
    lit = np.clip(np.rint(grey * gains), 0, 255).astype(np.uint8)
    assert np.abs(chromaticity(lit, 1 / gains).pixels - 120).max() < 1.0
    assert (chromaticity(lit, 1 / gains).index == chromaticity(grey).index).all()
    assert (chromaticity(lit).index != chromaticity(grey).index).all()


def test_intensity_alone_does_not_change_the_index():
    coarse = (IMAGE // 4) * 2 + 40
    a, b = chromaticity(coarse).index, chromaticity(coarse * 1 // 1).index
    assert (a == b).all()
    doubled = np.minimum(coarse.astype(int) * 2, 510) // 2
    assert (chromaticity(doubled.astype(np.uint8)).index == a).all()


def test_black_is_nowhere_in_the_table():
    colours = chromaticity(np.zeros((2, 2, 3), np.uint8))
    assert lookup(np.ones((96, 64), np.uint8), colours.index).sum() == 0
    assert histogram(colours.index).sum() == 0


def test_a_histogram_counts_every_pixel_in_the_table_once_or_by_weight():
    index = chromaticity(IMAGE).index
    counted = lookup(np.ones((96, 64), np.uint8), index)
    assert histogram(index).sum() == counted.sum() > 1000
    weights = RNG.random(index.shape).astype(np.float32)
    assert histogram(index, weights).sum() == pytest.approx((weights * counted).sum(), rel=1e-4)


def test_the_box_and_the_shell_know_skin_under_several_lights():
    skin = np.array([120, 150, 200.0])
    r, g = r_g(skin[None, None])
    assert SkinBox().contains(r, g).all() and in_locus(r, g).all()
    for kelvin in (3500.0, 5000.0, 7000.0):
        r, g = r_g((skin * light_gains(1.0, kelvin))[None, None])
        assert in_locus(r, g).all()  # the box has to move with the light, the shell need not
    grey, green = r_g(np.full((1, 1, 3), 99.0)), r_g(np.array([[[60.0, 160.0, 80.0]]]))
    assert not in_locus(*grey).any() and not in_locus(*green).any()


def test_every_classifier_tells_skin_from_blue_and_sees_nothing_in_the_dark():
    image = np.zeros((10, 30, 3), np.uint8)
    image[:, :10], image[:, 10:20] = (105, 140, 205), (190, 110, 60)
    for name in ("ratio", "box", "locus", "hsi"):
        found = classify(image, chromaticity(image), initial_model(), SkinOptions(classifier=name)) > 100
        assert found[:, :10].all() and not found[:, 10:].any(), name


def test_impossible_boxes_and_options_are_named():
    with pytest.raises(InputError, match=r"r 0\.6 to 0\.4"):
        SkinBox(r_low=0.6, r_high=0.4)
    with pytest.raises(InputError, match="ratio, box, locus, hsi, got nose"):
        SkinOptions(classifier="nose")
    with pytest.raises(InputError, match="at least 400 px, got 10"):
        SkinOptions(working_area=10)
    assert box_table(SkinBox(), locus=False).sum() > box_table(SkinBox()).sum() * 0.99


def test_what_is_bright_enough_in_good_light_still_is_in_dim_light():
    lit = np.random.default_rng(0).normal((150.0, 160.0, 170.0), 1.5, (120, 160, 3))
    lit[40:60, 40:60] *= 0.3  # a dark hand
    for share in (1.0, 0.4, 0.2):
        image = np.rint(share * lit).astype(np.uint8)
        assert chromaticity(image).bright.all()
    image[50, 50] = 2
    assert not chromaticity(image).bright[50, 50]


def test_only_a_dim_picture_is_made_quiet():
    lit = np.random.default_rng(0).normal(150.0, 4.0, (120, 160, 3))
    image, dim = np.rint(lit).astype(np.uint8), np.rint(0.3 * lit + 0.7 * (lit - 150.0)).astype(np.uint8)
    assert quiet(image) is image
    assert np.std(quiet(dim)) < 0.5 * np.std(dim)
