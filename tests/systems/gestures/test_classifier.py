"""The classifier's conventions, its rejection, and bad input."""

import numpy as np
import pytest
from drawn_shapes import drawings, quick
from sklearn.base import clone
from sklearn.model_selection import cross_val_score
from sklearn.pipeline import make_pipeline
from sklearn.preprocessing import FunctionTransformer

from vipr.systems.errors import InputError
from vipr.systems.gestures.trajectories import Stream, Trajectory


@pytest.fixture(scope="module")
def trained():
    return quick().fit(*drawings(np.random.default_rng(0)))


def test_scikit_learn_validates_it_in_a_pipeline():
    X, y = drawings(np.random.default_rng(1), each=6)
    mirror = FunctionTransformer(lambda X: [x * [-1.0, 1.0] for x in X])
    assert cross_val_score(make_pipeline(mirror, quick()), X, y, cv=3).mean() > 0.9
    assert clone(quick(states=5)).get_params()["states"] == 5


@pytest.mark.parametrize("streams", ["position", "velocity", "combined", "default"])
def test_every_kind_of_model_names_shapes(streams):
    X, y = drawings(np.random.default_rng(2))
    plain = streams != "default"
    classifier = quick(streams=streams, discriminative=not plain, covariance="full", states=4).fit(X, y)
    assert classifier.score(*drawings(np.random.default_rng(3))) > 0.9


def test_probabilities_sum_to_one_and_lead_to_the_prediction(trained):
    X, _ = drawings(np.random.default_rng(4), each=3)
    probability = trained.predict_proba(X)
    np.testing.assert_allclose(probability.sum(axis=1), 1.0, atol=1e-9)
    assert (trained.classes_[probability.argmax(axis=1)] == trained.predict(X)).all()


def test_position_and_size_change_nothing(trained):
    X, _ = drawings(np.random.default_rng(5), each=2)
    np.testing.assert_allclose(trained.predict_proba(X), trained.predict_proba([7.0 * x + 300.0 for x in X]), atol=1e-6)


def test_sharpening_raises_the_log_posterior():
    rng = np.random.default_rng(6)
    X, y = drawings(rng, each=10, noise=0.12)
    right = np.searchsorted(np.unique(y), y)
    pick = np.arange(len(y))
    before = quick(updates=1, distortion=0.0).fit(X, y).predict_log_proba(X)[pick, right].mean()
    after = quick(updates=60, distortion=0.0).fit(X, y).predict_log_proba(X)[pick, right].mean()
    assert after > before


def test_two_ways_of_drawing_one_symbol_get_two_models():
    rng = np.random.default_rng(7)
    X, y = drawings(rng)
    X = [x[::-1] if label == "circle" and n % 2 else x for n, (x, label) in enumerate(zip(X, y, strict=True))]
    classes = quick(backwards=0.0).fit(X, y).streams_[0].classes
    assert np.bincount(classes).tolist()[0] >= 2
    assert np.bincount(classes).tolist()[2] == 1


def test_priors_follow_training_or_are_equal():
    X, y = drawings(np.random.default_rng(8), each=4)
    for few in ("circle",):
        keep = [n for n in range(len(y)) if y[n] != few or n < 1]
        X, y = [X[n] for n in keep], y[keep]
    unusable = [np.zeros((0, 2))]
    assert quick().fit(X, y).predict_proba(unusable)[0].min() == pytest.approx(1 / len(y))
    np.testing.assert_allclose(quick(priors="uniform").fit(X, y).predict_proba(unusable), 0.25)


BAD = {
    "empty": np.zeros((0, 2)),
    "one point": np.ones((1, 2)),
    "constant": np.ones((30, 2)),
    "nan": np.full((30, 2), np.nan),
    "mostly nan": np.vstack([np.full((30, 2), np.nan), [[1.0, 2.0]]]),
    "infinite": np.full((30, 2), np.inf),
    "flat list": np.arange(5.0),
    "backward in time": Trajectory(np.arange(6.0).reshape(3, 2), np.array([3.0, 2.0, 1.0])),
    "one instant": Trajectory(np.arange(6.0).reshape(3, 2), np.zeros(3)),
    "times missing": Trajectory(np.arange(6.0).reshape(3, 2), np.zeros(2)),
}


@pytest.mark.parametrize("name", BAD)
def test_what_is_no_trajectory_is_rejected_and_disturbs_no_other(trained, name):
    X, _ = drawings(np.random.default_rng(9), each=1)
    label, probability, rejected = trained.recognise([*X, BAD[name]])
    alone = trained.recognise(X)
    assert rejected[-1] and probability[-1] == 0.0
    assert (label[:-1] == alone[0]).all() and (rejected[:-1] == alone[2]).all()


def test_what_is_no_trajectory_is_left_out_of_training():
    X, y = drawings(np.random.default_rng(10), each=3)
    classifier = quick().fit([*X, BAD["nan"], BAD["empty"]], [*y, "ess", "line"])
    assert classifier.skipped_.tolist() == [12, 13]
    with pytest.raises(InputError, match="none of the 2 trajectories has two different finite positions"):
        quick().fit([BAD["nan"], BAD["empty"]], ["a", "b"])


def test_repeated_times_and_single_gaps_are_bridged(trained):
    X, _ = drawings(np.random.default_rng(11), each=1)
    times = np.arange(len(X[0])) * 0.04
    stuttering = Trajectory(np.repeat(X[0], 2, axis=0), np.repeat(times, 2))
    holed = X[0].copy()
    holed[7] = np.nan
    expected = trained.predict_proba([X[0]])
    np.testing.assert_allclose(trained.predict_proba([stuttering]), expected, atol=1e-9)
    assert trained.predict([holed]) == trained.predict([X[0]])


def test_one_example_a_class_is_enough_to_run():
    X, y = drawings(np.random.default_rng(12), each=1)
    assert quick(updates=20).fit(X, y).score(*drawings(np.random.default_rng(13))) > 0.9


def test_one_class_alone_is_always_named():
    X, y = drawings(np.random.default_rng(14), each=3)
    assert set(quick().fit(X[:3], y[:3]).predict(X)) == {"circle"}


def test_scribbles_are_rejected_and_gestures_are_not(trained):
    rng = np.random.default_rng(15)
    X, _ = drawings(rng)
    scribbles = [rng.normal(size=(40, 2)) for _ in range(40)]
    assert trained.recognise(X)[2].mean() < 0.15
    assert trained.recognise(scribbles)[2].mean() > 0.9


def test_examples_of_non_gestures_teach_rejection():
    rng = np.random.default_rng(16)
    X, y = drawings(rng)
    walks = [np.cumsum(rng.normal(size=(30, 2)), axis=0) for _ in range(40)]
    classifier = quick(garbage="none").fit([*X[:-20], *walks[:20], *X[-20:]], [*y[:-20], *["none"] * 20, *y[-20:]])
    label, _, rejected = classifier.recognise(walks[20:])
    assert rejected.mean() > 0.8
    assert "none" not in label
    assert (classifier.predict(walks[20:]) == "none").mean() > 0.8


def test_a_gesture_in_a_time_that_is_none_of_its_own_is_rejected_where_times_count():
    X, y = drawings(np.random.default_rng(24))
    paces = np.exp(np.random.default_rng(25).normal(0.0, 0.15, len(X)))
    timed = [Trajectory(x, p * np.linspace(0.0, 1.0, len(x))) for x, p in zip(X, paces, strict=True)]
    classifier = quick(timed=True).fit(timed, y)
    assert classifier.recognise(timed)[2].mean() < 0.1
    for factor in (0.3, 3.0):
        odd = [Trajectory(t.points, factor * t.times) for t in timed]
        assert classifier.recognise(odd)[2].mean() > 0.95
        assert (classifier.predict(odd) == y).mean() > 0.9


def test_the_same_stroke_is_another_gesture_in_another_time_where_times_count():
    X, _ = drawings(np.random.default_rng(26), each=24)
    paces = np.where(np.arange(len(X)) % 2, 0.5, 2.0) * np.exp(np.random.default_rng(27).normal(0.0, 0.1, len(X)))
    timed = [Trajectory(x, p * np.linspace(0.0, 1.0, len(x))) for x, p in zip(X, paces, strict=True)]
    y = np.where(paces < 1.0, "fast", "slow")
    assert quick(timed=True).fit(timed, y).score(timed, y) > 0.95


def test_what_may_be_no_gesture_is_rejected_with_less_doubt_the_more_is_allowed():
    rng = np.random.default_rng(28)
    X, y = drawings(rng)
    near = [x + 0.25 * np.cumsum(rng.normal(size=x.shape), axis=0) / np.sqrt(len(x)) for x in X]
    classifier = quick(garbage="none").fit([*X, *near], [*y, *["none"] * len(near)])
    shares = [classifier.set_params(doubt=d).recognise(X + near)[2].mean() for d in (1e-6, 0.05, 1.0)]
    assert shares[0] >= shares[1] >= shares[2] and shares[0] > shares[2]


def test_mistaken_examples_do_not_open_the_gate_for_their_like():
    rng = np.random.default_rng(29)
    X, y = drawings(rng, each=30)
    scribbles = [np.cumsum(rng.normal(size=(40, 2)), axis=0) for _ in range(40)]
    odd = rng.choice(len(y), 8, replace=False)
    classifier = quick(updates=5, false_rejection=0.05).fit([*X, *scribbles[:8]], [*y, *np.array(y)[odd]])
    assert classifier.recognise(X)[2].mean() < 0.05
    assert classifier.recognise(scribbles[8:])[2].mean() > 0.6


def test_a_symbol_begun_at_its_other_end_is_known_by_its_picture():
    X, y = drawings(np.random.default_rng(21))
    pictures = quick(streams=(Stream(("rows",)), Stream(("columns",)))).fit(X, y)
    Z, z = drawings(np.random.default_rng(22), each=4)
    assert pictures.score([x[::-1] for x in Z], z) > 0.9


def test_seed_and_data_decide_everything():
    X, y = drawings(np.random.default_rng(17), each=4)
    a, b = quick().fit(X, y), quick().fit(X, y)
    np.testing.assert_array_equal(a.predict_proba(X), b.predict_proba(X))


def test_bad_requests_say_what_is_allowed(trained):
    X, y = drawings(np.random.default_rng(18), each=1)
    with pytest.raises(InputError, match="streams is one of default"):
        quick(streams="both").fit(X, y)
    for bad, message in (
        ({"states": "many"}, "states is a number from 1 or validated, got 'many'"),
        ({"covariance": "round"}, "covariance is one of full, diag, tied, got 'round'"),
        ({"distortion": -1.0}, "distortion is not negative, got -1.0"),
        ({"priors": "none"}, "priors is observed or uniform"),
    ):
        with pytest.raises(InputError, match=message):
            quick(**bad).fit(X, y)
    with pytest.raises(InputError, match="one label a trajectory, got 4 trajectories"):
        quick().fit(X, y[:2])
    with pytest.raises(InputError, match="trained on 2 coordinates a point, got 3"):
        trained.predict([np.random.default_rng(0).normal(size=(9, 3))])
    with pytest.raises(InputError, match=r"same number of coordinates, got \[2, 3\]"):
        quick().fit([*X, np.eye(3)], [*y, "odd"])
