"""Bare arms on drawn blobs: where the hand is, whose arm it is, and what is no face."""

from dataclasses import replace

import cv2
import numpy as np
import pytest

from vipr.systems.hands.arms import Body, arm_at_head, far_end
from vipr.systems.hands.assignment import assign
from vipr.systems.hands.candidates import Candidate
from vipr.systems.hands.head_cut import cut_out_head
from vipr.systems.hands.identities import doubt_face, settle_sides
from vipr.systems.hands.kalman import start
from vipr.systems.hands.parts import Track, hand_before_face
from vipr.systems.signals import SkinRegions

FACE, HEAD = np.array([80.0, 30.0]), 20.0
BODY = Body(shoulder=np.array([63.0, 48.0]), other=np.array([97.0, 48.0]), head=HEAD, face_area=240.0)


def stroke(*points, width=6):
    """Pixels (n, 2) of a thick line through points."""
    mask = np.zeros((120, 160), np.uint8)
    cv2.polylines(mask, [np.array(points, np.int32)], False, 1, width)
    return np.ascontiguousarray(np.argwhere(mask)[:, ::-1], float)


def hand(x, **more):
    return Track(start(x, 70.0, 0.8, 60.0), 60.0, hits=40, **more)


def test_an_arm_that_ends_at_the_head_has_its_hand_before_the_face():
    arm = arm_at_head(stroke((78, 45), (72, 64)), FACE, HEAD)
    assert arm is not None and arm[0][1] < arm[1][1]
    region = Candidate(1, np.zeros(2), 100.0, np.zeros(4), np.zeros(3), 1.0, 0.1, remnant=True, arm=arm)
    x, y = hand_before_face(region, HEAD)
    assert abs(x - 80) < 4 and 30 < y < 40


@pytest.mark.parametrize(
    "piece",
    [
        stroke((78, 45), (76, 52)),  # a hand at the chin
        stroke((60, 50), (95, 50)),  # two hands below it, side by side
        stroke((70, 45), (60, 88)),  # an arm with its hand beside the head
        stroke((75, 50), (70, 62), width=14),
    ],
)
def test_other_things_beside_a_head_are_no_arms_with_a_hidden_hand(piece):
    assert arm_at_head(piece, FACE, HEAD) is None


def test_only_arms_that_have_been_seen_bare_are_told_from_hands_at_the_chin():
    labels = np.zeros((120, 160), np.uint8)
    cv2.ellipse(labels, (80, 30), (8, 10), 0, 0, 360, 1, -1)
    cv2.line(labels, (80, 40), (74, 66), 1, 6)
    regions = SkinRegions(labels=labels, motion=np.zeros_like(labels), size=(160, 120))
    pixels = float(np.count_nonzero(labels))
    whole = Candidate(0, FACE, pixels, np.array([72.0, 20.0, 17.0, 48.0]), np.array([80.0, 30.0, 8.0]), 0.9, 0.6)
    face = Track(start(80.0, 30.0, 0.8, 20.0), 260.0, hits=40, headlike=0.6)
    for bare in (True, False):
        found = cut_out_head(face, [whole], regions, 1.0, bare=bare)[1]
        assert any(r.arm is not None for r in found) == bare


def test_of_crossed_bare_arms_the_ends_are_the_hands():
    crossed = stroke((30, 68), (80, 84), (130, 68), width=10)
    right = far_end(crossed, np.array([122.0, 70.0]), BODY)
    assert right is not None and right[0] > 118
    assert far_end(crossed, np.array([80.0, 70.0]), BODY) is None  # far from both ends
    assert (
        far_end(stroke((62, 60), (80, 50), (98, 60)), np.array([70.0, 60.0]), BODY) is None
    )  # hands meet: ends are elbows


def test_elbows_on_the_wrong_sides_exchange_the_names_soon():
    tracks = {"left": hand(60.0, elbow=55.0, met=True), "right": hand(100.0, elbow=105.0, met=True)}
    order, frames = 4.0, 0
    while tracks["left"].filter.x == 60.0 and frames < 50:
        tracks, order = settle_sides(tracks, order, 0.04, 1.0)
        frames += 1
    assert 3 < frames < 12


def test_hands_that_cross_with_their_elbows_at_home_keep_their_names():
    tracks = {"left": hand(60.0, elbow=100.0, met=True), "right": hand(100.0, elbow=60.0, met=True)}
    order = 0.0
    for _ in range(200):
        tracks, order = settle_sides(tracks, order, 0.04, 1.0)
    assert tracks["left"].filter.x == 60.0


@pytest.mark.parametrize(("headlike", "given_up"), [(0.2, True), (0.6, False)])
def test_a_face_below_a_hand_is_given_up_if_it_looks_like_none(headlike, given_up):
    face = Track(start(110.0, 90.0, 0.8, 20.0), 150.0, hits=40, headlike=headlike)
    tracks, doubt = {"face": face, "right": hand(60.0)}, 0.0
    tracks["right"] = replace(tracks["right"], filter=start(60.0, 40.0, 0.8, 60.0))
    for _ in range(20):
        tracks, doubt = doubt_face(tracks, [], doubt, 0.04)
    assert ("face" not in tracks) == given_up and "right" in tracks


@pytest.mark.parametrize("bare", [True, False])
def test_bare_arms_that_part_after_crossing_are_told_by_their_elbows_not_by_which_end_is_nearer(bare):
    labels, found = np.zeros((120, 160), np.uint8), []
    cv2.ellipse(labels, (80, 38), (8, 10), 0, 0, 360, 1, -1)
    cv2.line(labels, (61, 71), (76, 54), 2, 5)  # the right arm, its hand at the breast
    cv2.line(labels, (99, 71), (84, 54), 3, 5)
    for row in range(3):
        y, x = np.nonzero(labels == row + 1)
        box = np.array([x.min(), y.min(), np.ptp(x) + 1, np.ptp(y) + 1], float)
        centre = np.array([x.mean(), y.mean()])
        found.append(
            Candidate(
                row, centre, float(len(x)), box, np.array([*centre, 8.0 if row == 0 else 2.5]), 0.9, 0.1, moving=0.5
            )
        )
    face = Track(start(80.0, 38.0, 0.8, 20.0), 260.0, hits=40, headlike=0.6)
    crossed = {"face": face, "left": hand(0.0, bare=0.5 * bare), "right": hand(0.0, bare=0.5 * bare)}
    crossed["left"] = replace(crossed["left"], filter=start(77.0, 58.0, 3.0, 150.0))
    crossed["right"] = replace(crossed["right"], filter=start(83.0, 58.0, 3.0, 150.0))
    choice = assign(crossed, found, labels, 0.04, 1.0)
    assert (choice["left"], choice["right"]) == ((2, 1) if bare else (1, 2))
