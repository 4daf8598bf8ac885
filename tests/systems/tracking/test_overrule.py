"""Edges against a texture that was learnt at a wrong pose."""

from dataclasses import replace

import numpy as np

from vipr.systems import se3
from vipr.systems.tracking.ahead_of_time import CORNERS, FACES, LENS, picture
from vipr.systems.tracking.belief import start
from vipr.systems.tracking.cad_model import Shape, build_model
from vipr.systems.tracking.diagnosis import TRACKING, Evidence
from vipr.systems.tracking.displacements import corner_shift, move
from vipr.systems.tracking.learning import learn_keyframe
from vipr.systems.tracking.looks import pyramid
from vipr.systems.tracking.model_tracking import step
from vipr.systems.tracking.normal_flow import cut_patch
from vipr.systems.tracking.overrule import doubt, preferred
from vipr.systems.tracking.sight import Attempt

BOX = build_model(Shape("box", CORNERS, FACES))
X_CO = se3.pose(se3.exp_so3(np.array([0.5, 0.6, 0.1])), np.array([0.0, 0.0, 0.5]))
PRINTS = np.random.default_rng(1).integers(40, 220, (6, 8, 8)).astype(np.uint8)


def keyframe_learnt_at(X, image, fit_px):
    levels = pyramid(cut_patch(image, np.zeros(2), np.array([320.0, 240.0])))
    return learn_keyframe(levels, BOX, X, 1e-8 * np.eye(6), LENS, fit_px=fit_px)


def test_texture_learnt_some_pixels_off_does_not_keep_the_pose_off():
    image = picture(X_CO, PRINTS)
    belief = start(X_CO)
    for k in range(3):
        belief = step(belief, image, 0.04 * k, BOX, LENS)
    X_wrong = move(X_CO, np.array([0.0, 0.0, 0.0, 0.003, 0.002, 0.0]))
    wrong = keyframe_learnt_at(X_wrong, image, fit_px=1.0)
    assert corner_shift(BOX, LENS, X_wrong, X_CO) > 2.5
    belief = replace(belief, keyframes=(wrong,))
    for k in range(3, 8):
        belief = step(belief, image, 0.04 * k, BOX, LENS)
    assert belief.state == "tracking"
    assert corner_shift(BOX, LENS, belief.X_CO, X_CO) < 1.0
    assert all(k is not wrong for k in belief.keyframes)


def test_doubt_grows_with_the_residual_and_with_the_edges_that_are_missing():
    assert doubt(Evidence(edges=0.9, sigma=0.2)) < 0
    assert doubt(Evidence(edges=0.9, sigma=1.2)) > 1
    assert doubt(Evidence(edges=0.2, sigma=0.2)) > 1


def test_texture_that_few_patches_share_does_not_count_against_edges_that_fit_much_better():
    led_by = keyframe_learnt_at(X_CO, picture(X_CO, PRINTS), 0.2)
    edges = Attempt(X_CO, np.eye(6), Evidence(0.6, nodes=100, sigma=0.5, quality=0.55, closeness=0.4, unproven=True))

    def led(texture, quality):
        evidence = Evidence(0.5, 90, texture, patches=64, sigma=1.3, quality=quality, closeness=0.3)
        return Attempt(X_CO, np.eye(6), evidence, led_by=led_by)

    assert led(6.0, 0.35).evidence.score > edges.evidence.score
    assert not preferred(led(6.0, 0.35), edges) and preferred(edges, led(6.0, 0.35))
    assert preferred(led(20.0, 0.35), edges) and not preferred(edges, led(20.0, 0.35))
    assert not preferred(led(20.0, 0.2), edges)


def test_edges_that_fit_nowhere_closely_are_no_proof_whatever_the_texture_says():
    led = Evidence(0.3, 90, texture=15.0, patches=64, sigma=1.3, closeness=0.08)
    assert led.score < TRACKING < replace(led, closeness=0.3).score
