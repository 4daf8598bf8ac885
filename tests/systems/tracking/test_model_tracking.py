"""The tracker follows a drawn box, knows when it does not, and survives what it may be fed."""

from dataclasses import fields, replace

import numpy as np
import pytest
from drawn_objects import LENS, box, picture, pose_at

from vipr.systems import se3
from vipr.systems.camera.lens import Lens
from vipr.systems.errors import InputError
from vipr.systems.tracking.belief import Belief, start
from vipr.systems.tracking.cad_model import Shape, build_model
from vipr.systems.tracking.displacements import corner_shift
from vipr.systems.tracking.model_tracking import step
from vipr.systems.tracking.settings import TrackerSettings
from vipr.systems.tracking.triangulation import box_triangles

BLANK = np.full((LENS.height, LENS.width), 90, np.uint8)
NONE = np.zeros((0, 0), np.uint8)


def follow(poses, settings=TrackerSettings(), model=None, belief=None, draw=picture):
    model = model or box()
    belief = belief or start(poses[0])
    beliefs = []
    for k, X_CO in enumerate(poses):
        belief = step(belief, draw(model, X_CO), 0.04 * k, model, LENS, settings)
        beliefs.append(belief)
    return beliefs


def off(belief, X_CO):
    return corner_shift(box(), LENS, belief.X_CO, X_CO)


MOVING = [pose_at(0.04 * k) for k in range(15)]


def test_a_turning_box_is_followed():
    beliefs = follow(MOVING)
    assert [b.state for b in beliefs] == ["tracking"] * 15
    assert max(off(b, X) for b, X in zip(beliefs, MOVING, strict=True)) < 0.6
    assert np.degrees(se3.angle_between(beliefs[-1].X_CO, MOVING[-1])) < 0.5
    assert np.linalg.norm(beliefs[-1].X_CO[:3, 3] - MOVING[-1][:3, 3]) < 2e-3
    assert np.allclose(beliefs[-1].V_CO[3:], [0.02, 0, 0], atol=0.02)
    assert np.linalg.eigvalsh(beliefs[-1].covariance).min() > 0


@pytest.mark.parametrize(
    "part",
    [f.name for f in fields(TrackerSettings) if isinstance(getattr(TrackerSettings(), f.name), bool)],
)
def test_each_part_can_be_switched(part):
    settings = replace(TrackerSettings(), **{part: not getattr(TrackerSettings(), part)})
    beliefs = follow(MOVING[:6], settings)
    assert off(beliefs[-1], MOVING[5]) < 1.5
    assert beliefs[-1].state == "tracking"


def test_a_start_some_pixels_off_finds_the_box():
    X = pose_at(0.0)
    wrong = se3.pose(se3.exp_so3(np.array([0.02, -0.03, 0.02])) @ X[:3, :3], X[:3, 3] + (0.003, -0.003, 0.004))
    assert corner_shift(box(), LENS, wrong, X) > 3
    assert off(follow([X] * 3, belief=start(wrong))[-1], X) < 0.6


def test_an_object_that_vanishes_is_not_said_to_be_tracked():
    belief = follow(MOVING[:5])[-1]
    states = []
    for k in range(5, 11):
        belief = step(belief, BLANK, 0.04 * k, box(), LENS)
        states.append(belief.state)
    assert "tracking" not in states
    assert states[-1] == "lost"


def test_a_dropped_frame_only_predicts():
    belief = follow(MOVING[:8])[-1]
    after = step(belief, NONE, 0.32, box(), LENS)
    assert after.state == "uncertain" and after.nodes == 0
    assert off(after, MOVING[8]) < 1.0
    assert (after.covariance.diagonal() > belief.covariance.diagonal()).all()
    assert step(after, picture(box(), MOVING[9]), 0.36, box(), LENS).state == "tracking"


def test_a_known_hand_in_front_does_not_disturb():
    X = pose_at(0.0)
    hand = box_triangles(np.array([0.05, 0.3, 0.01])) + (0.045, 0.0, 0.2)
    image = picture(box(), X)
    right = LENS.project(np.array([0.02, 0.0, 0.2]))[0]
    image[:, int(right) :] = 200
    belief = start(X)
    for k in range(4):
        belief = step(belief, image, 0.04 * k, box(), LENS, occluders_C=hand)
    assert belief.state == "tracking" and off(belief, X) < 1.0


def test_colour_and_grey_images_give_the_same_pose():
    X = pose_at(0.0)
    grey = picture(box(), X)
    found = [step(start(X), image, 0.0, box(), LENS).X_CO for image in (grey, np.stack([grey] * 3, 2))]
    assert corner_shift(box(), LENS, *found) < 0.1


def test_bodies_of_one_cylinder_are_tracked():
    can = build_model(Shape("can", cylinders=((np.array([0, 0, -0.05]), np.array([0, 0, 0.05]), 0.03),)))
    X = se3.pose(se3.exp_so3(np.array([1.1, 0, 0])), np.array([0, 0, 0.3]))
    image = silhouette(can, X)
    shifted = se3.pose(X[:3, :3], X[:3, 3] + (0.002, 0.002, 0.0))
    belief = start(shifted)
    for k in range(3):
        belief = step(belief, image, 0.04 * k, can, LENS)
    assert np.abs(belief.X_CO[:2, 3] - X[:2, 3]).max() < 4e-4


def silhouette(model, X_CO):
    """White on dark, drawn four times as fine."""
    import cv2

    fine = Lens(640, 480, 800.0, 800.0, 319.5, 239.5)
    image = np.full((480, 640), 30, np.uint8)
    points = fine.project(model.surface @ X_CO[:3, :3].T + X_CO[:3, 3])
    for triangle in points:
        cv2.fillConvexPoly(image, np.round(triangle * 16).astype(np.int32), 210, cv2.LINE_AA, 4)
    return cv2.resize(image, (160, 120), interpolation=cv2.INTER_AREA)


@pytest.mark.parametrize(
    ("X_CO", "message"),
    [
        (se3.pose(np.eye(3), np.array([0.0, 0.0, -1.0])), "in front of the camera"),
        (np.full((4, 4), np.nan), "finite 4x4 rigid motion"),
        (np.diag([1.0, 1.0, -1.0, 1.0]), "rigid motion"),
        (np.eye(3), "4x4"),
    ],
)
def test_what_is_no_pose_before_the_camera_is_refused(X_CO, message):
    with pytest.raises(InputError, match=message):
        start(X_CO)


def test_an_image_of_another_size_is_refused():
    with pytest.raises(InputError, match="the image is 10 x 20 px, its lens is for 160 x 120 px"):
        step(start(pose_at(0.0)), np.zeros((20, 10), np.uint8), 0.0, box(), LENS)


def test_settings_that_make_no_sense_are_refused():
    with pytest.raises(InputError, match="nodes must be positive, got -3"):
        TrackerSettings(nodes=-3)


@pytest.mark.parametrize("size", [(2, 2), (1, 1), (7, 5)])
def test_images_of_a_few_pixels_are_lost_and_nothing_worse(size):
    lens = Lens(*size, 2.0, 2.0, 0.5, 0.5)
    belief = start(pose_at(0.0))
    for k in range(3):
        belief = step(belief, np.zeros(size[::-1], np.uint8), 0.04 * k, box(), lens)
    assert belief.state != "tracking" and np.isfinite(belief.X_CO).all()


@pytest.mark.parametrize("place", [(3.0, 0.0, 0.5), (0.0, 0.0, 1e-4), (0.0, 0.0, 0.02), (0.0, 0.0, 500.0)])
def test_an_object_out_of_view_or_too_near_or_far_is_lost_and_nothing_worse(place):
    belief = start(se3.pose(np.eye(3), np.array(place)))
    rng = np.random.default_rng(0)
    for k in range(4):
        noise = rng.integers(0, 256, (LENS.height, LENS.width)).astype(np.uint8)
        belief = step(belief, noise, 0.04 * k, box(), LENS)
        assert np.isfinite(belief.X_CO).all() and np.isfinite(belief.covariance).all()
    assert belief.state != "tracking"


def test_a_model_of_one_line_does_not_pretend_to_be_tracked():
    line = build_model(Shape("line", np.array([[0, 0, 0], [0.1, 0, 0.0]]), (), ((0, 1),)))
    belief = start(pose_at(0.0))
    for k in range(3):
        belief = step(belief, picture(box(), pose_at(0.0)), 0.04 * k, line, LENS)
    assert np.isfinite(belief.X_CO).all()


def test_time_may_stand_still_run_back_or_jump():
    belief = follow(MOVING[:4])[-1]
    for t in (0.12, 0.0, 1e6):
        belief = step(belief, picture(box(), MOVING[3]), t, box(), LENS)
        assert np.isfinite(belief.X_CO).all()
    assert isinstance(belief, Belief)
