"""The same quantities by other ways: every path of states written out, and hmmlearn's models with the same parameters."""

import itertools
from collections.abc import Iterator

import numpy as np

from vipr.systems.errors import InputError
from vipr.systems.gestures.hmm import HmmBank


def hmmlearn():
    """The library that this one is compared with."""
    try:
        import hmmlearn.hmm
    except ImportError:
        raise InputError(
            "bench gestures: likelihoods and speed are compared with hmmlearn, which is not installed (pip install hmmlearn)"
        ) from None
    return hmmlearn.hmm


def random_bank(rng: np.random.Generator, M=3, S=4, K=1, d=2, states=None) -> HmmBank:
    """M left-right models of at most S states with parameters by chance."""
    root = rng.normal(size=(M, S, K, d, d))
    weights = rng.uniform(0.2, 1.0, (M, S, K))
    states = np.full(M, S) if states is None else np.array(states)
    keep = rng.uniform(0.3, 0.9, (M, S))
    last = np.arange(S) >= states[:, None] - 1
    with np.errstate(divide="ignore"):
        leave = np.where(last, -np.inf, np.log(1 - keep))
    return HmmBank(
        rng.normal(size=(M, S, K, d)),
        root @ np.swapaxes(root, -1, -2) + 0.3 * np.eye(d),
        np.log(weights / weights.sum(-1, keepdims=True)),
        np.where(last, 0.0, np.log(keep)),
        leave,
        states,
    )


def density(bank: HmmBank, m: int, s: int, x: np.ndarray) -> float:
    """Of a point x (d,) in state s of model m, by eq. (11)."""
    total = 0.0
    for k in range(bank.shape[2]):
        C, e = bank.covariances[m, s, k], x - bank.means[m, s, k]
        quotient = np.sqrt((2 * np.pi) ** len(e) * np.linalg.det(C))
        total += np.exp(bank.log_weights[m, s, k] - 0.5 * e @ np.linalg.inv(C) @ e) / quotient
    return total


def enumerate_paths(bank: HmmBank, m: int, x: np.ndarray) -> Iterator[tuple[float, tuple[int, ...]]]:
    """Probability of x (T, d) along every path of states of model m, and the path, by the definition."""
    for path in itertools.product(range(bank.shape[1]), repeat=len(x)):
        p = float(path[0] == 0) * density(bank, m, path[0], x[0])
        for t in range(1, len(x)):
            i, j = path[t - 1], path[t]
            p *= np.exp(bank.stay[m, i]) if j == i else np.exp(bank.leave[m, i]) if j == i + 1 else 0.0
            p *= density(bank, m, j, x[t])
        yield p, path


def as_hmmlearn(bank: HmmBank, m: int, mixtures: bool = False):
    """Model m as hmmlearn's ``GaussianHMM`` (of its first components) or ``GMMHMM``."""
    _, S, K, d = bank.shape
    if mixtures:
        model = hmmlearn().GMMHMM(S, K, covariance_type="full", init_params="", params="")
        model.means_, model.covars_, model.weights_ = bank.means[m], bank.covariances[m], np.exp(bank.log_weights[m])
        model.n_features = d
    else:
        model = hmmlearn().GaussianHMM(S, "full", init_params="", params="")
        model.means_, model.covars_ = bank.means[m, :, 0], bank.covariances[m, :, 0].reshape(S, d, d)
    A = np.diag(np.exp(bank.stay[m]))
    A[np.arange(S - 1), np.arange(1, S)] = np.exp(bank.leave[m, :-1])
    model.startprob_, model.transmat_ = np.eye(S)[0], A
    return model
