"""What was not seen is missing: it is integrated out, and no stroke is made up for it."""

import numpy as np
import pytest

from vipr.scenarios.bench.gestures.reference import density, enumerate_paths, random_bank
from vipr.systems.gestures.classifier import GestureClassifier
from vipr.systems.gestures.gaps import lose, seen_points
from vipr.systems.gestures.hmm import emissions, score
from vipr.systems.gestures.segmentation import segment
from vipr.systems.gestures.training import HmmSpec, train
from vipr.systems.gestures.trajectories import Stream, Trajectory, clean, describe, resample


@pytest.mark.parametrize("K", [1, 2])
def test_a_missing_point_is_integrated_out_of_the_score(K):
    rng = np.random.default_rng(4)
    bank, x = random_bank(rng, K=K, M=2), rng.normal(size=(1, 6, 2))
    missing = x.copy()
    missing[0, 2:4] = np.nan
    assert (emissions(bank, missing)[2:4] == 0.0).all()
    for m in range(2):
        total = sum(
            p / (density(bank, m, states[2], x[0, 2]) * density(bank, m, states[3], x[0, 3]))
            for p, states in enumerate_paths(bank, m, x[0])
        )
        assert score(bank, missing)[0, m] == pytest.approx(np.log(total), abs=1e-9)


def test_models_are_trained_on_what_was_seen():
    rng = np.random.default_rng(0)
    x = np.repeat(np.arange(4.0), 5)[None, :, None] + 0.1 * rng.normal(size=(30, 20, 1))
    x[np.arange(30)[:, None], rng.integers(1, 12, 30)[:, None] + np.arange(6)] = np.nan
    bank = train(x, np.full(30, 20), np.zeros(30, int), HmmSpec(4, floor=1e-3))
    np.testing.assert_allclose(bank.means[0, :, 0, 0], np.arange(4.0), atol=0.1)


def test_a_gap_keeps_its_share_of_the_way_and_its_points_are_missing():
    u = np.linspace(0.0, 2.0 * np.pi, 101)
    circle = np.column_stack([np.cos(u), np.sin(u)])
    torn = circle.copy()
    torn[26:75] = np.nan  # half of it
    whole, part = clean(circle), clean(torn)
    (at,), (seen,) = resample([part], "arc", 33), seen_points([part], "arc", 33)
    np.testing.assert_allclose(at[seen], resample([whole], "arc", 33)[0][seen], atol=0.02)
    assert 14 <= (~seen).sum() <= 17 and seen[:8].all() and seen[-8:].all()
    x = describe(at[None], Stream(("position", "direction")), seen[None])[0]
    assert (np.isnan(x).any(axis=1) == np.isnan(x).all(axis=1)).all()
    assert np.isnan(x[~seen]).all() and 0 < np.isnan(x[seen]).all(axis=1).sum() <= 2


def test_a_single_point_that_is_missing_is_bridged():
    line = np.column_stack([np.arange(50.0), np.arange(50.0)])
    line[20] = np.nan
    assert seen_points([clean(line)], "time", 32).all()


def test_lost_stretches_are_straight_and_told():
    rng = np.random.default_rng(1)
    points = rng.normal(size=(200, 32, 2))
    lost, seen = lose(points, np.ones((200, 32), bool), rng, 0.5)
    assert 60 < (~seen).any(axis=1).sum() < 140
    assert seen[:, 0].all() and seen[:, -1].all()
    np.testing.assert_array_equal(lost[seen], points[seen])
    bend = np.diff(lost, n=2, axis=1)
    np.testing.assert_allclose(bend[~seen[:, 1:-1] & ~seen[:, :-2] & ~seen[:, 2:]], 0.0, atol=1e-12)


def _letters(rng, each):
    u = np.linspace(0.0, 1.0, 41)
    shapes = {"U": (np.interp(u, [0, 0.33, 0.67, 1], [0, 0, 1, 1]), np.interp(u, [0, 0.33, 0.67, 1], [1, 0, 0, 1])),
              "V": (u, np.abs(2.0 * u - 1.0)),
              "O": (np.sin(6.28 * u), np.cos(6.28 * u)), "C": (-np.sin(5.0 * u + 0.6), np.cos(5.0 * u + 0.6))}  # fmt: skip
    for name, shape in shapes.items():
        for _ in range(each):
            yield name, np.column_stack(shape) * rng.uniform(20, 60) + rng.normal(0.0, 0.6, (41, 2))


@pytest.mark.parametrize("streams", ["combined", "default"])
def test_letters_with_gaps_are_read_better_if_the_gaps_are_told(streams):
    rng = np.random.default_rng(2)
    y, X = zip(*_letters(rng, 16), strict=True)
    how = dict(discriminative=False, covariance="full") if streams == "combined" else dict(gaps=0.3, updates=60)
    classifier = GestureClassifier(streams, **how).fit(X, y)
    truth, whole = zip(*_letters(rng, 40), strict=True)
    told, untold = [], []
    for points in whole:
        first = rng.integers(2, 22)
        keep = (np.arange(41) < first) | (np.arange(41) >= first + 17)
        told.append(np.where(keep[:, None], points, np.nan))
        untold.append(points[keep])
    right = [np.mean(classifier.predict(x) == np.array(truth)) for x in (whole, told, untold)]
    assert right[0] == 1.0 and right[1] > 0.8 and right[1] > right[2]


def test_what_was_hardly_seen_is_rejected():
    rng = np.random.default_rng(3)
    y, X = zip(*_letters(rng, 16), strict=True)
    classifier = GestureClassifier("combined", discriminative=False).fit(X, y)
    hardly = X[0].copy()
    hardly[3:-2] = np.nan
    assert classifier.recognise([hardly])[2].all() and not classifier.recognise([X[0]])[2].any()


@pytest.mark.parametrize(("gap", "movements"), [(0.8, 1), (1.4, 2)])
def test_hands_that_vanish_for_a_moment_while_they_move_are_still_in_the_same_movement(gap, movements):
    times = np.arange(0.0, 5.0, 0.04)
    points = np.column_stack([np.clip(2.0 * (times - 1.0), 0.0, 6.0), np.zeros(len(times))])
    hidden = (times > 2.0) & (times < 2.0 + gap)
    found = segment(times[~hidden], points[~hidden])
    assert len(found) <= movements
    assert (found[0].times[-1] - found[0].times[0] > 2.7) == (movements == 1)


def test_a_trajectory_keeps_what_it_says_of_gaps_when_it_is_cleaned():
    points = np.arange(10.0)[:, None] * [1.0, 2.0]
    lost = np.arange(10) == 4
    points[7] = np.nan
    cleaned = clean(Trajectory(points, np.arange(10) * 0.04, lost))
    assert np.flatnonzero(cleaned.lost).tolist() == [4, 7]
