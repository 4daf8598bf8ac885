"""Likelihoods against enumeration and hmmlearn; training against hmmlearn's."""

import numpy as np
import pytest

from vipr.scenarios.bench.gestures.reference import as_hmmlearn, enumerate_paths, random_bank
from vipr.systems.errors import InputError
from vipr.systems.gestures.hmm import backward, best_path, emissions, forward, pad, score
from vipr.systems.gestures.training import HmmSpec, choose_states, train


@pytest.mark.parametrize("K", [1, 2])
def test_scores_equal_enumeration_of_all_paths(rng, K):
    bank = random_bank(rng, K=K, S=3, states=[3, 2, 3])
    sequences = [rng.normal(size=(n, 2)) for n in (1, 4, 6)]
    x, lengths = pad(sequences)
    total, best = score(bank, x, lengths), score(bank, x, lengths, "viterbi")
    for n, sequence in enumerate(sequences):
        for m in range(3):
            paths = list(enumerate_paths(bank, m, sequence))
            assert total[n, m] == pytest.approx(np.log(sum(p for p, _ in paths)), abs=1e-9)
            assert best[n, m] == pytest.approx(np.log(max(p for p, _ in paths)), abs=1e-9)


def test_best_path_is_the_best_of_all_paths(rng):
    bank = random_bank(rng, M=1)
    sequences = [rng.normal(size=(n, 2)) for n in (6, 3)]
    x, lengths = pad(sequences)
    log_b = np.swapaxes(emissions(bank, x)[..., 0], 1, 2)
    transitions = np.repeat(bank.stay[:1].T, 2, 1), np.repeat(bank.leave[:1].T, 2, 1)
    value, path = best_path(log_b, *transitions, lengths)
    for n, sequence in enumerate(sequences):
        p, states = max(enumerate_paths(bank, 0, sequence))
        assert value[n] == pytest.approx(np.log(p), abs=1e-9)
        assert tuple(path[: len(sequence), n]) == states
        assert (path[len(sequence) :, n] == states[-1]).all()


def test_scores_equal_hmmlearn(rng):
    bank, x = random_bank(rng, M=4, S=5, d=3), rng.normal(size=(6, 20, 3))
    ours, best = score(bank, x), score(bank, x, method="viterbi")
    for m in range(4):
        model = as_hmmlearn(bank, m)
        for n in range(6):
            assert ours[n, m] == pytest.approx(model.score(x[n]), abs=1e-9)
            assert best[n, m] == pytest.approx(model.decode(x[n])[0], abs=1e-9)


def test_a_long_improbable_sequence_underflows_nothing(rng):
    bank = random_bank(rng)
    assert np.isfinite(score(bank, 100.0 + rng.normal(size=(2, 500, 2)))).all()


def test_forward_and_backward_agree_at_every_time(rng):
    bank, x = random_bank(rng, M=1), rng.normal(size=(1, 12, 2))
    log_b = np.swapaxes(emissions(bank, x)[..., 0], 1, 2)
    alpha = forward(log_b, bank.stay.T, bank.leave.T)
    beta = backward(log_b, bank.stay.T, bank.leave.T, np.array([12]))
    total = np.log(np.exp(alpha + beta).sum(axis=1))  # eq. 22
    assert np.ptp(total) < 1e-9


def test_baum_welch_re_estimates_as_hmmlearn_does(rng):
    sequences = [np.cumsum(rng.normal(size=(n, 2)), axis=0) for n in (20, 25, 18, 30)]
    x, lengths = pad(sequences)
    spec = HmmSpec(4, floor=0.0, segmental=0, baum_welch=0)
    start = train(x, lengths, np.zeros(4, int), spec)
    ours = train(x, lengths, np.zeros(4, int), HmmSpec(4, floor=0.0, segmental=0, baum_welch=1))
    theirs = as_hmmlearn(start, 0)
    theirs.params, theirs.n_iter, theirs.covars_prior, theirs.min_covar = "tmc", 1, 0.0, 0.0
    theirs.fit(np.concatenate(sequences), lengths)
    used = theirs.transmat_[:-1]
    np.testing.assert_allclose(np.exp(ours.stay[0, :-1]), np.diag(used), atol=1e-9)
    np.testing.assert_allclose(ours.means[0, :, 0], theirs.means_, atol=1e-9)
    np.testing.assert_allclose(ours.covariances[0, :, 0], theirs.covars_, atol=1e-8)


def test_models_trained_together_equal_models_trained_alone(rng):
    x = np.cumsum(rng.normal(size=(12, 15, 2)), axis=1)
    model, lengths = np.repeat([0, 1], 6), np.full(12, 15)
    spec = HmmSpec(3, floor=0.0, baum_welch=3, tolerance=-np.inf)
    both, alone = train(x, lengths, model, spec), train(x[:6], lengths[:6], model[:6], spec)
    np.testing.assert_allclose(both.means[0], alone.means[0], atol=1e-8)
    np.testing.assert_allclose(both.covariances[0], alone.covariances[0], atol=1e-8)


@pytest.mark.parametrize("covariance", ["full", "diag", "tied"])
@pytest.mark.parametrize("mixtures", [1, 3])
def test_every_round_of_baum_welch_raises_the_likelihood(rng, covariance, mixtures):
    x = np.cumsum(rng.normal(size=(20, 16, 2)), axis=1)
    lengths, model = np.full(20, 16), np.zeros(20, int)
    likelihood = [
        score(
            train(x, lengths, model, HmmSpec(3, mixtures, covariance, 1e-6, baum_welch=n, tolerance=-np.inf)), x
        ).sum()
        for n in (0, 1, 3, 10)
    ]
    assert (np.diff(likelihood) > -1e-6).all()
    assert likelihood[-1] > likelihood[0] + 0.1


def test_covariance_kinds_and_floors_are_kept(rng):
    x = np.cumsum(rng.normal(size=(10, 16, 2)), axis=1) @ np.diag([1.0, 0.0]) + 1e-9 * rng.normal(size=(10, 16, 2))
    lengths, model = np.full(10, 16), np.zeros(10, int)
    tied = train(x, lengths, model, HmmSpec(3, covariance="tied"))
    assert np.ptp(tied.covariances, axis=1).max() == 0.0
    diag = train(x, lengths, model, HmmSpec(3, covariance="diag"))
    assert diag.covariances[..., 0, 1].max() == 0.0
    variance = x.reshape(-1, 2).var(axis=0)
    for bank in (tied, diag, train(x, lengths, model, HmmSpec(3))):
        assert (np.linalg.eigvalsh(bank.covariances / np.sqrt(np.outer(variance, variance))) >= 0.00999).all()


def test_mixtures_find_two_ways_of_doing_one_thing(rng):
    side = np.repeat([-3.0, 3.0], 20)[:, None, None]
    x = side + rng.normal(0.0, 0.3, (40, 10, 1))
    bank = train(x, np.full(40, 10), np.zeros(40, int), HmmSpec(1, 2))
    assert sorted(np.round(bank.means[0, 0, :, 0])) == [-3.0, 3.0]


def test_one_short_example_trains_a_model_with_more_states_than_points():
    x = np.array([[[0.0, 0.0], [1.0, 2.0], [2.0, 1.0]]])
    bank = train(x, np.array([3]), np.array([0]), HmmSpec(6))
    assert np.isfinite(bank.means).all()
    assert np.isfinite(score(bank, x)).all()


def test_states_are_chosen_per_gesture(rng):
    t = np.linspace(0, 1, 32)
    simple = np.zeros((20, 32, 1)) + rng.normal(0, 0.05, (20, 32, 1))
    stairs = np.floor(t * 10)[None, :, None] + rng.normal(0, 0.05, (20, 32, 1))
    x, model = np.concatenate([simple, stairs]), np.repeat([0, 1], 20)
    few, many = choose_states(x, np.full(40, 32), model, HmmSpec(4), candidates=(2, 4, 10), margin=0.05)
    assert few == 2
    assert many == 10


def test_bad_requests_are_told_apart(rng):
    with pytest.raises(InputError, match="covariance is one of full, diag, tied, got 'round'"):
        HmmSpec(covariance="round")
    with pytest.raises(InputError, match="method is forward or viterbi, got 'sum'"):
        score(random_bank(rng), np.zeros((1, 3, 2)), method="sum")
    with pytest.raises(InputError, match=r"must be \(N, T, 2\), got \(1, 3, 5\)"):
        score(random_bank(rng), np.zeros((1, 3, 5)))
    with pytest.raises(InputError, match="at least one point"):
        pad([np.zeros((0, 2))])


def test_mixture_scores_equal_hmmlearns(rng):
    bank, x = random_bank(rng, M=1, S=3, K=2), rng.normal(size=(8, 2))
    model = as_hmmlearn(bank, 0, mixtures=True)
    assert score(bank, x[None])[0, 0] == pytest.approx(model.score(x), abs=1e-9)


@pytest.fixture
def rng():
    return np.random.default_rng(5)
