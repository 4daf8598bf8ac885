"""Discriminative training of HMMs: maximum mutual information over the best paths.

Maximum likelihood makes each model explain its own gesture; what counts is that it explains it better than the other models do.
Starting from the trained bank, the weights of the log densities (linear in the observation, its neighbours in time and its
squares) follow the gradient of the log posterior of the right gesture, on the given trajectories and on distorted copies of
them. The chains, their transitions and the Viterbi recursion (eq. 12-14) stay. (Bahl et al. 1986; Gunawardana et al. 2005,
for the unconstrained form.)
"""

from dataclasses import dataclass

import numpy as np

from vipr.systems.gestures.hmm import HmmBank

OFFSETS = (-2, 2)  # neighbours whose observation a state sees as well, in points


@dataclass(frozen=True)
class MmiSpec:
    """How to follow the gradient (Adam, step falling linearly to zero)."""

    updates: int = 500
    epochs: int = 60  # most passes over the sequences, which limits the updates on small sets
    batch: int = 256
    step: float = 0.015
    pull: float = 1e-3  # towards the maximum-likelihood weights
    temper: float = 0.05  # factor on the log likelihoods, whose points are far from independent
    seed: int = 0


@dataclass(frozen=True, eq=False)
class SharpBank:
    """M models of S states whose tempered log densities are linear in ``observe(x)``, for M models of given classes."""

    weights: np.ndarray  # (M, S, F) float32
    mean: np.ndarray  # (F,) of observe(x)
    scale: np.ndarray  # (F,)
    stay: np.ndarray  # (M, S), tempered
    leave: np.ndarray  # (M, S)
    classes: np.ndarray  # (M,) class of each model

    def log_posterior(self, x: np.ndarray) -> np.ndarray:
        """(N, C) log probability of each class, of observations x (N, T, D)."""
        out = [self._log_posterior(x[a : a + 512]) for a in range(0, len(x), 512)]
        return np.concatenate(out) if out else np.zeros((0, self.classes.max() + 1))

    def standardise(self, phi: np.ndarray) -> np.ndarray:
        """``observe(x)`` for the weights; zero of a point that is missing, so that it tells no state from another."""
        phi = (phi - self.mean) / self.scale
        return np.nan_to_num(phi, copy=False, nan=0.0)

    def _log_posterior(self, x):
        phi = np.swapaxes(self.standardise(observe(x)), 0, 1)
        log_b = _emissions(self.weights, phi.reshape(-1, phi.shape[-1]), *phi.shape[:2])
        final, _ = _viterbi(log_b, self.stay, self.leave, False)
        return _by_class(final.max(axis=1), self.classes)


def observe(x: np.ndarray) -> np.ndarray:
    """(N, T, F) of observations (N, T, D): squares, values, neighbours' values, one.

    NaN of a point that is missing; the value itself stands for neighbours that are.
    """
    t = np.arange(x.shape[1])
    around = [x[:, np.clip(t + o, 0, len(t) - 1)] for o in OFFSETS]
    missing = np.isnan(x[..., :1])
    if missing.any():
        around = [np.where(np.isnan(a), x, a) for a in around]
    return np.concatenate([x * x, x, *around, np.where(missing, np.nan, 1.0)], axis=-1).astype(np.float32)


def _emissions(weights, flat, T, N):
    """(T, N, S, M) of standardised observations (T N, F) and weights (M, S, F)."""
    M, S, F = weights.shape
    return (flat @ np.swapaxes(weights, 0, 1).reshape(S * M, F).T).reshape(T, N, S, M)


def _viterbi(log_b, stay, leave, backpointers: bool):
    """Last scores (N, S, M) and, if wanted, where each was reached by leaving the state before (T, N, S, M); transitions (M, S)."""
    came = np.zeros(log_b.shape, bool) if backpointers else None
    delta = np.full(log_b.shape[1:], -1e30, np.float32)
    delta[:, 0] = log_b[0, :, 0]
    moved = np.empty_like(delta[:, 1:])
    stay, into = stay.T.copy(), leave.T[:-1].copy()
    for t in range(1, len(log_b)):
        np.add(delta[:, :-1], into, out=moved)
        delta += stay
        if backpointers:
            np.greater(moved, delta[:, 1:], out=came[t, :, 1:])
        np.maximum(delta[:, 1:], moved, out=delta[:, 1:])
        delta += log_b[t]
    return delta, came


def _by_class(scores, classes):
    """Log posteriors (N, C) of model scores (N, M); models are sorted by class."""
    scores = scores.astype(float)
    scores -= scores.max(axis=1, keepdims=True)
    starts = np.flatnonzero(np.r_[True, np.diff(classes) > 0])
    total = np.log(np.maximum(np.add.reduceat(np.exp(scores), starts, axis=1), 1e-300))
    return total - np.log(np.exp(total).sum(axis=1, keepdims=True))


def from_likelihood(bank: HmmBank, x: np.ndarray, classes: np.ndarray, temper: float) -> SharpBank:
    """The bank's models (one component, diagonal part of its covariances) in the linear form; x (N, T, D) standardises it."""
    M, S, _, d = bank.shape
    F = (phi := observe(x)).shape[-1]
    phi = phi.reshape(-1, F)
    phi = phi[~np.isnan(phi[:, -1])]
    scale = np.maximum(phi.std(axis=0), 1e-4).astype(np.float32)
    mean = phi.mean(axis=0)
    scale[-1], mean[-1] = 1.0, 0.0
    means, variances = bank.means[:, :, 0], np.einsum("msii->msi", bank.covariances[:, :, 0])
    weights = np.zeros((M, S, F))
    weights[..., :d] = -0.5 / variances
    weights[..., d : 2 * d] = means / variances
    weights[..., -1] = -0.5 * (means**2 / variances + np.log(2.0 * np.pi * variances)).sum(axis=-1)
    weights *= temper
    weights[..., -1] += weights @ mean
    return SharpBank(
        (weights * scale).astype(np.float32), mean, scale, _finite(temper * bank.stay), _finite(temper * bank.leave), np.asarray(classes)
    )  # fmt: skip


def _finite(log_probability):
    return np.maximum(log_probability, -1e30).astype(np.float32)


def sharpen(bank: SharpBank, draw, labels: np.ndarray, spec: MmiSpec, tick=lambda: None) -> SharpBank:
    """Follow the gradient of the mean log posterior of ``labels`` (N,); ``draw(indices, rng)`` gives observations (n, T, D).

    ``tick()`` is called once an update.
    """
    rng = np.random.default_rng(spec.seed)
    N, batch = len(labels), min(spec.batch, len(labels))
    updates = min(spec.updates, spec.epochs * -(-N // batch))
    start, W = bank.weights, bank.weights.copy()
    first, second = np.zeros_like(W), np.zeros_like(W)
    order = np.zeros(0, int)
    for n in range(1, updates + 1):
        if len(order) < batch:
            order = np.r_[order, rng.permutation(N)]
        chosen, order = order[:batch], order[batch:]
        gradient = _gradient(bank, W, bank.standardise(observe(draw(chosen, rng))), labels[chosen])
        gradient += spec.pull * (W - start)
        first += 0.1 * (gradient - first)
        second += 0.01 * (gradient**2 - second)
        step = spec.step * (1.0 - (n - 1) / updates)
        W -= step * (first / (1.0 - 0.9**n)) / (np.sqrt(second / (1.0 - 0.99**n)) + 1e-6)
        tick()
    return SharpBank(W, bank.mean, bank.scale, bank.stay, bank.leave, bank.classes)


def _gradient(bank, W, phi, labels):
    """Of the mean negative log posterior with respect to W (M, S, F), through the best path of each model that matters."""
    M, S, F = W.shape
    flat = np.swapaxes(phi, 0, 1).reshape(-1, F)
    log_b = _emissions(W, flat, phi.shape[1], len(phi))
    final, came = _viterbi(log_b, bank.stay, bank.leave, True)
    scores = final.max(axis=1)
    posterior = np.exp(scores - scores.max(axis=1, keepdims=True))
    posterior /= posterior.sum(axis=1, keepdims=True)
    right = posterior * (bank.classes == labels[:, None])
    excess = posterior - right / np.maximum(right.sum(axis=1, keepdims=True), 1e-12)
    n, m = np.nonzero(np.abs(excess) > 1e-3)
    state, amount = final[n, :, m].argmax(axis=-1), excess[n, m] / len(phi)
    share = log_b  # the memory of the densities, no longer needed
    share[...] = 0.0
    for t in range(len(share) - 1, -1, -1):
        share[t, n, state, m] = amount
        state = state - came[t, n, state, m]
    return np.swapaxes((share.reshape(-1, S * M).T @ flat).reshape(S, M, F), 0, 1)
