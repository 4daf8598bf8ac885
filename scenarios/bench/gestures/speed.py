"""Processor time to score and to train, in one run beside hmmlearn on the same models and sequences."""

import time
from collections.abc import Iterator

import numpy as np

from vipr.scenarios.bench.gestures.reference import as_hmmlearn
from vipr.scenarios.bench.tables import Table
from vipr.scenarios.experiments.evaluation import classifier
from vipr.scenarios.experiments.writers import Writer, draw, graffiti
from vipr.systems.gestures.classifier import STREAMS
from vipr.systems.gestures.hmm import score
from vipr.systems.gestures.training import HmmSpec, train
from vipr.systems.gestures.trajectories import clean, describe, resample

PAPER_MS = 23.4  # a gesture, 400 MHz Pentium II
SPEC = HmmSpec(4, floor=1e-3, segmental=0, baum_welch=20, tolerance=-np.inf)


def run(bench) -> Iterator[Table]:
    """26 models of Graffiti letters, four states, full covariance, position and velocity; least of several repeats."""
    trajectories, labels = letters(6 if bench.quick else 20, bench.seed)
    repeats = 3 if bench.quick else 9
    stream = STREAMS["combined"][0]
    x = describe(resample([clean(t) for t in trajectories], stream.sampling, stream.points), stream)
    letter, lengths = np.unique(labels, return_inverse=True)[1], np.full(len(x), stream.points)
    bank = train(x, lengths, letter, SPEC)
    models, rows = [as_hmmlearn(bank, m) for m in range(26)], []
    for method in ("forward", "viterbi"):
        bench.progress(f"scoring, {method}")
        ours = _least(lambda method=method: score(bank, x[:1], method=method), repeats, 20)
        ask = (lambda m: m.score(x[0])) if method == "forward" else (lambda m: m.decode(x[0]))
        theirs = _least(lambda ask=ask: [ask(m) for m in models], repeats, 1)
        rows.append((f"score one gesture under 26 models, {method}", 1e3 * ours, 1e3 * theirs, theirs / ours))
    bench.progress("training")
    ours = _least(lambda: train(x, lengths, letter, SPEC), 2, 1)
    starts = [_start(x[letter == m]) for m in range(26)]
    theirs = _least(lambda: [_fit(x[letter == m], starts[m]) for m in range(26)], 1 if bench.quick else 2, 1)
    rows.append((f"train 26 models on {len(x)} gestures, 20 rounds", 1e3 * ours, 1e3 * theirs, theirs / ours))
    for name in ("combined", "default"):
        bench.progress(f"recognition, {name}")
        model = classifier(name).set_params(updates=1).fit(trajectories, labels)
        taken = _least(lambda m=model: m.recognise(trajectories[:1]), repeats, 5)
        rows.append((f"points in, name out, models {name} (paper: {PAPER_MS})", 1e3 * taken, np.nan, np.nan))
    yield Table(
        "Speed: Graffiti letters, 32 points, position and velocity, 4 states, full covariance",
        ("what", "ms here", "ms of hmmlearn", "times faster"),
        rows,
        f"Processor time, least of {repeats} repeats (training: 2), one thread.",
    )


def letters(writers: int, seed: int, times: int = 1) -> tuple[list[np.ndarray], np.ndarray]:
    """Drawings (T, 2) at 25 Hz of so many writers' alphabets, each ``times`` in a row, and their letters."""
    rng, forms = np.random.default_rng(seed), graffiti()
    drawn = [
        (draw(Writer.drawn(seed + w), a, forms[a], rng), a) for w in range(writers) for _ in range(times) for a in forms
    ]
    return [d for d, _ in drawn], np.array([a for _, a in drawn])


def _start(x):
    """What both are trained from: sequences cut into equal parts."""
    spec = HmmSpec(**{**SPEC.__dict__, "baum_welch": 0})
    return train(x, np.full(len(x), x.shape[1]), np.zeros(len(x), int), spec)


def _fit(x, start):
    """hmmlearn trains one letter for as many rounds."""
    model = as_hmmlearn(start, 0)
    model.params, model.n_iter, model.tol = "tmc", SPEC.baum_welch, -np.inf
    model.min_covar = model.covars_prior = SPEC.floor
    return model.fit(x.reshape(-1, x.shape[2]), np.full(len(x), x.shape[1]))


def _least(action, repeats, times):
    """Least processor time of an action [s], the mean of ``times`` in a row."""
    taken = []
    for _ in range(repeats):
        start = time.process_time()
        for _ in range(times):
            action()
        taken.append((time.process_time() - start) / times)
    return min(taken)
