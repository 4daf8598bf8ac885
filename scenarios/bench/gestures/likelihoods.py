"""How far scores and re-estimation are from the same by other ways."""

from collections.abc import Iterator

import numpy as np

from vipr.scenarios.bench.gestures.reference import as_hmmlearn, enumerate_paths, random_bank
from vipr.scenarios.bench.tables import Table
from vipr.systems.gestures.hmm import score
from vipr.systems.gestures.training import HmmSpec, train


def run(bench) -> Iterator[Table]:
    """Largest differences over random models and sequences."""
    rng = np.random.default_rng(bench.seed)
    cases = 3 if bench.quick else 20
    rows = []
    for K in (1, 2):
        bench.progress(f"enumeration, {K} components")
        worst = {"forward": 0.0, "viterbi": 0.0}
        for _ in range(cases):
            bank, x = random_bank(rng, K=K, S=3), rng.normal(size=(1, 6, 2))
            for m in range(3):
                p = [p for p, _ in enumerate_paths(bank, m, x[0])]
                for method, truth in (("forward", np.log(sum(p))), ("viterbi", np.log(max(p)))):
                    worst[method] = max(worst[method], abs(float(score(bank, x, method=method)[0, m]) - truth))
        rows += [(f"{method}, {K} components", "all 729 paths", 3 * cases, worst[method]) for method in worst]
    for K in (1, 2):
        bench.progress(f"hmmlearn, {K} components")
        worst = {"forward": 0.0, "viterbi": 0.0}
        for _ in range(cases):
            bank, x = random_bank(rng, M=4, S=5, K=K, d=3), rng.normal(size=(1, 20, 3))
            for m in range(4):
                model = as_hmmlearn(bank, m, mixtures=K > 1)
                for method, truth in (("forward", model.score(x[0])), ("viterbi", model.decode(x[0])[0])):
                    worst[method] = max(worst[method], abs(float(score(bank, x, method=method)[0, m]) - truth))
        rows += [(f"{method}, {K} components", "hmmlearn", 4 * cases, worst[method]) for method in worst]
    bench.progress("re-estimation")
    rows.append(("one round of Baum-Welch", "hmmlearn", cases, max(_round_of_training(rng) for _ in range(cases))))
    yield Table(
        "Correctness: largest difference [nats; parameters in units of the features]",
        ("quantity", "compared with", "models", "largest difference"),
        rows,
    )


def _round_of_training(rng) -> float:
    """Largest difference of means, covariances and transitions after one round from the same start."""
    x, lengths = np.cumsum(rng.normal(size=(5, 24, 2)), axis=1), np.full(5, 24)
    start, ours = (
        train(x, lengths, np.zeros(5, int), HmmSpec(4, floor=0.0, segmental=0, baum_welch=n)) for n in (0, 1)
    )
    theirs = as_hmmlearn(start, 0)
    theirs.params, theirs.n_iter, theirs.covars_prior, theirs.min_covar = "tmc", 1, 0.0, 0.0
    theirs.fit(x.reshape(-1, 2), lengths)
    differences = (
        np.exp(ours.stay[0, :-1]) - np.diag(theirs.transmat_)[:-1],
        ours.means[0, :, 0] - theirs.means_,
        ours.covariances[0, :, 0] - theirs.covars_,
    )
    return max(float(np.abs(d).max()) for d in differences)
