"""Skin from frame to frame on drawn pictures, and every kind of picture it may be given."""

from dataclasses import replace

import numpy as np
import pytest
from drawn_people import FACE, LEFT, RIGHT, SKIN, person, waving

from vipr.systems.errors import InputError
from vipr.systems.skin.chain import SkinBelief, see_skin
from vipr.systems.skin.chromaticity import chromaticity
from vipr.systems.skin.classifier import SkinOptions
from vipr.systems.skin.learning import stirring
from vipr.systems.skin.scene import new_scene
from vipr.systems.skin.working_image import as_bgr, reduce


def follow(frames, options=SkinOptions()):
    belief = SkinBelief()
    for k, image in enumerate(frames):
        belief = see_skin(image, k / 25.0, k, belief, options)
    return belief


def test_face_and_hands_are_the_regions_and_the_face_looks_like_one():
    regions = follow(waving(k) for k in range(12)).regions
    hands = [(LEFT[0], LEFT[1] + round(14 * np.sin(3.3))), (RIGHT[0], RIGHT[1] - round(14 * np.sin(3.3)))]
    for centre in (FACE, *hands):
        assert np.linalg.norm(regions.centres - centre, axis=1).min() < 2.0
    face = np.linalg.norm(regions.centres - FACE, axis=1).argmin()
    assert regions.faceness.argmax() == face and regions.faceness[face] > 0.4
    assert (regions.number, regions.size, regions.cut) == (11, (160, 120), False)


def test_the_first_frame_and_another_scene_are_cuts():
    belief = see_skin(person(), 0.0, 0, SkinBelief())
    assert belief.regions.cut
    assert not see_skin(person(), 0.04, 1, belief).regions.cut
    assert see_skin(person() // 4, 0.08, 2, belief, SkinOptions(follow_light=False)).regions.cut
    assert see_skin(np.zeros((60, 80, 3), np.uint8), 0.08, 2, belief).regions.cut


def test_a_larger_picture_is_reduced_and_reported_in_its_own_pixels():
    small, large = (follow([np.kron(person(seed=k), np.ones((n, n, 1), np.uint8)) for k in range(3)]) for n in (1, 4))
    assert large.regions.labels.size < 1.1 * 160 * 120 and large.regions.scale == pytest.approx(4.0, rel=0.02)
    for centre in small.regions.centres[:3]:
        assert np.linalg.norm(large.regions.centres - (4 * centre + 1.5), axis=1).min() < 4.0


def test_a_step_of_the_light_does_not_lose_the_person():
    def film():
        for k in range(30):
            light = (1.0, 1.0, 1.0) if k < 15 else (0.6, 0.8, 0.95)
            yield np.clip(waving(k) * np.array(light), 0, 255).astype(np.uint8)

    belief = follow(film())
    assert np.allclose(belief.gains, (1 / 0.6, 1 / 0.8, 1 / 0.95), rtol=0.05)
    assert np.linalg.norm(belief.regions.centres - FACE, axis=1).min() < 2.0


def test_grey_pictures_hold_no_skin():
    grey = np.repeat(person().mean(2, keepdims=True), 3, axis=2).astype(np.uint8)
    assert len(follow([grey] * 3).regions.areas) == 0


@pytest.mark.parametrize(
    "convert",
    [
        lambda p: np.dstack([p, np.full(p.shape[:2], 7, np.uint8)]),
        lambda p: p.astype(np.uint16) << 8,
        lambda p: p / 255.0,
    ],
)
def test_four_channels_sixteen_bits_and_floats_are_the_same_picture(convert):
    assert np.array_equal(as_bgr(convert(person())), person())


def test_what_is_no_picture_is_named():
    assert as_bgr(np.zeros((4, 5), np.uint8)).shape == (4, 5, 3)
    assert as_bgr(np.zeros((4, 5, 1), bool)).shape == (4, 5, 3)
    for wrong in (np.zeros((4, 5, 2), np.uint8), np.zeros((0, 5, 3), np.uint8), np.zeros(7, np.uint8)):
        with pytest.raises(InputError, match="got shape"):
            as_bgr(wrong)
    with pytest.raises(InputError, match="got int64"):
        as_bgr(np.zeros((4, 5, 3), np.int64))


def test_small_pictures_are_never_enlarged():
    image = np.zeros((30, 40, 3), np.uint8)
    assert reduce(image, 19200.0)[0] is image


def test_a_patch_of_which_much_moves_is_alive_as_a_whole_and_a_wall_behind_a_hand_is_not():
    image = np.full((120, 160, 3), (120, 112, 98), np.uint8)
    image[40:80, 20:50], image[20:100, 80:130] = SKIN, SKIN
    colours = chromaticity(image)
    alive = np.zeros((120, 160), np.float32)
    alive[40:60, 20:50] = alive[40:60, 80:110] = 1.0
    awake = stirring(colours, replace(new_scene(colours), alive=alive))
    assert awake[42:78, 22:48].all() and not awake[:, 70:].any()
