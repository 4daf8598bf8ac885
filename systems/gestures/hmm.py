"""Continuous left-right hidden Markov models, all models of a bank and all sequences of a batch at once.

A bank holds M models of at most S states. Every trajectory starts in the first state and each state may be kept or left for the
next one (paper, eq. 10); a state's observations are Gaussian (eq. 11) or a mixture of K Gaussians. The log density of a Gaussian
is linear in ``(x x', x, 1)``, so one matrix product gives the density of every point in every state of every model. The only
Python loop runs over time.

A point of which nothing is known is NaN. Shapes: N sequences padded to T points of d features (``x`` (N, T, d), ``lengths``
(N,)); M models; S states; K components.
Log probabilities are natural logarithms of densities in the unit of the features.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from vipr.systems.errors import InputError

LOG_2PI = float(np.log(2.0 * np.pi))
COVARIANCES = ("full", "diag", "tied")
AT_ONCE = 2**21  # densities that are held in memory while scoring


@dataclass(frozen=True, eq=False)
class HmmBank:
    """M left-right models; a model with fewer than S states has states that cannot be reached at its end.

    ``stay`` (M, S) and ``leave`` (M, S) are log transition probabilities of i -> i and i -> i + 1. The covariance of every component is
    held as a full matrix, whatever it was estimated as.
    """

    means: np.ndarray  # (M, S, K, d)
    covariances: np.ndarray  # (M, S, K, d, d)
    log_weights: np.ndarray  # (M, S, K)
    stay: np.ndarray  # (M, S)
    leave: np.ndarray  # (M, S); -inf in the last state
    states: np.ndarray  # (M,) number of states in use

    @property
    def shape(self) -> tuple[int, int, int, int]:
        """(M, S, K, d)."""
        return self.means.shape

    def natural(self) -> np.ndarray:
        """(M, S, K, F) weights whose product with ``quadratic(x)`` (F) is the log density of each component, its weight included."""
        d = self.means.shape[-1]
        precision = np.linalg.inv(self.covariances)
        precision = 0.5 * (precision + np.swapaxes(precision, -1, -2))
        linear = np.einsum("mskij,mskj->mski", precision, self.means)
        _, log_det = np.linalg.slogdet(self.covariances)
        constant = -0.5 * (np.einsum("mski,mski->msk", linear, self.means) + log_det + d * LOG_2PI) + self.log_weights
        rows, columns = np.triu_indices(d)
        scale = np.where(rows == columns, -0.5, -1.0)
        return np.concatenate([precision[..., rows, columns] * scale, linear, constant[..., None]], axis=-1)

    @cached_property
    def projection(self) -> np.ndarray:
        """(F, S M K): ``natural()`` as the matrix that ``emissions`` multiplies by."""
        M, S, K, _ = self.shape
        return np.swapaxes(self.natural(), 0, 1).reshape(S * M * K, -1).T.copy()

    def __getitem__(self, chosen) -> "HmmBank":
        """The bank of the chosen models (slice, indices or mask)."""
        return HmmBank(*(np.asarray(getattr(self, f))[chosen] for f in self.__dataclass_fields__))


def quadratic(x: np.ndarray) -> np.ndarray:
    """``(x_i x_j for i <= j, x, 1)`` of each point: (..., d) gives (..., F), F = d (d + 1) / 2 + d + 1.

    Zero of a point that is missing (NaN): its log density is zero in every state, so that it is integrated out.
    """
    rows, columns = np.triu_indices(x.shape[-1])
    phi = np.concatenate([x[..., rows] * x[..., columns], x, np.ones_like(x[..., :1])], axis=-1)
    phi[np.isnan(x).any(axis=-1)] = 0.0
    return phi


def pad(sequences) -> tuple[np.ndarray, np.ndarray]:
    """(N, T, d) array, zero behind each sequence's end, and lengths (N,), of a list of (T_n, d) arrays."""
    lengths = np.array([len(s) for s in sequences], int)
    if len(lengths) == 0 or lengths.min() < 1:
        raise InputError("hmm: every sequence needs at least one point, got an empty one")
    if lengths.min() == lengths.max():
        return np.array(sequences, float), lengths
    x = np.zeros((len(sequences), lengths.max(), np.shape(sequences[0])[1]))
    for row, s in zip(x, sequences, strict=True):
        row[: len(s)] = s
    return x, lengths


def emissions(bank: HmmBank, x: np.ndarray) -> np.ndarray:
    """Log density of every point in every state of every model: x (N, T, d) gives (T, N, S, M)."""
    M, S, K, _ = bank.shape
    phi = quadratic(np.swapaxes(x, 0, 1))
    log_b = (phi.reshape(-1, phi.shape[-1]) @ bank.projection).reshape(*phi.shape[:2], S, M, K)
    return mixed(log_b, phi)


def mixed(by_component: np.ndarray, phi: np.ndarray) -> np.ndarray:
    """Log densities (A, B, ...) of mixtures (A, B, ..., K); zero for points that are missing in ``phi`` (A, B, F)."""
    if by_component.shape[-1] == 1:
        return by_component[..., 0]
    log_b = log_sum(by_component)
    log_b[phi[..., -1] == 0.0] = 0.0
    return log_b


def log_sum(a: np.ndarray) -> np.ndarray:
    """log sum exp over the last axis; -inf where all are."""
    top = a.max(axis=-1, keepdims=True)
    top = np.where(np.isfinite(top), top, 0.0)
    with np.errstate(divide="ignore"):
        return np.log(np.exp(a - top).sum(axis=-1)) + top[..., 0]


def forward(log_b: np.ndarray, stay: np.ndarray, leave: np.ndarray) -> np.ndarray:
    """Forward log probabilities (eq. 20) of N left-right chains: log_b (T, S, N), transitions (S, N); returns (T, S, N)."""
    alpha = np.full_like(log_b, -np.inf)
    alpha[0, 0] = log_b[0, 0]
    for t in range(1, len(log_b)):
        now = alpha[t - 1] + stay
        np.logaddexp(now[1:], alpha[t - 1, :-1] + leave[:-1], out=now[1:])
        np.add(now, log_b[t], out=alpha[t])
    return alpha


def backward(log_b: np.ndarray, stay: np.ndarray, leave: np.ndarray, lengths: np.ndarray) -> np.ndarray:
    """Backward log probabilities (eq. 21): log_b (T, S, N), zero from each sequence's last point on."""
    beta = np.zeros_like(log_b)
    for t in range(len(log_b) - 2, -1, -1):
        after = beta[t + 1] + log_b[t + 1]
        now = after + stay
        np.logaddexp(now[:-1], after[1:] + leave[:-1], out=now[:-1])
        beta[t] = np.where(t >= lengths - 1, 0.0, now)
    return beta


def best_path(
    log_b: np.ndarray, stay: np.ndarray, leave: np.ndarray, lengths: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Viterbi (eq. 12-14) of N left-right chains: log_b (T, S, N) gives the best log probability (N,) and states (T, N).

    Behind a sequence's end its last state is repeated.
    """
    T, S, N = log_b.shape
    came = np.zeros((T, S, N), bool)
    delta = np.full((S, N), -np.inf)
    delta[0] = log_b[0, 0]
    final = delta.copy()
    for t in range(1, T):
        now = delta + stay
        moved = delta[:-1] + leave[:-1]
        np.greater(moved, now[1:], out=came[t, 1:])
        np.maximum(now[1:], moved, out=now[1:])
        delta = now + log_b[t]
        np.copyto(final, delta, where=t < lengths)
    path = np.empty((T, N), int)
    state, n = final.argmax(axis=0), np.arange(N)
    for t in range(T - 1, -1, -1):
        path[t] = state
        state = state - (came[t, state, n] & (t < lengths))
    return final.max(axis=0), path


def score(bank: HmmBank, x: np.ndarray, lengths: np.ndarray | None = None, method: str = "forward") -> np.ndarray:
    """log P(O | model) of every sequence under every model, (N, M): summed over paths ("forward") or of the best one ("viterbi")."""
    if method not in ("forward", "viterbi"):
        raise InputError(f"hmm: method is forward or viterbi, got {method!r}")
    x = np.asarray(x, float)
    if x.ndim != 3 or x.shape[-1] != bank.shape[-1]:
        raise InputError(f"hmm: sequences must be (N, T, {bank.shape[-1]}), got {x.shape}")
    step = max(1, AT_ONCE // (x.shape[1] * int(np.prod(bank.shape[:3]))))
    parts = [slice(a, a + step) for a in range(0, len(x), step)]
    scores = [_score(bank, x[p], None if lengths is None else lengths[p], method) for p in parts]
    return np.concatenate(scores) if scores else np.zeros((0, bank.shape[0]))


def _score(bank, x, lengths, method):
    together = np.logaddexp if method == "forward" else np.maximum
    log_b, stay, into = emissions(bank, x), bank.stay.T.copy(), bank.leave.T[:-1].copy()
    now = np.full(log_b.shape[1:], -np.inf)
    now[:, 0] = log_b[0, :, 0]
    ragged = lengths is not None and lengths.min() < len(log_b)
    final = now.copy() if ragged else now
    moved = np.empty_like(now[:, 1:])
    for t in range(1, len(log_b)):
        np.add(now[:, :-1], into, out=moved)
        now += stay
        together(now[:, 1:], moved, out=now[:, 1:])
        now += log_b[t]
        if ragged:
            going = t < lengths
            final[going] = now[going]
    return log_sum(np.swapaxes(final, 1, 2)) if method == "forward" else final.max(axis=1)
