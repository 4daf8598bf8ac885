"""Tables of trajectories on disk: ``sequences.csv``, ``points.csv`` (or ``.csv.gz``), ``meta.json``.

``sequences.csv`` has a header with at least ``seq`` and, where known, ``label`` and ``writer``; ``points.csv`` has the columns
``seq,t_ms,x,y`` (further coordinates may follow), the points of a sequence in order.
"""

import csv
import gzip
import itertools
import json
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from vipr.systems.errors import InputError
from vipr.systems.gestures.trajectories import Trajectory


@dataclass(frozen=True, eq=False)
class GestureTable:
    """N sequences; ``labels`` and ``writers`` are empty strings where the table does not say."""

    seq: np.ndarray  # (N,) str
    labels: np.ndarray  # (N,) str
    writers: np.ndarray  # (N,) str
    trajectories: list[Trajectory]  # seconds; as in the table, not cleaned

    def __len__(self):
        return len(self.seq)

    def choose(self, index) -> "GestureTable":
        """The rows of an index array or mask."""
        index = np.arange(len(self))[index]
        return GestureTable(
            self.seq[index], self.labels[index], self.writers[index], [self.trajectories[i] for i in index]
        )


def read_table(folder: Path) -> GestureTable:
    """The table in a folder; sequences without points have an empty trajectory."""
    folder = Path(folder)
    rows = _sequences(folder / "sequences.csv")
    points = _points(folder)
    if not rows:
        raise InputError(f"{folder / 'sequences.csv'}: holds no sequences")
    if rows[0].get("seq") is None:
        raise InputError(f"{folder / 'sequences.csv'}: needs a column seq, has {', '.join(map(str, rows[0]))}")
    by_seq = {}
    cuts = np.r_[0, np.flatnonzero(np.diff(points[:, 0])) + 1, len(points)] if len(points) else np.zeros(1, int)
    for a, b in itertools.pairwise(cuts):
        key = _key(points[a, 0])
        if key in by_seq:
            raise InputError(f"{folder}: the points of sequence {key} do not stand together")
        by_seq[key] = Trajectory(points[a:b, 2:], points[a:b, 1] / 1000.0)
    nothing = Trajectory(np.zeros((0, points.shape[1] - 2)), np.zeros(0))
    seq = np.array([_key(r["seq"]) for r in rows])
    if len(set(seq)) != len(seq):
        raise InputError(f"{folder / 'sequences.csv'}: a sequence is listed twice")
    return GestureTable(
        seq,
        np.array([r.get("label") or "" for r in rows], str),
        np.array([r.get("writer") or "" for r in rows], str),
        [by_seq.get(s, nothing) for s in seq],
    )


def _key(value) -> str:
    """A sequence's name: numbers are the same however written."""
    try:
        number = float(value)
        return str(int(number)) if number == int(number) else str(value)
    except (ValueError, OverflowError):
        return str(value)


def _sequences(path):
    try:
        with path.open(newline="", encoding="utf-8") as file:
            return list(csv.DictReader(file))
    except OSError as error:
        raise InputError(f"{path}: cannot be read ({error.strerror})") from None
    except (csv.Error, UnicodeDecodeError) as error:
        raise InputError(f"{path}: is not a table ({error})") from None


def _points(folder):
    packed, plain = folder / "points.csv.gz", folder / "points.csv"
    path = packed if packed.exists() else plain
    try:
        with gzip.open(path, "rt") if path is packed else path.open() as file:
            header = file.readline().strip().split(",")
            if header[:2] != ["seq", "t_ms"] or len(header) < 3:
                raise InputError(f"{path}: columns must be seq,t_ms,x,y, got {','.join(header)[:80]}")
            points = np.genfromtxt(file, delimiter=",", ndmin=2, invalid_raise=True)
    except FileNotFoundError:
        raise InputError(f"{folder}: has neither points.csv.gz nor points.csv") from None
    except InputError:
        raise
    except (OSError, EOFError, ValueError) as error:
        raise InputError(f"{path}: cannot be read ({' '.join(str(error).split())[:120]})") from None
    if points.size == 0:
        return np.zeros((0, len(header)))
    if points.shape[1] != len(header):
        raise InputError(f"{path}: has {len(header)} columns in its header and {points.shape[1]} below")
    if not np.isfinite(points[:, 0]).all():
        raise InputError(
            f"{path}: line {int(np.flatnonzero(~np.isfinite(points[:, 0]))[0]) + 2} does not say its sequence"
        )
    return points


def write_table(folder: Path, table: GestureTable, meta: dict) -> None:
    """Write the table; ``meta`` says where it comes from."""
    folder.mkdir(parents=True, exist_ok=True)
    with (folder / "sequences.csv").open("w", newline="") as file:
        out = csv.writer(file)
        out.writerow(["seq", "label", "writer", "n_points", "duration_ms"])
        for s, label, writer, t in zip(table.seq, table.labels, table.writers, table.trajectories, strict=True):
            duration = 1000.0 * float(t.times[-1] - t.times[0]) if len(t) else 0.0
            out.writerow([s, label, writer, len(t), round(duration, 1)])
    with gzip.open(folder / "points.csv.gz", "wt") as file:
        width = table.trajectories[0].points.shape[1]
        file.write(",".join(["seq", "t_ms", *("x", "y", "x2", "y2")[:width]]) + "\n")
        for s, t in zip(table.seq, table.trajectories, strict=True):
            for time, point in zip(t.times, t.points, strict=True):
                file.write(f"{s},{1000.0 * time:.1f},{','.join(f'{v:.4g}' for v in point)}\n")
    (folder / "meta.json").write_text(json.dumps(meta, indent=1) + "\n")
