"""Movements are cut at pauses and named as soon as they end."""

import importlib.util
from pathlib import Path

import numpy as np
import pytest
from pydrake.systems.analysis import Simulator

from vipr.systems.errors import InputError
from vipr.systems.gestures.body import BodyBelief, direction, seen_from_face, told_apart
from vipr.systems.gestures.segmentation import MotionBelief, PauseSettings, advance, segment
from vipr.systems.gestures.trajectories import Trajectory
from vipr.systems.signals import Gesture, HandTracks

_spec = importlib.util.spec_from_file_location("examples_gestures_here", Path(__file__).with_name("examples.py"))
examples = importlib.util.module_from_spec(_spec)
_spec.loader.exec_module(examples)

DT = 0.04


def recording(strokes, pause=0.5, noise=0.02, seed=0):
    """Times, points and the true (start, end) of strokes (displacements in faces, 0.6 s each) between pauses."""
    rng, at, points, bounds = np.random.default_rng(seed), np.zeros(2), [], []
    for way in strokes:
        points += [at] * round(pause / DT)
        bounds.append((len(points) * DT, len(points) * DT + 0.6))
        u = 0.5 - 0.5 * np.cos(np.pi * np.linspace(0.0, 1.0, 16))[1:]
        points += list(at + u[:, None] * np.array(way))
        at = at + way
    points += [at] * round(pause / DT)
    return np.arange(len(points)) * DT, np.array(points) + noise * rng.normal(size=(len(points), 2)), bounds


def test_each_stroke_between_pauses_is_one_movement():
    times, points, bounds = recording([(3.0, 0.0), (0.0, 2.0), (-2.0, -2.0), (0.0, 1.2)])
    found = segment(times, points)
    assert len(found) == 4
    for movement, (start, end) in zip(found, bounds, strict=True):
        assert abs(movement.times[0] - start) < 0.2
        assert abs(movement.times[-1] - end) < 0.2


def test_slow_corners_do_not_cut_a_movement():
    u = np.linspace(0.0, 1.0, 40)
    corner = np.column_stack([np.minimum(2 * u, 1.0) * 3.0, np.maximum(2 * u - 1.0, 0.0) * 3.0])
    points = np.concatenate([np.zeros((12, 2)), corner, np.repeat(corner[-1:], 12, 0)])
    assert len(segment(np.arange(len(points)) * DT, points)) == 1


def test_turning_back_slowly_does_not_cut_a_movement():
    t = np.arange(31) * DT
    there_and_back = np.column_stack([1.5 * (1.0 - np.cos(2.0 * np.pi * t / t[-1])), np.zeros(31)])
    points = np.concatenate([np.zeros((12, 2)), there_and_back, np.zeros((12, 2))])
    noise = 0.02 * np.random.default_rng(2).normal(size=points.shape)
    assert len(segment(np.arange(len(points)) * DT, points + noise)) == 1


def test_a_recording_that_begins_in_the_middle_of_a_movement_loses_none_of_it():
    turn = 2.0 * np.pi * np.arange(25) / 25
    circle = np.column_stack([np.cos(turn), np.sin(turn)])
    points = np.concatenate([circle, np.tile(circle[-1:], (10, 1))])
    (movement,) = segment(np.arange(len(points)) * DT, points)
    assert movement.times[0] == 0.0
    rested = np.concatenate([np.tile(circle[:1], (10, 1)), points])
    (movement,) = segment(np.arange(len(rested)) * DT, rested)
    assert 9 * DT <= movement.times[0] <= 10 * DT


def test_trembling_and_small_shifts_are_no_movement():
    rng = np.random.default_rng(1)
    t = np.arange(200) * DT
    drift = np.column_stack([0.05 * t, 0.3 * np.sin(0.5 * t)])
    assert segment(t, drift + 0.03 * rng.normal(size=(200, 2))) == []


def test_a_movement_is_cut_within_200_ms_of_its_end():
    times, points, bounds = recording([(3.0, 0.0), (0.0, 2.0)])
    belief, ends = MotionBelief(), []
    for time, point in zip(times, points, strict=True):
        belief, movement = advance(belief, time, point, PauseSettings())
        if movement is not None:
            ends.append(time)
    assert len(ends) == 2
    for end, (_, truth) in zip(ends, bounds, strict=True):
        assert end <= truth + 0.2 + 1e-9


def test_bad_frames_are_passed_over():
    times, points, _ = recording([(3.0, 0.0)])
    wrong = [(np.nan, points[0]), (times[3], np.full(2, np.nan)), (times[1], points[5]), (times[2], points[9])]
    belief, found = MotionBelief(), []
    for n, (time, point) in enumerate(zip(times, points, strict=True)):
        for t, p in [(time, point), *(wrong if n > 3 else [])]:
            belief, movement = advance(belief, t, p, PauseSettings())
            found += [] if movement is None else [movement]
    expected = segment(times, points)
    assert len(found) == len(expected) == 1
    np.testing.assert_array_equal(found[0].points, expected[0].points)


def test_an_endless_movement_is_cut():
    t = np.arange(400) * DT
    circle = 2.0 * np.column_stack([np.cos(4 * t), np.sin(4 * t)])
    found = segment(t, circle, PauseSettings(longest=5.0))
    assert 2 <= len(found) <= 4
    assert max(m.times[-1] - m.times[0] for m in found) <= 5.05


def test_after_a_gap_segmentation_starts_afresh():
    times, points, _ = recording([(3.0, 0.0)])
    later = np.where(np.arange(len(times)) > 18, times + 5.0, times)
    assert segment(later, points) == [] or all(np.ptp(m.times) < 1.0 for m in segment(later, points))


def test_impossible_pauses_are_refused():
    with pytest.raises(InputError, match="near below leave"):
        PauseSettings(near=1.0)


def tracks(
    face=(80.0, 30.0), left=(100.0, 60.0), right=(60.0, 60.0), seen=(True, True, True), area=169.0, merged=(), number=0
):
    return HandTracks(
        face=np.array(face), left=np.array(left), right=np.array(right), face_seen=seen[0], left_seen=seen[1], right_seen=seen[2],
        areas=np.array([area, 80.0, 80.0]), merged=merged, size=(160, 120), time=0.04 * number, number=number,
    )  # fmt: skip


def test_points_do_not_depend_on_where_and_how_far_the_person_is():
    near = seen_from_face(BodyBelief(), tracks())[1]
    far = seen_from_face(BodyBelief(), tracks((40.0, 50.0), (50.0, 65.0), (30.0, 65.0), area=169.0 / 4))[1]
    np.testing.assert_allclose(near, far)
    assert near[1] < 0  # hands below the face, y up
    assert near[0] > 0 > near[2]  # the person's left on the image's right


def test_hidden_hands_stay_where_they_were_and_unknown_ones_hang():
    belief, point = seen_from_face(BodyBelief(), tracks(seen=(True, True, False)))
    assert point[3] < -4.0
    _, later = seen_from_face(belief, tracks(left=(np.nan, np.nan), seen=(True, False, False)))
    np.testing.assert_array_equal(later, point)
    assert seen_from_face(BodyBelief(), tracks(seen=(False, True, True)))[1] is None


def test_direction_is_that_of_the_hand_that_went_furthest():
    points = np.zeros((10, 4))
    points[:, 0] = np.linspace(0.0, 0.5, 10)
    points[:, 2:] = np.linspace(0.0, 1.0, 10)[:, None] * np.array([-3.0, 4.0])
    np.testing.assert_allclose(direction(points), [-0.6, 0.8])
    assert (direction(np.zeros((4, 4))) == 0).all()


def run(until):
    system, fix = examples.recogniser()
    simulator = Simulator(system)
    context = simulator.get_mutable_context()
    fix(context, 0.0)
    simulator.Initialize()
    said = []
    for k in range(round(until / DT)):
        fix(context, k * DT)
        simulator.AdvanceTo(k * DT + 0.01)
        said.append(system.GetOutputPort("gesture").Eval(context))
    return said


def test_the_system_names_gestures_in_turn_within_200_ms():
    said = run(3.1)
    assert said[0].number == -1 and said[0].name == "" and said[0].rejected
    known = {g.number: g for g in said if g.name and not g.rejected}
    names = [known[n].name for n in sorted(known)]
    assert names[:1] == ["up"]
    assert "out" in names
    out = next(g for g in known.values() if g.name == "out")
    up = next(g for g in known.values() if g.name == "up")
    assert up.end == pytest.approx(1.06, abs=0.15)
    assert up.named - up.end <= 0.2
    assert np.isnan(up.direction).all()
    np.testing.assert_allclose(out.direction, [-1.0, 0.07], atol=0.1)


def test_nothing_is_said_without_a_face():
    system, _ = examples.recogniser()
    simulator = Simulator(system)
    system.GetInputPort("hand_tracks").FixValue(simulator.get_mutable_context(), HandTracks(number=3))
    simulator.AdvanceTo(0.5)
    said = system.GetOutputPort("gesture").Eval(simulator.get_context())
    assert isinstance(said, Gesture) and said.number == -1


def wave(frames=30):
    """The right hand waves to and fro beside a left one that hangs: (T, 4) in faces."""
    u = np.linspace(0.0, 2.0 * np.pi, frames)
    return np.column_stack([np.full(frames, 2.0), np.full(frames, -5.0), -2.0 + np.sin(u), np.zeros(frames)])


@pytest.mark.parametrize("wrong", [slice(0, 0), slice(12, None), slice(0, 12), slice(10, 20), slice(None)])
def test_names_of_hands_that_a_tracker_exchanged_are_mended(wrong):
    points, times = wave(), np.arange(30) * DT
    given = points.copy()
    given[wrong] = points[wrong][:, [2, 3, 0, 1]]
    np.testing.assert_array_equal(told_apart(Trajectory(given, times)).points, points)


def test_hands_that_cross_and_come_back_keep_their_names():
    u = np.linspace(0.0, np.pi, 20)
    x = 1.5 - 3.0 * np.sin(u)
    points = np.column_stack([x, np.full(20, -2.0), -x, np.full(20, -2.5)])
    np.testing.assert_array_equal(told_apart(Trajectory(points, u)).points, points)
