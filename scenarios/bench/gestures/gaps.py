"""Letters of which a stretch was not seen: what it is worth to know where."""

from collections.abc import Iterator

import numpy as np

from vipr.scenarios.bench.gestures.speed import letters
from vipr.scenarios.bench.tables import Table
from vipr.scenarios.experiments.graffiti import ROWS, models
from vipr.systems.gestures.trajectories import Trajectory

SHARES = (0.0, 0.1, 0.2, 0.3, 0.4)  # of a letter's time, at a place by chance
WRITERS, TIMES = 5, 6  # alphabets of each: half for training, half for test


def run(bench) -> Iterator[Table]:
    """A row for each share; models trained on whole letters, as in the experiment."""
    writers, times = (3, 2) if bench.quick else (WRITERS, TIMES)
    trajectories, labels = letters(writers, bench.seed, times)
    train = np.arange(len(labels)) // 26 % 2 == 0
    whole = [t for t, chosen in zip(trajectories, train, strict=True) if not chosen]
    columns = []
    for row in ("combined", "default"):
        model = models(row, bench.seed)
        bench.progress(f"training, {ROWS[row]}")
        if bench.quick:
            model.set_params(updates=20)
        model.fit([t for t, chosen in zip(trajectories, train, strict=True) if chosen], labels[train])
        for told in (False, True):
            columns.append([_right(model, whole, labels[~train], share, told, bench.seed) for share in SHARES])
    yield Table(
        f"Gaps: {len(whole)} letters of {writers} writers, named by models of {int(train.sum())} whole ones, right %",
        ("share not seen, %", "both features", "both, gaps told", "default", "default, gaps told"),
        [(100.0 * share, *values) for share, *values in zip(SHARES, *columns, strict=True)],
        "Gaps are told by points that are not there (NaN); where they are not, the points are left out.",
    )


def _right(model, whole, truth, share, told, seed):
    rng = np.random.default_rng([seed, 6])
    torn = [_torn(t, share, told, rng) for t in whole]
    return 100.0 * float((model.recognise(torn)[0] == truth).mean())


def _torn(points, share, told, rng):
    """A drawing (T, 2) at 25 Hz without ``share`` of its time."""
    missing = round(share * len(points))
    first = int(rng.integers(1, len(points) - missing))
    seen = np.ones(len(points), bool)
    seen[first : first + missing] = False
    times = np.arange(len(points)) / 25.0
    if told:
        return Trajectory(np.where(seen[:, None], points, np.nan), times)
    return Trajectory(points[seen], times[seen])
