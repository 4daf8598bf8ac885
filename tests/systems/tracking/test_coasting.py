"""What is thought of an object that has moved on as when it was last seen beyond doubt."""

from dataclasses import replace

import numpy as np
import pytest

from vipr.systems import se3
from vipr.systems.tracking.ahead_of_time import CORNERS, FACES, LENS, picture
from vipr.systems.tracking.belief import start
from vipr.systems.tracking.cad_model import Shape, build_model
from vipr.systems.tracking.coasting import COASTING, coast, coasted
from vipr.systems.tracking.diagnosis import Evidence
from vipr.systems.tracking.displacements import corner_shift, move
from vipr.systems.tracking.model_tracking import step
from vipr.systems.tracking.motion_filter import at_rest
from vipr.systems.tracking.settings import TrackerSettings
from vipr.systems.tracking.sight import Attempt, Sight

BOX = build_model(Shape("box", CORNERS, FACES))
PLAIN = np.array([60, 90, 120, 150, 180, 210], np.uint8).reshape(6, 1, 1) * np.ones((6, 8, 8), np.uint8)
SETTINGS = TrackerSettings()
DT = 0.04


def pose(frame):
    """A box that turns by 50 degrees/s and moves by 0.1 m/s."""
    turn = se3.exp_so3(np.array([0.5, 0.4 + 0.035 * frame, 0.1]))
    return se3.pose(turn, np.array([-0.02 + 0.004 * frame, 0.0, 0.5]))


@pytest.fixture(scope="module")
def steady():
    belief = start(pose(0))
    for k in range(12):
        belief = step(belief, picture(pose(k), PLAIN), DT * k, BOX, LENS)
    return belief


def test_steady_motion_that_fits_is_beyond_doubt_and_leads_on(steady):
    assert steady.sure is not None and steady.sure.time == steady.time
    assert coast(steady, steady.time + DT, SETTINGS) is None  # it was so just now: that is the prediction itself
    doubted = replace(steady, time=steady.time + 2 * DT)
    ahead = coast(doubted, steady.time + 3 * DT, SETTINGS)
    assert corner_shift(BOX, LENS, ahead.X_CO, pose(14)) < 1.5
    assert coast(doubted, steady.time + 3 * DT, replace(SETTINGS, prediction=False)) is None
    assert coast(replace(steady, time=steady.time + COASTING + DT), steady.time + COASTING + 2 * DT, SETTINGS) is None


def coasted_from(steady, X_wrong, closeness):
    """What is made of an attempt at a wrong pose three frames after the box was last seen beyond doubt."""
    time = steady.time + 3 * DT
    doubted = replace(steady, time=time - DT, motion=at_rest(X_wrong))
    sight = Sight(picture(pose(14), PLAIN), BOX, LENS, SETTINGS, None, doubted, doubted.motion, DT, doubted.motion)
    sight.open([X_wrong, pose(14)], margin=14.0)
    best = Attempt(X_wrong, 1e-6 * np.eye(6), Evidence(0.9, 100, closeness=closeness))
    return coasted(sight, best, coast(doubted, time, SETTINGS)), sight


def test_an_attempt_that_leaves_the_motion_and_fits_no_better_gives_way_to_where_the_motion_leads(steady):
    X_wrong = move(pose(14), np.array([0.0, -0.15, 0.0, 0.0, 0.0, 0.0]))
    found, sight = coasted_from(steady, X_wrong, 0.7)
    assert corner_shift(BOX, LENS, X_wrong, pose(14)) > 4.0
    assert corner_shift(BOX, LENS, found.X_CO, pose(14)) < 1.0
    assert np.array_equal(sight.X_CO_ahead, X_wrong)  # the prediction that the rest of the step goes by is as it was


def test_an_attempt_where_the_motion_leads_is_left_alone(steady):
    found, _ = coasted_from(steady, pose(14), 0.7)
    assert found is None
