"""``vipr gestures``: train, recognise, evaluate on tables; one clear line for what it cannot use."""

import csv
import json

import numpy as np
import pytest

from vipr.scenarios.command import main
from vipr.scenarios.experiments.evaluation import confusion, select, split
from vipr.systems.errors import InputError
from vipr.systems.gestures.tables import GestureTable, write_table
from vipr.systems.gestures.trajectories import Trajectory


@pytest.fixture(scope="module")
def table():
    """Three shapes by four writers, and one sequence that is no trajectory."""
    rng, rows = np.random.default_rng(0), []
    shapes = {"hook": [(0, 0), (0, -1), (1, -1)], "vee": [(0, 0), (1, -2), (2, 0)], "bar": [(0, 0), (2, 0.2)]}
    for name, corners in shapes.items():
        for k in range(12):
            along = np.linspace(0.0, len(corners) - 1.0, 25)
            points = np.column_stack([np.interp(along, range(len(corners)), c) for c in np.array(corners, float).T])
            rows.append((name, f"w{k % 4}", 100.0 * points + rng.normal(0.0, 2.0, points.shape)))
    rows.append(("bar", "w0", np.full((3, 2), np.nan)))
    labels, writers, points = zip(*rows, strict=True)
    trajectories = [Trajectory(p, np.arange(len(p)) * 0.04) for p in points]
    return GestureTable(np.arange(len(rows)).astype(str), np.array(labels), np.array(writers), trajectories)


@pytest.fixture(scope="module")
def data(table, tmp_path_factory):
    folder = tmp_path_factory.mktemp("data") / "shapes"
    write_table(folder, table, {"name": "shapes"})
    return folder


def run(*arguments) -> int:
    with pytest.raises(SystemExit) as left:
        main([str(a) for a in arguments])
    return left.value.code


def test_evaluation_prints_accuracy_by_fold_and_class(data, tmp_path, capsys):
    picture = tmp_path / "confusion.png"
    code = run(
        "gestures",
        "evaluate",
        "--data",
        data,
        "--split",
        "writer:2",
        "--models",
        "combined",
        "--json",
        "--picture",
        picture,
    )
    summary = json.loads(capsys.readouterr().out)
    assert code == 0
    assert summary["accuracy_percent"] > 95.0
    assert sum(f["tested_on"] for f in summary["folds"]) == summary["sequences"] == 37
    assert set(summary["per_class"]) == {"hook", "vee", "bar"}
    assert picture.read_bytes().startswith(b"\x89PNG")


def test_a_second_table_is_tested_on_all_of_the_first(data, capsys):
    assert run("gestures", "evaluate", "--data", data, "--test", data, "--models", "position", "--json") == 0
    summary = json.loads(capsys.readouterr().out)
    assert summary["folds"][0]["trained_on"] == summary["folds"][0]["tested_on"] == 37


def test_what_was_trained_names_every_sequence(data, tmp_path, capsys):
    model, out = tmp_path / "shapes.npz", tmp_path / "named.csv"
    assert run("gestures", "train", "--data", data, "--model", model, "--models", "combined") == 0
    assert "1 unusable left out" in capsys.readouterr().out
    assert run("gestures", "recognise", "--model", model, "--data", data, "--out", out) == 0
    with out.open() as file:
        rows = list(csv.DictReader(file))
    assert list(rows[0]) == ["seq", "label", "probability", "rejected"]
    assert [r["label"] for r in rows[:36]] == ["hook"] * 12 + ["vee"] * 12 + ["bar"] * 12
    assert rows[36]["rejected"] == "1"


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["evaluate", "--split", "writer:9"], "--split writer:9: needs from 2 to 4 folds"),
        (["evaluate", "--split", "moon"], "--split is writer:K, writer:all or random:K, got 'moon'"),
        (["evaluate", "--models", "best"], "--models is one of default, position"),
        (["evaluate", "--states", "0"], "--states is a number from 1 to 30 or validated, got '0'"),
        (["evaluate", "--min-per-class", "99"], "no labelled sequence that meets the conditions"),
        (["evaluate", "--classes", "hook,dot"], "the table has no dot; it has bar, hook, vee"),
        (["train", "--model", "nowhere/m.npz"], "--model nowhere/m.npz: its folder must exist"),
    ],
)
def test_bad_requests_are_one_line_and_exit_code_2(data, capsys, arguments, message):
    command, *rest = arguments
    assert run("gestures", command, "--data", data, *rest) == 2
    said = capsys.readouterr().err
    assert message in said and said.count("\n") == 1


def test_a_truncated_model_is_one_line_and_leaves_nothing(data, tmp_path, capsys):
    model, out = tmp_path / "m.npz", tmp_path / "out.csv"
    run("gestures", "train", "--data", data, "--model", model, "--models", "position")
    model.write_bytes(model.read_bytes()[:-200])
    capsys.readouterr()
    assert run("gestures", "recognise", "--model", model, "--data", data, "--out", out) == 2
    assert capsys.readouterr().err.count("\n") == 1
    assert not out.exists()


def test_no_writer_is_on_both_sides_of_a_split(table):
    fold = split(table, "writer:2", 0)
    for w in np.unique(table.writers):
        assert len(set(fold[table.writers == w])) == 1
    assert len(np.unique(split(table, "writer:all", 0))) == 4


def test_random_folds_hold_each_class_evenly(table):
    fold = split(table, "random:3", 1)
    for label in np.unique(table.labels):
        assert np.ptp(np.bincount(fold[table.labels == label], minlength=3)) <= 1


def test_the_first_of_each_writer_and_class_are_taken(table):
    few = select(table, max_per_writer_class=1)
    assert len(few) == 12
    assert few.seq.tolist()[:4] == ["0", "1", "2", "3"]
    with pytest.raises(InputError, match="no labelled sequence"):
        select(GestureTable(table.seq, np.full(len(table), ""), table.writers, table.trajectories))


def test_confusion_counts_rows_of_truth():
    counts, labels = confusion(np.array(["a", "a", "b"]), np.array(["a", "b", "c"]))
    assert labels.tolist() == ["a", "b", "c"]
    assert counts.tolist() == [[1, 1, 0], [0, 0, 1], [0, 0, 0]]
