"""A lost object is found by what it looked like; patches that a hand covered are told from the object's own."""

from dataclasses import replace

import cv2
import numpy as np
import pytest

from vipr.systems import se3
from vipr.systems.camera.lens import Lens
from vipr.systems.tracking.belief import start
from vipr.systems.tracking.cad_model import Shape, build_model
from vipr.systems.tracking.covered import given_up, uncovered
from vipr.systems.tracking.displacements import corner_shift
from vipr.systems.tracking.learning import learn_keyframe
from vipr.systems.tracking.looks import pyramid
from vipr.systems.tracking.model_tracking import step
from vipr.systems.tracking.normal_flow import cut_patch
from vipr.systems.tracking.recall import recall
from vipr.systems.tracking.settings import TrackerSettings
from vipr.systems.tracking.sight import Sight

LENS = Lens(320, 240, 400.0, 400.0, 159.5, 119.5)
HALF, DEEP = 0.05, 0.02  # m
CORNERS = np.array([[x, y, z] for z in (0.0, DEEP) for x, y in ((-1, -1), (1, -1), (1, 1), (-1, 1))]) * (HALF, HALF, 1)
FACES = ((0, 3, 2, 1), (4, 5, 6, 7), (0, 1, 5, 4), (1, 2, 6, 5), (2, 3, 7, 6), (3, 0, 4, 7))
BOX = build_model(Shape("box", CORNERS, FACES))
X_CO = se3.pose(np.eye(3), np.array([-0.05, -0.02, 0.4]))  # its printed face, z = 0, looks at the camera
PRINT = cv2.GaussianBlur(np.random.default_rng(3).integers(0, 255, (200, 200)).astype(np.float32), (0, 0), 4.0)
PRINT = cv2.normalize(PRINT, None, 20, 235, cv2.NORM_MINMAX).astype(np.uint8)


def picture(X, covered=0.0, finger=0.0):
    """The printed face at a pose with another print, of a hand, over its left share ``covered``, finger [m] nearer to the camera."""
    image = np.full((LENS.height, LENS.width), 128, np.uint8)
    for print_, width, z in ((PRINT, 1.0, 0.0), (PRINT.T[::-1], covered, -finger)):
        if not width:
            continue
        right = -HALF + 2 * HALF * width
        corners = np.array([[-HALF, -HALF, z], [right, -HALF, z], [right, HALF, z], [-HALF, HALF, z]])
        pixel = LENS.project(corners @ X[:3, :3].T + X[:3, 3]).astype(np.float32)
        w, h = print_.shape[1] * width, print_.shape[0]
        H = cv2.getPerspectiveTransform(np.array([[0, 0], [w, 0], [w, h], [0, h]], np.float32), pixel)
        size = (LENS.width, LENS.height)
        part = np.ascontiguousarray(print_[:, : int(w)])
        warped = cv2.warpPerspective(part, H, size, flags=cv2.INTER_AREA)
        mask = cv2.warpPerspective(np.full_like(part, 255), H, size) > 127
        image[mask] = warped[mask]
    return image


def learnt(image, X):
    levels = pyramid(cut_patch(image, np.zeros(2), np.array([LENS.width, LENS.height])))
    return learn_keyframe(levels, BOX, X, 1e-8 * np.eye(6), LENS)


def sight_of(image, X):
    belief = start(X)
    sight = Sight(image, BOX, LENS, TrackerSettings(), None, belief, belief.motion, 0.0, belief.motion)
    sight.open([X], margin=30.0)
    return sight


def test_an_object_is_found_anywhere_in_the_image_by_its_keyframe():
    keyframe = learnt(picture(X_CO), X_CO)
    for turn, t in (((0.0, 0.0, 0.6), (0.06, 0.02, 0.42)), ((0.2, -0.2, 0.0), (0.08, 0.0, 0.38))):
        X = se3.pose(se3.exp_so3(np.array(turn)), np.array(t))
        found = recall((keyframe,), picture(X), BOX, LENS)
        assert corner_shift(BOX, LENS, found[0], X) < 3.0


def test_nothing_is_recalled_where_the_object_is_not():
    keyframe = learnt(picture(X_CO), X_CO)
    assert recall((keyframe,), np.full((LENS.height, LENS.width), 90, np.uint8), BOX, LENS) == []
    clutter = cv2.resize(PRINT.T[::-1], (LENS.width, LENS.height))
    assert recall((keyframe,), clutter, BOX, LENS) == []
    assert recall((), picture(X_CO), BOX, LENS) == []


@pytest.mark.parametrize("way", [True, False])
def test_a_tracked_object_that_jumps_across_the_image_is_found_only_with_recall(way):
    settings, away = replace(TrackerSettings(), recall=way), se3.pose(np.eye(3), np.array([0.07, 0.03, 0.4]))
    belief = start(X_CO)
    for k in range(4):
        belief = step(belief, picture(X_CO), 0.04 * k, BOX, LENS, settings)
    assert belief.state == "tracking" and belief.keyframes
    for k in range(4, 8):
        belief = step(belief, picture(away), 0.04 * k, BOX, LENS, settings)
    assert (belief.state == "tracking" and corner_shift(BOX, LENS, belief.X_CO, away) < 1.0) is way


def test_patches_of_a_hand_are_given_up_once_the_object_has_turned():
    keyframe = learnt(picture(X_CO, covered=0.5, finger=0.02), X_CO)
    of_hand = keyframe.p_O[:, 0] < -0.005
    assert 0.3 < of_hand.mean() < 0.7
    X = X_CO @ se3.pose(se3.exp_so3(np.array([0.0, 0.35, 0.0])), np.zeros(3))
    (left,) = given_up((keyframe,), X, sight_of(picture(X, covered=0.5, finger=0.02), X))
    kept = left.p_O[:, 0] < -0.005
    assert kept.sum() < 0.3 * of_hand.sum()
    assert (~kept).sum() > 0.8 * (~of_hand).sum()
    lasting = replace(keyframe, lasting=True)
    assert given_up((lasting,), X, sight_of(picture(X, covered=0.5, finger=0.02), X)) == (lasting,)


def test_no_patch_is_learnt_where_an_older_keyframe_says_that_something_covers_the_object():
    known = learnt(picture(X_CO), X_CO)
    image = picture(X_CO, covered=0.4)
    new = learnt(image, X_CO)
    left = uncovered(new, (known,), X_CO, sight_of(image, X_CO))
    assert (left.p_O[:, 0] < -0.02).sum() < 0.2 * (new.p_O[:, 0] < -0.02).sum()
    assert (left.p_O[:, 0] > 0.0).sum() > 0.9 * (new.p_O[:, 0] > 0.0).sum()
    assert uncovered(new, (), X_CO, sight_of(image, X_CO)) is new
