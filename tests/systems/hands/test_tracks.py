"""The tracks on drawn regions: who is who, births, losses, merging and parting."""

from dataclasses import replace

import cv2
import numpy as np
import pytest
from drawn_people import FACE, LEFT, RIGHT, waving

from vipr.systems.hands.arms import Body, hand_end
from vipr.systems.hands.births import hangs, look_for_better_face
from vipr.systems.hands.blobs import head_in, split
from vipr.systems.hands.candidates import candidates
from vipr.systems.hands.identities import settle_face
from vipr.systems.hands.kalman import start
from vipr.systems.hands.label_truth import tracks_from_labels
from vipr.systems.hands.merging import measure_shared
from vipr.systems.hands.parts import Track
from vipr.systems.hands.pipeline import PeopleBelief, exchanged, see_people
from vipr.systems.hands.tracks import TracksBelief, follow
from vipr.systems.signals import SkinRegions


def regions(k, discs, moving=1.0):
    """Regions of (x, y, radius, faceness) discs, connected where they touch, at frame k."""
    mask, y, x = np.zeros((120, 160), np.uint8), *np.mgrid[0:120, 0:160]
    for cx, cy, radius, _ in discs:
        mask[(x - cx) ** 2 + (y - cy) ** 2 <= radius**2] = 1
    n, labels, stats, centres = cv2.connectedComponentsWithStats(mask)
    cores = []
    for i in range(1, n):
        inside = cv2.distanceTransform((labels == i).astype(np.uint8), cv2.DIST_L2, 3)
        _, radius, _, (px, py) = cv2.minMaxLoc(inside)
        cores.append((px, py, radius))
    faceness = [max([f for cx, cy, _, f in discs if labels[int(cy), int(cx)] == i], default=0.0) for i in range(1, n)]
    return SkinRegions(
        centres=centres[1:].copy(),
        areas=stats[1:, 4].astype(float),
        boxes=stats[1:, :4].astype(float),
        person=np.full(n - 1, 0.95),
        faceness=np.array(faceness),
        moving=np.where(np.array(faceness) > 0.3, 0.05, moving),
        cores=np.array(cores, float).reshape(-1, 3),
        labels=labels.astype(np.uint8),
        motion=np.full((120, 160), 255, np.uint8),
        size=(160, 120),
        cut=k == 0,
        time=k / 25.0,
        number=k,
    )


def track(paths, moving=1.0):
    """Follow frames of discs (a list each); the outputs."""
    belief, outputs = TracksBelief(), []
    for k, discs in enumerate(paths):
        belief = follow(regions(k, discs, moving), belief)
        outputs.append(belief.output)
    return outputs


HEAD = (80, 30, 12, 0.7)


def test_hands_are_named_by_the_persons_own_sides():
    out = track([[HEAD, (110 + k % 3, 70, 6, 0.0), (50, 75 - k % 3, 6, 0.0)] for k in range(6)])[-1]
    assert out.face_seen and out.left_seen and out.right_seen
    assert np.allclose(out.face, (80, 30), atol=0.5)
    assert abs(out.left[0] - 110) < 3 and abs(out.right[0] - 50) < 3
    mirror = exchanged(out)
    assert np.array_equal(mirror.left, out.right) and np.array_equal(mirror.right, out.left)
    assert np.array_equal(mirror.areas, out.areas[[0, 2, 1]])


def test_a_piece_of_an_arm_beside_its_hand_is_no_second_hand():
    def at(k):
        return [HEAD, (30, 70, 8, 0.0)] + [(26, 92, 5, 0.0)] * (k > 8)

    out = track([at(k) for k in range(20)])[-1]
    assert out.right_seen and np.allclose(out.right, (30, 70), atol=2.0)
    assert not out.left_seen


def test_a_hand_that_comes_to_the_chin_is_told_from_the_face():
    head, hand = (80, 50, 30, 0.7), (50, 82, 11, 0.0)
    y, x = np.mgrid[0:120, 0:160]
    moving = (255 * ((x - hand[0]) ** 2 + (y - hand[1]) ** 2 <= hand[2] ** 2)).astype(np.uint8)
    belief = TracksBelief()
    for k in range(16):
        seen = regions(k, [head] + [hand] * (k > 8))
        belief = follow(replace(seen, motion=moving * (k > 8)), belief)
        if k <= 8:
            assert belief.output.face_seen and not belief.output.right_seen
    out = belief.output
    assert out.right_seen and np.hypot(*(out.right - hand[:2])) < 11
    assert out.face_seen and np.hypot(*(out.face - head[:2])) < 6


def test_a_missed_hand_does_not_run_away():
    out = track([[HEAD, (30 + 10 * min(k, 6), 80, 6, 0.0)] if k < 7 else [HEAD] for k in range(12)])[-1]
    assert not out.right_seen
    assert np.isfinite(out.right).all() and out.right[0] < 125


def test_a_small_piece_beside_a_hand_is_no_other_hand():
    frames = [[HEAD, (58, 75 - k % 3, 7, 0.0)] + ([(73, 75, 5, 0.0)] if k > 4 else []) for k in range(40)]
    outputs = track(frames)
    assert outputs[-1].right_seen and not any(o.left_seen for o in outputs)


def test_a_hand_in_a_face_in_which_nothing_moves_may_be_elsewhere():
    both = regions(0, [HEAD, (80, 47, 6, 0.0)])
    tracks = {
        "face": Track(start(80.0, 30.0, 0.8, 20.0), 440.0, headlike=0.7),
        "right": Track(start(80.0, 47.0, 0.8, 60.0), 100.0, shared=True),
    }
    for moving in (0.0, 0.3):
        region = replace(candidates(both, tracks)[0], moving=moving)
        seen = measure_shared("right", tracks["right"], list(tracks), tracks, None, region, both.labels, 0.04, 1.0)
        assert (seen.crowded > 0.0) == (moving == 0.0)


def test_hands_that_cross_keep_their_names():
    def at(k):
        return [HEAD, (115 - 3 * k, 70, 6, 0.0), (45 + 3 * k, 76, 6, 0.0)]

    outputs = track([at(k) for k in range(24)])
    assert any("left" in o.merged and "right" in o.merged for o in outputs)
    assert abs(outputs[-1].left[0] - 46) < 4 and abs(outputs[-1].right[0] - 114) < 4


def test_hands_that_meet_and_go_back_keep_their_names():
    shift = [0, 0, 0, 3, 7, 11, 15, 19, 22, 24, 25, 25, 25, 25, 25, 24, 22, 19, 15, 11, 7, 3, 0, 0]
    outputs = track([[HEAD, (110 - s, 70, 6, 0.0), (50 + s, 70, 6, 0.0)] for s in shift])
    assert any(o.merged for o in outputs)
    assert abs(outputs[-1].left[0] - 110) < 4 and abs(outputs[-1].right[0] - 50) < 4


def test_a_hand_over_the_face_comes_off_as_the_same_hand():
    ys = [*range(80, 34, -5), *[35] * 5, *range(35, 80, 5)]
    outputs = track([[HEAD, (70, y, 5, 0.0), (115, 80 - k % 2, 5, 0.0)] for k, y in enumerate(ys)])
    assert any("face" in o.merged for o in outputs)
    assert abs(outputs[-1].face[1] - 30) < 4 and abs(outputs[-1].right[1] - ys[-1]) < 4


def test_a_face_stays_where_it_is_while_a_hand_goes_over_it():
    outputs = track([[(80, 30, 9, 0.6), (30 + 2 * k, 32, 5, 0.0), (125, 80, 5, 0.0)] for k in range(50)])
    assert all(np.hypot(*(o.face - (80, 30))) < 2.0 for o in outputs[5:])


def test_a_hand_that_leaves_is_unseen_and_is_found_again():
    paths = [[HEAD, (110, 70 - k % 2, 6, 0.0)] + ([(50, 75, 6, 0.0)] if not 8 <= k < 20 else []) for k in range(30)]
    outputs = track(paths)
    assert outputs[6].right_seen and not any(o.right_seen for o in outputs[8:20]) and outputs[-1].right_seen
    assert np.isfinite(outputs[15].right).all() and outputs[15].areas[2] == 0
    assert all(o.left_seen for o in outputs[3:])


def test_still_things_beside_a_face_are_no_hands():
    out = track([[HEAD, (130, 40, 8, 0.0)]] * 10, moving=0.0)[-1]
    assert out.face_seen and not out.left_seen and not out.right_seen
    assert np.isnan(out.left).all() and np.isnan(out.right).all()


@pytest.mark.parametrize(("y", "as_a_hand_hangs"), [(4.0, True), (20.0, False)])
def test_a_head_that_the_upper_border_cuts_is_larger_than_it_looks(y, as_a_hand_hangs):
    face = Track(start(80.0, y, 0.8, 20.0), 150.0, hits=40, headlike=0.6)
    (hand,) = candidates(regions(0, [(105, y + 5.5 * face.head_height, 5, 0.0)], moving=0.0), {})
    assert hangs(hand, face) == as_a_hand_hangs


def test_the_face_moves_to_where_one_is_found():
    first = [[(50, 80, 6, 0.55), (80, 30, 12, 0.1)]]
    later = [[(50, 80 - k % 4, 6, 0.0), (80, 30, 12, 0.7)] for k in range(25)]
    out = track(first + later)[-1]
    assert np.allclose(out.face, (80, 30), atol=1) and out.right_seen


@pytest.mark.parametrize(("radius", "moving", "moves"), [(11, 0.0, True), (7, 0.0, False), (11, 0.6, False)])
def test_a_hand_that_was_taken_for_the_face_gives_way_to_what_is_calm_and_wider_above_all(radius, moving, moves):
    seen = regions(0, [(50, 80, 8, 0.4), (80, 20, radius, 0.12)], moving)
    (top,) = (r for r in candidates(seen, {}) if r.centre[1] < 50.0)
    tracks, rival = {"face": Track(start(50.0, 80.0, 0.8, 20.0), 200.0, hits=40, headlike=0.45)}, 0.0
    for _ in range(10):
        tracks, rival, _ = settle_face(tracks, [top], seen.labels, rival, 0.04, 1.0)
    assert (tracks["face"].filter.y < 50.0) == moves


@pytest.mark.parametrize(("hits", "moves"), [(5, True), (40, False)])
def test_only_a_face_on_trial_gives_way_at_once_to_a_better_one_far_above(hits, moves):
    seen = regions(0, [(80, 20, 10, 0.7), (140, 90, 8, 0.2)])
    better, hand = candidates(seen, {})
    face = Track(start(140.0, 90.0, 0.8, 20.0), 200.0, hits=hits, headlike=0.6)
    tracks = look_for_better_face({"face": face}, hand, [better], seen.labels, 1.0)
    assert (tracks["face"].filter.x < 90.0) == moves


def test_names_on_the_wrong_sides_are_exchanged_after_a_while():
    swapped = [
        [HEAD, (70 - min(k, 15), 70 + k % 2, 6, 0.0)] for k in range(40)
    ]  # a lone hand, born nearly in the middle
    out = track(swapped)[-1]
    assert out.right_seen and not out.left_seen


def test_before_any_pixels_nothing_is_followed():
    belief = TracksBelief()
    assert follow(SkinRegions(), belief) is belief
    assert PeopleBelief().tracks.number == -1


def test_images_give_face_and_both_hands_within_two_pixels():
    belief = PeopleBelief()
    for k in range(20):
        belief = see_people(waving(k), k / 25.0, k, belief)
    shift = round(14 * np.sin(0.3 * 19))
    tracks = belief.tracks
    for name, truth in (("face", FACE), ("left", (LEFT[0], LEFT[1] + shift)), ("right", (RIGHT[0], RIGHT[1] - shift))):
        assert getattr(tracks, f"{name}_seen")
        assert np.hypot(*(getattr(tracks, name) - truth)) < 2.0, name


def test_the_hand_is_the_far_end_of_a_bare_arm():
    y, x = np.mgrid[60:66, 20:80]
    arm = np.column_stack([x.ravel(), y.ravel()]).astype(float)
    body = Body(shoulder=np.array([85.0, 40.0]), other=np.array([33.0, 40.0]), head=30.0, face_area=500.0)
    centre, count = hand_end(arm, None, body, np.zeros((120, 160), np.uint8))
    assert centre[0] < 35 and count < 0.5 * len(arm)
    ball = arm[(np.abs(arm[:, 0] - 50) < 4)]
    assert np.allclose(hand_end(ball, None, body, np.zeros((120, 160), np.uint8))[0], ball.mean(0))


def test_a_merged_blob_is_shared_by_where_parts_are_expected():
    y, x = np.mgrid[0:120, 0:160]
    two = ((x - 60) ** 2 + (y - 60) ** 2 <= 64) | ((x - 72) ** 2 + (y - 60) ** 2 <= 64)
    p = np.argwhere(two)[:, ::-1].astype(float)
    centres, count = split(p, np.array([[58.0, 60.0], [74.0, 60.0]]), np.array([8.0, 8.0]))
    assert np.allclose(centres, [[60, 60], [72, 60]], atol=2.0) and count.sum() == pytest.approx(len(p), rel=0.05)
    centre, n = head_in(p, np.array([57.0, 58.0]), 6.0)
    assert abs(centre[0] - 61) < 3 and n > 100


def test_truth_is_the_centre_of_gravity_of_what_is_visible():
    labels = np.zeros((120, 160), np.int16)
    labels[20:30, 70:80], labels[50:54, 100:104], labels[60:62, 40:43] = 1, 2, 3
    truth = tracks_from_labels(labels, 0.5, 7)
    assert np.allclose(truth.face, (74.5, 24.5)) and np.allclose(truth.left, (101.5, 51.5))
    assert truth.left_seen and not truth.right_seen and truth.areas.tolist() == [100, 16, 0]


def test_a_speck_that_happens_to_look_like_a_face_is_not_the_face():
    hand = (60, 80, 8, 0.0)
    assert not any(t.face_seen for t in track([[hand, (110, 30, 1.5, 0.9)]] * 12))
    assert track([[hand, (110, 30, 7, 0.9)]] * 12)[-1].face_seen


def test_a_bare_arm_with_some_marks_is_no_head():
    arm = [(30 + 4 * i, 60 + 2 * i, 5, 0.45) for i in range(12)]
    assert not any(t.face_seen for t in track([[*arm, (120, 90, 6, 0.0)]] * 12))


def test_what_has_no_marks_is_no_face_only_for_being_on_top():
    things = [(80, 30, 9, 0.0), (50, 90, 6, 0.0), (110, 90, 6, 0.0), (80, 105, 6, 0.0)]
    assert not any(o.face_seen for o in track([things] * 40, moving=0.2))


def test_a_mirrored_film_gives_the_mirrored_tracks_with_the_names_exchanged():
    film = [waving(k, left=None if 20 < k < 30 else (116, 60 + k)) for k in range(45)]
    there, mirror, seen = PeopleBelief(), PeopleBelief(), 0
    for k, image in enumerate(film):
        there = see_people(image, k / 25.0, k, there)
        mirror = see_people(np.ascontiguousarray(image[:, ::-1]), k / 25.0, k, mirror)
        a, b = there.tracks, exchanged(mirror.tracks)
        for name in ("face", "left", "right"):
            assert getattr(a, f"{name}_seen") == getattr(b, f"{name}_seen"), (name, k)
            if getattr(a, f"{name}_seen"):
                seen += 1
                assert np.allclose(getattr(a, name), [159 - getattr(b, name)[0], getattr(b, name)[1]], atol=1.0), k
    assert seen > 100
