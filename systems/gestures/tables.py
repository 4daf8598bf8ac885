"""Tables of trajectories on disk: ``sequences.csv``, ``points.csv`` (or ``.csv.gz``), ``meta.json``.

``sequences.csv`` has a header with at least ``seq`` and, where known, ``label`` and ``writer``; ``points.csv`` has the columns
``seq``, ``t_ms``, ``x`` and ``y`` and perhaps further coordinates, a point a row. Rows and columns may stand in any order. Where the
hand was not seen, x and y are left empty.
"""

import csv
import gzip
import json
import zlib
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
    path, points_path = folder / "sequences.csv", _points_file(folder)
    header, rows = _rows(path)
    if not rows:
        raise InputError(f"{path}: holds no sequences")
    if "seq" not in header:
        raise InputError(f"{path}: needs a column seq, has {', '.join(header)[:80]}")
    columns = dict(zip(header, zip(*rows, strict=True), strict=True))
    seq = np.array([_key(s) for s in columns["seq"]])
    unnamed = np.flatnonzero(seq == "")
    if len(unnamed):
        raise InputError(f"{path}: row {unnamed[0] + 1} does not say its sequence")
    if len(set(seq)) != len(seq):
        raise InputError(f"{path}: a sequence is listed twice")
    trajectories, dimension = _trajectories(points_path)
    nothing = Trajectory(np.zeros((0, dimension)), np.zeros(0))
    empty = [""] * len(seq)
    return GestureTable(
        seq,
        np.array(columns.get("label", empty), str),
        np.array(columns.get("writer", empty), str),
        [trajectories.get(s, nothing) for s in seq],
    )


def _key(value) -> str:
    """A sequence's name: numbers are the same however written."""
    try:
        number = float(value)
        return str(int(number)) if number == int(number) else str(value)
    except (ValueError, OverflowError):
        return str(value)


def _rows(path):
    """The header and the rows of a CSV file, without blanks around what they hold."""
    try:
        with (
            gzip.open(path, "rt", newline="", encoding="utf-8-sig")
            if path.suffix == ".gz"
            else path.open(newline="", encoding="utf-8-sig") as file
        ):
            rows = [[cell.strip() for cell in row] for row in csv.reader(file, skipinitialspace=True) if row]
    except (OSError, EOFError, zlib.error) as error:
        raise InputError(f"{path}: cannot be read ({getattr(error, 'strerror', None) or error})") from None
    except (csv.Error, UnicodeDecodeError) as error:
        raise InputError(f"{path}: is not a table ({error})") from None
    header = rows[0] if rows else []
    if len(set(header)) != len(header):
        raise InputError(f"{path}: a column is named twice in {','.join(header)[:80]}")
    for number, row in enumerate(rows[1:], 1):
        if len(row) != len(header):
            raise InputError(f"{path}: the header has {len(header)} columns, row {number} has {len(row)}")
    return header, rows[1:]


def _points_file(folder):
    for name in ("points.csv.gz", "points.csv"):
        if (folder / name).exists():
            return folder / name
    if not (folder / "sequences.csv").exists():
        return folder / "points.csv"  # what is missing first is told first
    raise InputError(f"{folder}: has neither points.csv.gz nor points.csv")


def _trajectories(path):
    """The trajectory of each sequence, its points in the order of their times, and the number of coordinates."""
    header, rows = _rows(path)
    if not {"seq", "t_ms"} <= set(header) or len(header) < 3:
        raise InputError(f"{path}: columns must be seq,t_ms,x,y, got {','.join(header)[:80]}")
    columns = dict(zip(header, zip(*rows, strict=True) if rows else [()] * len(header), strict=True))
    seq = columns.pop("seq")
    if "" in seq:
        raise InputError(f"{path}: row {seq.index('') + 1} does not say its sequence")
    keys = {s: _key(s) for s in set(seq)}
    place = {key: n for n, key in enumerate(sorted(set(keys.values())))}
    number = np.array([place[keys[s]] for s in seq], int)
    values = np.stack([_numbers(path, name, column) for name, column in columns.items()], axis=1)
    at = list(columns).index("t_ms")
    time, points = values[:, at] / 1000.0, np.delete(values, at, axis=1)
    order = np.lexsort((time, number))
    cuts = np.searchsorted(number[order], np.arange(1, len(place)))
    parts = np.split(order, cuts) if place else []
    return {n: Trajectory(points[p], time[p]) for n, p in zip(place, parts, strict=True)}, points.shape[1]


def _numbers(path, name, column):
    """A column's numbers; NaN where it says nothing."""
    column = ["nan" if cell == "" else cell for cell in column]
    try:
        return np.array(column, float)
    except ValueError:
        for number, cell in enumerate(column, 1):
            try:
                float(cell)
            except ValueError:
                raise InputError(f"{path}: {name} of row {number} is no number, got {cell[:40]!r}") from None
        raise


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
