"""Training of left-right HMMs in two phases (paper, II-A.3.b): segmental initialisation, then Baum-Welch.

Every sequence belongs to one model of the bank. All models are trained together: a step runs over all sequences at once and
pools sufficient statistics per model, so that the cost does not depend on the number of models.
"""

from dataclasses import dataclass

import numpy as np

from vipr.systems.errors import InputError
from vipr.systems.gestures.hmm import COVARIANCES, HmmBank, backward, best_path, forward, log_sum, mixed, quadratic


@dataclass(frozen=True)
class HmmSpec:
    """What kind of models to train."""

    states: int = 4
    mixtures: int = 1
    covariance: str = "full"  # full | diag, one a state and component; tied: one full matrix a model
    floor: float = 1e-2  # least variance along any direction, in units of the features' overall variance
    prior: float = 0.0  # points' worth of the model's pooled within-state covariance added to each covariance
    segmental: int = 20  # most rounds of segmental initialisation
    baum_welch: int = 20  # most rounds of re-estimation
    tolerance: float = 1e-4  # stop when the log likelihood per point rises by less

    def __post_init__(self):
        if self.states < 1 or self.mixtures < 1:
            raise InputError(f"hmm: states and mixtures must be at least 1, got {self.states} and {self.mixtures}")
        if self.covariance not in COVARIANCES:
            raise InputError(f"hmm: covariance is one of {', '.join(COVARIANCES)}, got {self.covariance!r}")
        if not (self.floor >= 0 and self.prior >= 0):
            raise InputError(f"hmm: floor and prior must not be negative, got {self.floor} and {self.prior}")


class _Statistics:
    """Sums over the points of each model, state and component of (x x', x, 1), and of transitions."""

    def __init__(self, x, lengths, model, models: int):
        self.phi = quadratic(x)
        self.model, self.models, self.d = model, models, x.shape[-1]
        self.inside = np.arange(x.shape[1]) < lengths[:, None]
        order = np.argsort(model, kind="stable")
        self.order, self.present, self.starts = order, *np.unique(model[order], return_index=True)

    def pool(self, per_sequence: np.ndarray) -> np.ndarray:
        """(N, ...) summed per model: (M, ...)."""
        out = np.zeros((self.models, *per_sequence.shape[1:]))
        out[self.present] = np.add.reduceat(per_sequence[self.order], self.starts, axis=0)
        return out

    def moments(self, occupancy: np.ndarray) -> np.ndarray:
        """occupancy (N, T, S, K) gives (M, S, K, F)."""
        N, T, S, K = occupancy.shape
        sums = np.swapaxes(occupancy.reshape(N, T, S * K), 1, 2) @ self.phi
        return self.pool(sums).reshape(self.models, S, K, -1)


def uniform_path(lengths: np.ndarray, states: np.ndarray, T: int) -> np.ndarray:
    """(N, T) state of each point when every sequence is cut into equal parts; the last state behind its end."""
    t = np.arange(T)
    return np.minimum(t * states[:, None] // lengths[:, None], states[:, None] - 1)


def train(
    x: np.ndarray, lengths: np.ndarray, model: np.ndarray, spec: HmmSpec, states: np.ndarray | None = None
) -> HmmBank:
    """Train one HMM per model number: x (N, T, d) padded, lengths (N,), model (N,) in 0..M-1, each with at least one sequence.

    Points that are missing are NaN. states (M,) overrides ``spec.states`` per model.
    """
    models = int(model.max()) + 1
    states = np.full(models, spec.states) if states is None else np.asarray(states, int)
    if len(np.unique(model)) != models or len(states) != models:
        raise InputError(f"hmm: each of the {models} models needs at least one sequence and a number of states")
    x = np.where(np.arange(x.shape[1])[:, None] < lengths[:, None, None], x, 0.0)
    known = max(lengths.sum() - np.isnan(x).any(axis=2).sum(), 1)
    centre = np.nansum(x, axis=(0, 1)) / known
    x = np.where(np.arange(x.shape[1])[:, None] < lengths[:, None, None], x - centre, 0.0)  # else x x' - mu mu' cancels
    scale = np.maximum(np.nansum(x**2, axis=(0, 1)) / known, 1e-12)
    statistics = _Statistics(x, lengths, model, models)
    bank = _segmental(statistics, lengths, scale, spec, states)
    bank = _baum_welch(bank, statistics, lengths, scale, spec)
    return HmmBank(bank.means + centre, bank.covariances, bank.log_weights, bank.stay, bank.leave, bank.states)


def _segmental(statistics, lengths, scale, spec, states) -> HmmBank:
    """Means, covariances and transitions by counting along paths (eq. 15-17), paths by Viterbi, until they stay."""
    _N, T = statistics.inside.shape
    S, one = int(states.max()), HmmSpec(spec.states, 1, spec.covariance, spec.floor, spec.prior)
    path, bank, mixtures = uniform_path(lengths, states[statistics.model], T), None, 1
    for _ in range(spec.segmental + 1):
        occupancy = ((path[..., None] == np.arange(S)) & statistics.inside[..., None])[..., None].astype(float)
        bank = estimate(statistics.moments(occupancy), _path_transitions(statistics, path, S), states, scale, one, bank)
        log_b = _own_emissions(bank, statistics)[0]
        new = best_path(log_b, *_own_transitions(bank, statistics), lengths)[1].T
        if np.array_equal(new, path):
            break
        path = new
    while mixtures < spec.mixtures:
        mixtures = min(2 * mixtures, spec.mixtures)
        bank = _baum_welch(_split(bank, mixtures), statistics, lengths, scale, spec, rounds=4)
    return bank


def _path_transitions(statistics, path, S):
    """Counts (M, S, 2) of staying in and leaving each state along the paths (N, T)."""
    both = statistics.inside[:, 1:]
    left = path[:, 1:] > path[:, :-1]
    here = path[:, :-1, None] == np.arange(S)
    counts = np.stack([(here & (both & ~left)[..., None]).sum(1), (here & (both & left)[..., None]).sum(1)], axis=-1)
    return statistics.pool(counts.astype(float))


def _split(bank: HmmBank, mixtures: int) -> HmmBank:
    """Split the heaviest components along their longest axis, half a standard deviation to either side."""
    extra = mixtures - bank.shape[2]
    chosen = np.argsort(-bank.log_weights, axis=-1, kind="stable")[..., :extra]
    values, vectors = np.linalg.eigh(bank.covariances)
    step = 0.5 * np.sqrt(values[..., -1:]) * vectors[..., -1]
    means, weights = bank.means.copy(), bank.log_weights.copy()
    index = chosen[..., None]
    new_means = np.take_along_axis(means + step, index, axis=2)
    np.put_along_axis(means, index, np.take_along_axis(means - step, index, axis=2), axis=2)
    new_weights = np.take_along_axis(weights, chosen, axis=2) - np.log(2.0)
    np.put_along_axis(weights, chosen, new_weights, axis=2)
    return HmmBank(
        np.concatenate([means, new_means], axis=2),
        np.concatenate([bank.covariances, np.take_along_axis(bank.covariances, chosen[..., None, None], axis=2)], axis=2),
        np.concatenate([weights, new_weights], axis=2),
        bank.stay, bank.leave, bank.states,
    )  # fmt: skip


def _own_emissions(bank, statistics):
    """Log densities (T, S, N) of each sequence under its own model, and by component (N, T, S, K)."""
    M, S, K, _ = bank.shape
    weights = bank.natural().reshape(M, S * K, -1)
    by_component = (statistics.phi @ np.swapaxes(weights[statistics.model], 1, 2)).reshape(
        *statistics.inside.shape, S, K
    )
    log_b = mixed(by_component, statistics.phi)
    return np.ascontiguousarray(np.moveaxis(log_b, 0, 2)), by_component


def _own_transitions(bank, statistics):
    """Log probabilities (S, N) of staying and leaving."""
    return bank.stay[statistics.model].T.copy(), bank.leave[statistics.model].T.copy()


def _baum_welch(bank, statistics, lengths, scale, spec, rounds=None) -> HmmBank:
    """Re-estimation (eq. 18-24) until the likelihood stays."""
    last = -np.inf
    for _ in range(spec.baum_welch if rounds is None else rounds):
        moments, transitions, log_likelihood = expectation(bank, statistics, lengths)
        bank = estimate(moments, transitions, bank.states, scale, spec, bank)
        now = log_likelihood.sum() / lengths.sum()
        if now - last < spec.tolerance:
            break
        last = now
    return bank


def expectation(bank, statistics, lengths):
    """Moments (M, S, K, F), transition counts (M, S, 2) and log likelihoods (N,) of all sequences under their models."""
    log_b, by_component = _own_emissions(bank, statistics)
    stay, leave = _own_transitions(bank, statistics)
    alpha, beta = forward(log_b, stay, leave), backward(log_b, stay, leave, lengths)
    log_likelihood = log_sum(alpha[lengths - 1, :, np.arange(len(lengths))])
    gamma = np.moveaxis(np.exp(alpha + beta - log_likelihood), 2, 0) * statistics.inside[..., None]
    occupancy = gamma[..., None]
    if bank.shape[2] > 1:
        occupancy = occupancy * np.exp(by_component - np.moveaxis(log_b, 2, 0)[..., None])
    after = beta[1:] + log_b[1:]
    both = statistics.inside[:, 1:].T[:, None]
    start = alpha[:-1] - log_likelihood
    kept = (np.exp(start + stay + after) * both).sum(axis=0)
    left = np.zeros_like(kept)
    left[:-1] = (np.exp(start[:, :-1] + leave[:-1] + after[:, 1:]) * both).sum(axis=0)
    return statistics.moments(occupancy), statistics.pool(np.stack([kept.T, left.T], axis=-1)), log_likelihood


def estimate(moments, transitions, states, scale, spec: HmmSpec, before: HmmBank | None) -> HmmBank:
    """Parameters of pooled statistics; where nothing was observed, those of the bank before."""
    M, S, K, F = moments.shape
    d = len(scale)
    rows, columns = np.triu_indices(d)
    count = moments[..., -1]
    safe = np.maximum(count, 1e-10)
    means = moments[..., F - 1 - d : F - 1] / safe[..., None]
    second = np.empty((M, S, K, d, d))
    second[..., rows, columns] = second[..., columns, rows] = moments[..., : len(rows)]
    scatter = second - safe[..., None, None] * means[..., :, None] * means[..., None, :]
    pooled = scatter.sum(axis=(1, 2)) / np.maximum(count.sum(axis=(1, 2)), 1e-10)[:, None, None]
    if spec.covariance == "tied":
        covariances = np.broadcast_to(pooled[:, None, None], second.shape).copy()
    else:
        covariances = (scatter + spec.prior * pooled[:, None, None]) / (safe + spec.prior)[..., None, None]
    if spec.covariance == "diag":
        covariances = covariances * np.eye(d)
    covariances = _floored(covariances, spec.floor * scale)
    weights = safe / safe.sum(axis=-1, keepdims=True)
    empty = count < 1e-8
    if before is not None:
        means = np.where(empty[..., None], before.means, means)
        covariances = np.where(empty[..., None, None], before.covariances, covariances)
    elif empty.any():
        means, covariances = _neighbours(means, covariances, empty)
    stay, leave = _transitions(transitions, states)
    return HmmBank(means, covariances, np.log(weights), stay, leave, states)


def _floored(covariances, least):
    """Covariances whose variance is at least ``least`` (d,) along every direction: eigenvalues clipped in units of it."""
    root = np.sqrt(np.maximum(least, 1e-300))
    values, vectors = np.linalg.eigh(covariances / (root[:, None] * root))
    clipped = (vectors * np.maximum(values, 1.0)[..., None, :]) @ np.swapaxes(vectors, -1, -2)
    low = (values[..., 0] < 1.0)[..., None, None]
    return np.where(low, clipped * (root[:, None] * root), covariances)


def _neighbours(means, covariances, empty):
    """States that no point reached (sequences shorter than the chain) take the parameters of the last state reached."""
    for s in range(1, means.shape[1]):
        hole = empty[:, s]
        means[:, s] = np.where(hole[..., None], means[:, s - 1], means[:, s])
        covariances[:, s] = np.where(hole[..., None, None], covariances[:, s - 1], covariances[:, s])
    return means, covariances


def _transitions(counts, states):
    """Log probabilities of staying and leaving; unobserved states take even odds, the last one is never left."""
    total = counts.sum(axis=-1, keepdims=True)
    share = np.where(total > 1e-10, counts / np.maximum(total, 1e-10), 0.5)
    share = np.clip(share, 1e-10, 1.0)
    last = np.arange(counts.shape[1]) >= states[:, None] - 1
    with np.errstate(divide="ignore"):
        return np.where(last, 0.0, np.log(share[..., 0])), np.where(last, -np.inf, np.log(share[..., 1]))


def choose_states(x, lengths, model, spec: HmmSpec, candidates=(4, 6, 8, 10, 12), margin: float = 0.01) -> np.ndarray:
    """(M,) number of states of each model, by the log likelihood of held-out sequences.

    Two halves take turns; the fewest states within ``margin`` nats a point of the best are taken. A model with fewer than four
    sequences keeps ``spec.states``.
    """
    models = int(model.max()) + 1
    half = np.zeros(len(model), int)
    for m in range(models):
        members = np.flatnonzero(model == m)
        half[members] = np.arange(len(members)) % 2
    enough = np.bincount(model, minlength=models) >= 4
    kept = enough[model]
    if not kept.any():
        return np.full(models, spec.states)
    number = np.cumsum(enough) - 1
    quick = HmmSpec(spec.states, 1, spec.covariance, spec.floor, max(spec.prior, 1.0), segmental=6, baum_welch=3)
    held = np.zeros((len(candidates), models))
    for row, states in zip(held, candidates, strict=True):
        for h in (0, 1):
            train_on, test_on = kept & (half != h), kept & (half == h)
            bank = train(
                x[train_on], lengths[train_on], number[model[train_on]], HmmSpec(**{**quick.__dict__, "states": states})
            )
            own = own_score(bank, x[test_on], lengths[test_on], number[model[test_on]])
            np.add.at(row, model[test_on], own / lengths[test_on])
    held /= np.maximum(np.bincount(model, minlength=models), 1)
    chosen = np.array(candidates)[(held >= held.max(axis=0) - margin).argmax(axis=0)]
    return np.where(enough, chosen, spec.states)


def own_score(bank: HmmBank, x: np.ndarray, lengths: np.ndarray, model: np.ndarray) -> np.ndarray:
    """(N,) log likelihood of each sequence under its own model only."""
    statistics = _Statistics(x, lengths, model, len(bank.means))
    alpha = forward(_own_emissions(bank, statistics)[0], *_own_transitions(bank, statistics))
    return log_sum(alpha[lengths - 1, :, np.arange(len(lengths))])
