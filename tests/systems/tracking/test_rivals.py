"""Rims beside printed bands, and patches of round surfaces: a can drawn as a camera would see it."""

from dataclasses import replace

import cv2
import numpy as np
import pytest

from vipr.systems import se3
from vipr.systems.camera.lens import Lens
from vipr.systems.tracking.belief import start
from vipr.systems.tracking.cad_model import Shape, build_model
from vipr.systems.tracking.diagnosis import Evidence
from vipr.systems.tracking.displacements import corner_shift, move
from vipr.systems.tracking.learning import learn_keyframe
from vipr.systems.tracking.looks import pyramid
from vipr.systems.tracking.model_tracking import step
from vipr.systems.tracking.normal_flow import cut_patch
from vipr.systems.tracking.overrule import outdone
from vipr.systems.tracking.settings import TrackerSettings
from vipr.systems.tracking.sight import Attempt, Sight

LENS = Lens(320, 240, 500.0, 500.0, 159.5, 119.5)
RADIUS, HEIGHT = 0.03, 0.08  # m
CAN = build_model(Shape("can", cylinders=((np.zeros(3), np.array([0.0, 0.0, HEIGHT]), RADIUS),)))
X_CO = se3.pose(se3.exp_so3(np.array([0.5 * np.pi + 0.4, 0.0, 0.0])), np.array([0.01, 0.04, 0.55]))
BANDS = ((0.006, 0.014), (0.067, 0.074))  # m, from and to, in height
FINER = 8


def picture(spots: np.random.Generator | None = None) -> np.ndarray:
    """The can with a dark band beside each rim and, if asked for, spots, before a grey ground; each pixel is an area."""
    fine = cv2.resize(np.full((LENS.height, LENS.width), 90, np.uint8), None, fx=FINER, fy=FINER)
    around = np.linspace(0.0, 2.0 * np.pi, 721)

    def ring(z, radius=RADIUS, angle=around):
        points = np.column_stack([radius * np.cos(angle), radius * np.sin(angle), np.broadcast_to(z, angle.shape)])
        return points @ X_CO[:3, :3].T + X_CO[:3, 3]

    def fill(points_C, shade):
        pixel = (LENS.project(points_C) + 0.5) * FINER - 0.5
        cv2.fillPoly(fine, [np.rint(16 * pixel).astype(np.int32)], shade, shift=4)

    eye = -X_CO[:3, :3].T @ X_CO[:3, 3]
    middle, half = np.arctan2(eye[1], eye[0]), np.arccos(RADIUS / np.hypot(eye[0], eye[1]))
    front = np.linspace(middle - half, middle + half, 361)
    for low, high, shade in ((0.0, HEIGHT, 140), *((*band, 40) for band in BANDS)):
        fill(np.concatenate([ring(low, angle=front), ring(high, angle=front[::-1])]), shade)
    for _ in range(0 if spots is None else 60):
        angle = spots.uniform(middle - half, middle + half) + 0.08 * np.cos(around)
        height = spots.uniform(0.02, 0.06) + 0.003 * np.sin(around)
        fill(ring(height, angle=angle), int(spots.integers(20, 240)))
    fill(ring(HEIGHT), 25)
    image = cv2.resize(fine, (LENS.width, LENS.height), interpolation=cv2.INTER_AREA)
    return np.clip(image + np.random.default_rng(0).normal(0.0, 1.0, image.shape), 0, 255).astype(np.uint8)


def started(further: float, turn: tuple, settings=TrackerSettings()):
    """The belief after one picture from a start farther away [m] and turned by a rotation vector."""
    centre = X_CO[:3, :3] @ CAN.centre + X_CO[:3, 3]
    R = se3.exp_so3(np.array(turn)) @ X_CO[:3, :3]
    X_start = se3.pose(R, centre * (1.0 + further / centre[2]) - R @ CAN.centre)
    return step(start(X_start), picture(), 0.0, CAN, LENS, settings)


def test_the_can_is_drawn_where_the_model_says():
    assert corner_shift(CAN, LENS, started(0.0, (0.0, 0.0, 0.0)).X_CO, X_CO) < 0.2


@pytest.mark.parametrize("further", [0.02, 0.04])
def test_a_band_is_not_taken_for_the_rim_beside_it(further):
    assert corner_shift(CAN, LENS, started(further, (-0.06, 0.0, 0.0)).X_CO, X_CO) < 0.3


def test_patches_of_a_round_surface_lie_where_they_are_seen():
    levels = pyramid(cut_patch(picture(np.random.default_rng(1)), np.zeros(2), np.array([LENS.width, LENS.height])))
    keyframe = learn_keyframe(levels, CAN, X_CO, 1e-8 * np.eye(6), LENS)
    assert len(keyframe) > 10
    pixel = LENS.project(keyframe.p_O @ X_CO[:3, :3].T + X_CO[:3, 3])
    np.testing.assert_allclose(pixel, np.round(pixel), atol=1e-6)  # patches are centred on pixels
    np.testing.assert_allclose(np.hypot(*keyframe.p_O[:, :2].T), RADIUS, rtol=1e-9)


def test_a_rival_that_fits_closely_takes_the_place_of_a_pose_that_does_not_and_its_texture_is_looked_through():
    image, wrong = picture(np.random.default_rng(1)), move(X_CO, np.array([-0.06, 0.0, 0.0, 0.0, 0.0, 0.02]))
    levels = pyramid(cut_patch(image, np.zeros(2), np.array([LENS.width, LENS.height])))
    learnt = [learn_keyframe(levels, CAN, X, 1e-8 * np.eye(6), LENS, fit_px=px) for X, px in ((wrong, 1), (X_CO, 0.1))]
    belief = start(wrong, keyframes=tuple(learnt))
    sight = Sight(image, CAN, LENS, TrackerSettings(), None, belief, belief.motion, 0.0, belief.motion)
    sight.open([wrong], margin=30.0)
    loose = Attempt(wrong, np.eye(6), Evidence(0.5, 90, sigma=1.3, closeness=0.2), led_by=learnt[0])
    found = outdone(sight, loose, belief.motion, late=0.75, widely=True)
    assert corner_shift(CAN, LENS, found.X_CO, X_CO) < 0.3 < corner_shift(CAN, LENS, wrong, X_CO)
    assert found.prune
    assert outdone(sight, replace(found, led_by=learnt[1]), belief.motion, late=0.75, widely=True) is None
