"""Rendered sequences: the truth is where the edges are, conditions do what they say, trajectories keep their promises."""

import cv2
import numpy as np
import pytest

from vipr.scenarios.sequences import scenery, trajectories
from vipr.scenarios.sequences.rendered import Conditions, hand_motion, hidden_share, sequence
from vipr.scenarios.sequences.renderer import SequenceRenderer
from vipr.systems import se3
from vipr.systems.camera.lens import Lens
from vipr.systems.errors import InputError

LENS = Lens(320, 240, 974.0, 961.5, 159.5, 119.5)
BOX = scenery.box((0.1, 0.07, 0.16))
TURNED = se3.exp_so3(np.array([0.5, 0.7, 0.1]))
X_CO = se3.pose(TURNED, np.array([0.03, -0.02, 1.6]))
QUIET = Conditions(noise=0.0, samples=6)


@pytest.fixture(scope="module")
def renderer(tmp_path_factory):
    folder = tmp_path_factory.mktemp("objects")
    printed = BOX.write(folder / "printed.obj", image=scenery.picture(5, 768, 512, 60))
    white = scenery.Mesh(BOX.faces).write(folder / "white.obj", colour=(0.95, 0.95, 0.95))
    return SequenceRenderer({"printed": printed, "white": white}, LENS, background="plain")


def outline_errors(image, corners):
    """Distances [px] of the seen outline of a bright object outside the projected one, along it."""
    hull = cv2.convexHull(corners.astype(np.float32))[:, 0].astype(float)
    errors, normals = [], []
    offsets = np.arange(-2.5, 2.51, 0.1)
    for a, b in zip(hull, np.roll(hull, -1, axis=0), strict=True):
        length = np.linalg.norm(b - a)
        along = (b - a) / length
        normal = np.array([along[1], -along[0]])
        normal *= np.sign(normal @ (a - hull.mean(axis=0)))
        for s in np.arange(6.0, length - 6.0, 2.0):
            q = (a + s * along + offsets[:, None] * normal).astype(np.float32)
            profile = cv2.remap(image, q[None, :, 0], q[None, :, 1], cv2.INTER_LINEAR)[0]
            inside, outside = profile[:6].mean(), profile[-6:].mean()
            if abs(inside - outside) > 20 and np.ptp(profile[:6]) < 3:
                errors.append(-2.55 + 0.1 * np.sum((profile - outside) / (inside - outside)))
                normals.append(normal)
    return np.array(errors), np.array(normals)


def test_edges_are_where_the_truth_projects_them(renderer):
    rng = np.random.default_rng(0)
    errors, normals = [], []
    for _ in range(6):
        X = se3.pose(se3.exp_so3(rng.normal(size=3)), np.array([*rng.uniform(-0.1, 0.1, 2), 1.5]))
        image = renderer.picture("white", lambda s, X=X: X, samples=12).mean(axis=2)
        e, n = outline_errors(image, LENS.project(BOX.points @ X[:3, :3].T + X[:3, 3]))
        errors.append(e)
        normals.append(n)
    errors, normals = np.concatenate(errors), np.concatenate(normals)
    assert len(errors) > 200
    good = np.abs(errors) < 0.3  # profiles that cross no second edge
    assert good.mean() > 0.95
    # (x, y) shift of all edges, and swelling: half a pixel of confusion anywhere would show as 0.5.
    shift = np.linalg.lstsq(np.c_[normals, np.ones(len(errors))][good], errors[good], rcond=None)[0]
    assert np.abs(shift).max() < 0.03
    assert errors[good].std() < 0.08


def test_blur_is_centred_on_the_true_pose(renderer):
    velocity = np.array([0.4, 0.0, 0.0])
    moving = trajectories.gliding(X_CO, velocity, wait=-0.3)
    middle = moving(0.0)
    blurred = renderer.picture("white", moving, exposure=0.04, samples=6).mean(axis=2)
    sharp = renderer.picture("white", lambda s: middle, samples=6).mean(axis=2)
    columns = np.arange(LENS.width)
    weight = [np.abs(i - i[0, 0]).sum(axis=0) for i in (blurred, sharp)]
    centre = [np.average(columns, weights=w) for w in weight]
    width = [np.sqrt(np.average((columns - c) ** 2, weights=w)) for c, w in zip(centre, weight, strict=True)]
    assert centre[0] == pytest.approx(centre[1], abs=0.2)
    assert width[0] > width[1]
    # A vertical edge is as wide as the way that it went: 0.016 m at 1.6 m.
    assert np.abs(np.diff(blurred, axis=1)).max() < 0.35 * np.abs(np.diff(sharp, axis=1)).max()


def test_noise_is_as_strong_as_asked_and_differs_between_frames(renderer):
    conditions = Conditions(noise=2.0, samples=1)
    (a, _), (b, _) = sequence(renderer, "printed", trajectories.still(X_CO), 2, conditions, seed=1)
    corner = np.s_[:60, :60]
    assert a.image.shape == (240, 320) and a.image.dtype == np.uint8
    assert a.image[corner].astype(float).std() == pytest.approx(2.0, rel=0.1)
    assert (a.image != b.image).mean() > 0.5


def test_same_seed_gives_the_same_bytes_and_truth(renderer):
    shake = trajectories.hand_held(X_CO, BOX.points, LENS, seed=4, pixels_per_frame=9.0, duration=0.4)
    runs = [
        list(sequence(renderer, "printed", shake, 3, Conditions(samples=2, exposure=0.02), seed=7)) for _ in range(2)
    ]
    for (a, X), (b, Y) in zip(*runs, strict=True):
        assert a.image.tobytes() == b.image.tobytes() and np.array_equal(X, Y)


def test_light_goes_and_comes_back_and_frames_drop(renderer):
    conditions = Conditions(noise=0.0, samples=1, light_change=0.5, light_ramp=0.04, drop_every=5, colour=True)
    frames = [f for f, _ in sequence(renderer, "printed", trajectories.still(X_CO), 15, conditions)]
    assert [f.number for f in frames if not f.arrived] == [4, 9, 14]
    level = {f.number: f.image.mean() for f in frames if f.arrived}
    assert level[7] == pytest.approx(0.5 * level[0], rel=0.02) and level[13] == pytest.approx(level[0], rel=0.02)


def test_hand_hides_half_of_the_object(renderer):
    hand = hand_motion(renderer, "printed", trajectories.still(X_CO), "half", 4.0)
    assert hidden_share(renderer, "printed", X_CO, hand(0.0)) == 0.0
    assert 0.4 < hidden_share(renderer, "printed", X_CO, hand(2.0)) < 0.65


def test_object_that_is_not_there_leaves_the_background(renderer):
    gone = renderer.picture("printed", lambda s: None, samples=2)
    away = renderer.picture("printed", lambda s: se3.pose(np.eye(3), np.array([5.0, 0, 2.0])), samples=2)
    assert np.ptp(gone) < 1.5 and np.abs(gone - away).max() < 1.5


@pytest.mark.parametrize("axis", ["x", "y", "z"])
def test_turning_keeps_the_centre_and_reaches_its_speed(axis):
    centre_O = np.array([0.01, 0.02, 0.03])
    turn = trajectories.turning(X_CO, axis, 90.0, centre_O=centre_O)
    before, after = turn(1.0), turn(1.1)
    w = se3.log_so3(after[:3, :3] @ before[:3, :3].T) / 0.1
    np.testing.assert_allclose(w, np.radians(90.0) * trajectories.AXES[axis], atol=1e-9)
    np.testing.assert_allclose(
        after[:3, :3] @ centre_O + after[:3, 3], X_CO[:3, :3] @ centre_O + X_CO[:3, 3], atol=1e-12
    )
    np.testing.assert_allclose(turn(0.1), X_CO, atol=1e-15)


def test_swing_reaches_its_top_speed_and_stays_within_its_amplitude():
    swing = trajectories.swinging(X_CO, [0.15, 0, 0], 0.4)
    x = np.array([swing(t)[0, 3] for t in np.arange(0, 6, 0.001)]) - X_CO[0, 3]
    assert np.abs(x).max() == pytest.approx(0.15, rel=1e-3)
    assert np.abs(np.diff(x)).max() / 0.001 == pytest.approx(0.4, rel=1e-3)


@pytest.mark.parametrize("seed", range(5))
def test_hand_held_corners_reach_the_speed_asked_and_stay_in_the_picture(seed):
    shake = trajectories.hand_held(X_CO, BOX.points, LENS, seed=seed, pixels_per_frame=12.0)
    poses = [shake(k / 25) for k in range(101)]
    assert trajectories.corner_speed(poses, BOX.points, LENS) == pytest.approx(12.0, rel=1e-3)
    np.testing.assert_allclose(poses[0], X_CO, atol=1e-12)
    centres = LENS.project(np.array([X[:3, 3] for X in poses]))
    assert (centres > 0).all() and (centres < (LENS.width, LENS.height)).all()


def test_wrong_names_are_said_clearly(renderer):
    with pytest.raises(InputError, match="printed, white"):
        renderer.picture("teapot", lambda s: None)
    with pytest.raises(InputError, match="none, half, holding"):
        Conditions(hand="two")
    with pytest.raises(InputError, match="plain, clutter"):
        SequenceRenderer({}, LENS, background="sky")
