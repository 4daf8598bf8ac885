"""The light of a picture that nothing is known about."""

import numpy as np

from vipr.systems.camera.illumination import illuminate, light_gains
from vipr.systems.hands.ahead_of_time import picture
from vipr.systems.skin import scene
from vipr.systems.skin.chromaticity import chromaticity
from vipr.systems.skin.first_light import SURE_FACE, LightSearch, face_seen, first_light, light_again
from vipr.systems.skin.regions import Found


def colour_error(gains, kelvin=5000.0):
    """log B/R that is left of a light after the gains."""
    left = gains * light_gains(1.0, kelvin)
    return abs(np.log(left[0] / left[2]))


def guess_again(search, wrong):
    """The gains after ten guesses at a white picture with a face that began with the wrong ones, or None if they were left alone."""
    image, changed = picture(0, 1), None
    still = scene.new_scene(chromaticity(image, wrong))
    for k in range(10):
        correction, search = light_again(image, wrong, still, search, float(k))
        changed = changed if correction is None else wrong * correction
    return changed


def test_white_light_is_believed_to_be_white():
    assert np.allclose(first_light(picture(0, 1), 0.0)[0], 1.0)


def test_a_grey_room_tells_orange_light_where_no_face_shows():
    assert colour_error(first_light(illuminate(picture(14, 1), 0.9, 3000.0), 0.0)[0], 3000.0) < 0.3


def test_a_light_under_which_no_face_shows_is_given_up_for_one_under_which_a_face_does():
    wrong = light_gains(1.0, 3000.0)
    assert colour_error(wrong) > 0.9
    assert colour_error(guess_again(LightSearch(), wrong)) < 0.3


def test_a_light_under_which_a_face_shows_is_kept():
    assert guess_again(LightSearch(face=0.5), light_gains(1.0, 3000.0)) is None


def test_a_sure_face_is_not_forgotten_while_a_hand_covers_it():
    nothing = Found(np.zeros((0, 2)), *np.zeros((3, 0)), np.zeros((0, 3)), np.zeros(0))
    sure = LightSearch(face=0.4)
    assert face_seen(sure, nothing, 2.0).face < SURE_FACE
    assert face_seen(sure, nothing, 2.0, covered=True).face == 0.4
    assert face_seen(LightSearch(face=0.2), nothing, 2.0, covered=True).face < 0.1  # it was never sure
