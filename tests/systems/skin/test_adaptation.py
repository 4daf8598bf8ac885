"""What adapts: the colour model, the still scene, the light; and what must not."""

import cv2
import numpy as np
import pytest

from vipr.systems.signals import HandTracks
from vipr.systems.skin import scene
from vipr.systems.skin.chromaticity import chromaticity, histogram
from vipr.systems.skin.classifier import SkinOptions
from vipr.systems.skin.colour_model import REACH, adapt, initial_model, skin_table
from vipr.systems.skin.density import components, density
from vipr.systems.skin.face_marks import face_marks
from vipr.systems.skin.learning import learn, sleeping_head
from vipr.systems.skin.regions import Found


def bins(b, g, r, n=400):
    return histogram(chromaticity(np.full((1, n, 3), (b, g, r), np.uint8)).index)


def test_the_box_follows_the_detected_regions():
    model = initial_model()
    for _ in range(30):
        model = adapt(model, bins(105, 140, 205), bins(120, 120, 120), 0.1)
    r, g = 205 / 450, 140 / 450
    assert model.box.contains(r, g) and model.box.r_high - model.box.r_low < 0.06
    assert model.anchor is not None and abs(model.anchor[0] - r) < 0.01


def test_the_model_cannot_drift_onto_a_wall():
    model = adapt(initial_model(), bins(105, 140, 205), bins(120, 120, 120), 0.1)
    anchor = model.anchor
    for step in range(200):  # the regions slide to an orange wall, a little at a time
        s = step / 200
        model = adapt(model, bins(105 - 80 * s, 140 - 20 * s, 205 + 40 * s), bins(120, 120, 120), 0.1)
    assert model.anchor == anchor
    assert model.box.r_high < anchor[0] + REACH + 0.02
    assert model.box.r_low < anchor[0] + REACH


def test_colours_of_the_room_are_no_longer_skin():
    wall, skin = bins(95, 140, 190), bins(105, 130, 220)
    model = initial_model()
    before = skin_table(model)[wall > 0].max()
    for _ in range(30):
        model = adapt(model, skin, wall, 0.1)
    assert skin_table(model)[wall > 0].max() < 0.3 * before
    assert skin_table(model)[skin > 0].min() > 200


def textured(seed=0):
    return cv2.GaussianBlur(np.random.default_rng(seed).integers(40, 200, (120, 160, 3), dtype=np.uint8), (0, 0), 2.0)


def test_a_change_of_light_is_read_off_the_still_scene_even_behind_a_person():
    room = textured()
    still = scene.new_scene(chromaticity(room))
    lit = np.clip(np.rint(room * np.array([0.7, 0.9, 1.15])), 0, 255).astype(np.uint8)
    lit[20:80, 60:110] = (30, 60, 200)
    gains = scene.light_change(lit, still, np.ones(3))
    assert np.allclose(gains, 1 / np.array([0.7, 0.9, 1.15]), rtol=0.03)


def test_another_view_is_no_change_of_light():
    still = scene.new_scene(chromaticity(textured()))
    before = np.array([1.1, 1.0, 0.9])
    other = np.kron(np.random.default_rng(1).choice([12, 30, 80, 245], (12, 16)), np.ones((10, 10))).astype(np.uint8)
    other = np.repeat(other[:, :, None], 3, axis=2)
    assert (scene.light_change(other, still, before) == before).all()
    assert scene.is_cut(chromaticity(other), still)
    assert not scene.is_cut(chromaticity(textured()), still)


def test_what_stays_becomes_background_and_what_moves_does_not():
    room = textured()
    still = scene.new_scene(chromaticity(room))
    for k in range(40):
        now = room.copy()
        x = 20 + 2 * (k % 30)
        now[50:62, x : x + 12] = 250
        colours = chromaticity(now)
        still, stood = scene.watch(colours, still, 11, 0.04)
        still = scene.settle(still, colours, np.zeros(room.shape[:2], bool), 0.04)
    assert still.sure[10:30, 10:150].min() == 1.0 and stood[10:30, 10:150].min() == 1.0
    assert stood[52:60, x + 2 : x + 10].max() < 0.5
    assert still.motion[52:60, x + 4 : x + 12].max() > 0.5 and still.alive[55, 40] > 0.4


def test_density_and_components_keep_the_three_largest():
    skin = np.zeros((120, 160), np.uint8)
    for x, radius in ((30, 10), (80, 8), (120, 6), (150, 3)):
        cv2.circle(skin, (x, 60), radius, 255, -1)
    skin[5, 5] = 255
    labels, areas, boxes = components(density(skin, 3), 120, 8.0, 3)
    assert len(areas) == 3 and (np.diff(areas) < 0).all()
    assert labels[60, 30] == 1 and labels[60, 80] == 2 and labels[60, 120] == 3 and labels[60, 150] == 0
    assert abs(boxes[0][0] + boxes[0][2] / 2 - 30) < 1.5
    assert labels[5, 5] == 0


def test_a_face_has_the_marks_of_one_and_a_ball_has_not():
    luma = np.full((120, 160), 90.0, np.float32)
    for x in (50, 110):
        cv2.circle(luma, (x, 60), 16, 170.0, -1)
    for eye in (43, 57):
        cv2.ellipse(luma, (eye, 55), (4, 3), 0, 0, 360, 60.0, -1)
    cv2.ellipse(luma, (50, 70), (6, 2), 0, 0, 360, 90.0, -1)
    face, ball = face_marks(luma, np.array([[50, 60, 13.0], [110, 60, 13.0]]))
    assert face > 0.5 and ball < 0.25
    upside_down = face_marks(luma[::-1].copy(), np.array([[50, 59, 13.0]]))[0]
    assert upside_down < 0.6 * face


@pytest.mark.parametrize("moving", [0.0, 0.8])
def test_what_may_be_a_head_above_a_moving_hand_is_not_taken_for_the_room(moving):
    image, labels = np.full((120, 160, 3), 120, np.uint8), np.zeros((120, 160), np.uint8)
    cv2.ellipse(labels, (80, 30), (8, 10), 0, 0, 360, 1, -1)
    cv2.circle(labels, (110, 70), 5, 2, -1)
    image[labels > 0] = (40, 60, 90)
    skin, colours = np.where(labels > 0, 255, 0).astype(np.uint8), chromaticity(image)
    found = Found(
        centres=np.array([[80.0, 30.0], [110.0, 70.0]]), areas=np.array([250.0, 80.0]), person=np.array([0.4, 0.9]),
        faceness=np.array([0.15, 0.0]), cores=np.array([[80.0, 30.0, 8.0], [110.0, 70.0, 5.0]]), moving=np.array([0.0, moving]),
    )  # fmt: skip
    still, model = scene.new_scene(colours), initial_model()
    for _ in range(4):
        still, model = learn(model, colours, skin, skin, labels, found, still, HandTracks(), 1.0, 0.4, SkinOptions())
    assert (still.sure[30, 80] > 0.9) == (moving == 0.0)
    assert still.sure[100, 20] > 0.9


@pytest.mark.parametrize(("hand_y", "moving", "woken"), [(90, 0.8, True), (90, 0.0, False), (20, 0.8, False)])
def test_a_head_that_became_a_thing_of_the_room_is_woken_above_all_that_moves(hand_y, moving, woken):
    image = np.full((120, 160, 3), 100, np.uint8)
    cv2.ellipse(image, (80, 50), (10, 13), 0, 0, 360, (130, 160, 210), -1)
    for eye in (75, 85):
        cv2.ellipse(image, (eye, 47), (3, 2), 0, 0, 360, (60, 75, 100), -1)
    by_colour = np.zeros((120, 160), np.uint8)
    cv2.ellipse(by_colour, (80, 50), (10, 13), 0, 0, 360, 255, -1)
    hand = Found(
        centres=np.array([[130.0, hand_y]]), areas=np.array([80.0]), person=np.array([0.9]), faceness=np.array([0.0]),
        cores=np.array([[130.0, hand_y, 5.0]]), moving=np.array([moving]),
    )  # fmt: skip
    colours = chromaticity(image)
    head = sleeping_head(by_colour, colours, scene.new_scene(colours), hand)
    assert (head is not None and head[50, 80] == 1 and head[90, 130] == 0) == woken
