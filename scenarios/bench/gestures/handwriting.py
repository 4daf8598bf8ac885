"""Real handwriting of writers held out of training, beside what other methods reached on the same data."""

from collections.abc import Iterator
from functools import partial

import numpy as np

from vipr.scenarios.bench.tables import Table
from vipr.scenarios.experiments.evaluation import classifier, cross_validate, select, split
from vipr.systems.gestures.tables import read_table

MOST = 8  # sequences of a writer and class
# Data, least sequences of a class, and others' percentages on it, on what split.
DATA = {
    "unipen_lower": (
        100,
        "the same selection and split",
        {"position": 71.5, "velocity": 63.9, "combined": 80.7, "DTW": 87.2, "SVM": 88.7},
    ),
    "pendigits": (
        0,
        "the official split of 30 and 14 writers",
        {"position": 88.0, "velocity": 85.8, "combined": 97.0, "DTW": 98.9, "SVM": 97.6},
    ),
}
MODELS = {
    "position": "position, 4 states",
    "velocity": "velocity, 4 states",
    "combined": "both, 4 states",
    "default": "this program's",
}
FOLDS = 5


def run(bench) -> Iterator[Table]:
    """One table a data set: a row for each kind of models."""
    for name, (least, official, others) in DATA.items():
        table = select(read_table(bench.data / name), least, 2 if bench.quick else MOST)
        fold = split(table, f"writer:{FOLDS}", bench.seed)
        if bench.quick:
            table, fold = table.choose(fold < 2), fold[fold < 2]
        rows = []
        for models, what in MODELS.items():
            known = "".join(f"; {row[0]}: {row[1]:.1f} % right" for row in rows)
            tick = partial(_tick, bench.progress, f"{name}, {what}", known)
            result = cross_validate(partial(classifier, models, seed=bench.seed), table, fold, tick)
            s = result.summary()
            spread = float(np.std([f["accuracy_percent"] for f in s["folds"]]))
            times = s["ms_per_sequence"], s["train_ms_per_sequence"]
            rows.append((what, s["accuracy_percent"], spread, others.get(models, np.nan), *times))
        yield Table(
            f"{name}: {len(table)} sequences, {len(np.unique(table.labels))} classes, {len(np.unique(table.writers))} writers, "
            f"{len(np.unique(fold))} folds by writer",
            ("models", "right %", "spread of folds", "hmmlearn %", "test ms a sequence", "training ms a sequence"),
            rows,
            f"Others on {official}: nearest neighbour by DTW {others['DTW']} %, support vector machine {others['SVM']} %; "
            "hmmlearn's position and velocity at 25 Hz.",
        )


def _tick(progress, what, known, share):
    progress(f"{what}: {100 * share:.0f} % done{known}")
