"""The tasks: what the hand does moves the body as the law wants, before a fixed camera and with the camera in the hand."""

import numpy as np
import pytest

from vipr.systems import se3
from vipr.systems.servo.position_based import PositionBased, position_based_twist
from vipr.systems.servo.target_filter import TargetBelief
from vipr.systems.servo.tasks import Hand, Look, Place, Reach

rng = np.random.default_rng(5)
BOX = rng.uniform(-0.1, 0.1, (8, 3))


def pose(scale=0.4):
    return se3.exp(rng.normal(0, scale, 6))


X_WC, X_EC, X_WE, X_WO = pose(), pose(), pose(), pose()
NO_ONE = TargetBelief()
SHOWN = se3.pose(pose()[:3, :3], [0.1, 0.0, 1.5])
TASKS = {
    "reach": Reach(X_WC, pose(), BOX),
    "place": Place(X_WC, SHOWN, BOX, rng.uniform(-0.1, 0.1, (8, 2))),
    "look": Look(X_EC, SHOWN, BOX),
}
each_task = pytest.mark.parametrize("task", TASKS.values(), ids=TASKS)


def target(task, X_WE=X_WE):
    return TargetBelief(se3.inverse(X_WE) @ X_WO if task.held else X_WO, time=0.0)


def body(task, hand, belief):
    return task.situation(belief, NO_ONE, hand).X_CB


@each_task
def test_hand_twist_moves_the_body_by_the_twist_that_the_law_asks_for(task):
    V_B, h = rng.normal(0, 0.3, 6), 1e-6
    V_WE = task.hand_twist(V_B, Hand(X_WE, np.zeros(6), 0.0))
    hand = Hand(X_WE, V_WE, 0.0)
    belief = target(task)
    before, after = (body(task, Hand(hand.pose_at(t), V_WE, 0.0), belief) for t in (-h, h))
    moved = (after - before) / (2 * h) @ se3.inverse(body(task, hand, belief))
    assert np.allclose([moved[2, 1], moved[0, 2], moved[1, 0], *moved[:3, 3]], V_B, atol=1e-7)
    assert np.allclose(task.body_twist(hand), V_B)


@each_task
def test_goal_of_hand_ends_the_task(task):
    hand, belief = Hand(X_WE, np.zeros(6), 0.0), target(task)
    there = Hand(task.goal_of_hand(task.situation(belief, NO_ONE, hand), hand), np.zeros(6), 0.0)
    assert np.allclose(task.situation(belief, NO_ONE, there).pose_error, 0, atol=1e-9)


@each_task
def test_a_moving_goal_carries_the_hand_with_it(task):
    """With the error at zero, the hand that moves by the goal's twist keeps it at zero."""
    if task.held:
        return  # a shown place stands still
    V_WO, h = rng.normal(0, 0.3, 6), 1e-6
    belief = TargetBelief(X_WO, V_WO, time=0.0)
    here = Hand(X_WE, np.zeros(6), 0.0)
    there = task.goal_of_hand(task.situation(belief, NO_ONE, here), here)
    here = Hand(there, np.zeros(6), 0.0)
    V_WE = task.hand_twist(task.situation(belief, NO_ONE, here).V_G, here)
    later = Hand(Hand(there, V_WE, 0.0).pose_at(h), V_WE, h)
    assert np.linalg.norm(task.situation(belief, NO_ONE, later).pose_error) < 1e-9


def test_a_hand_that_is_seen_comes_to_its_place_although_the_camera_stands_elsewhere():
    """Endpoint closed-loop: X_WC is 50 mm and 5 degrees wrong, the hand is seen beside the object."""
    wrong = se3.pose(se3.exp_so3(np.deg2rad([3.0, -4.0, 0.0])), [0.03, 0.04, 0.0]) @ X_WC
    task, X = Reach(wrong, TASKS["reach"].X_OG, BOX), X_WE
    X_CW = se3.inverse(X_WC)
    for seen_too, reached in ((False, False), (True, True)):
        for _ in range(400):
            hand = Hand(X, np.zeros(6), 0.0)
            belief = TargetBelief(wrong @ X_CW @ X_WO, time=0.0)
            seen_hand = TargetBelief(se3.inverse(X) @ wrong @ X_CW @ X, time=0.0) if seen_too else NO_ONE
            situation = task.situation(belief, seen_hand, hand)
            V = task.hand_twist(position_based_twist(situation, PositionBased()), hand)
            X = Hand(X, V, 0.0).pose_at(0.04)
        away = np.linalg.norm(se3.difference(X, X_WO @ task.X_OG)[3:])
        assert (away < 1e-6) == reached and (reached or away > 0.02)
