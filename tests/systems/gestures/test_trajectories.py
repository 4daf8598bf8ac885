"""Cleaning, resampling, normalisation and features; tables on disk."""

import gzip

import numpy as np
import pytest

from vipr.systems.errors import InputError
from vipr.systems.gestures.ink import ACROSS, LINES, ink
from vipr.systems.gestures.tables import GestureTable, read_table, write_table
from vipr.systems.gestures.trajectories import (
    FEATURES,
    Distortion,
    Stream,
    Trajectory,
    clean,
    describe,
    distort,
    even,
    fill_up,
    normalise,
    resample,
)


def curve(n=50, seed=0):
    rng = np.random.default_rng(seed)
    return np.cumsum(np.cumsum(rng.normal(size=(n, 2)), axis=0), axis=0)


def test_resampling_many_equals_resampling_each():
    many = [clean(curve(n, n)) for n in (5, 40, 17)]
    for sampling in ("time", "arc"):
        together = resample(many, sampling, 20)
        for row, one in zip(together, many, strict=True):
            np.testing.assert_allclose(row, resample([one], sampling, 20)[0], atol=1e-9)
            np.testing.assert_allclose(row[[0, -1]], one.points[[0, -1]], atol=1e-9)


def test_arc_length_ignores_speed_and_time_keeps_it():
    u = np.linspace(0.0, 1.0, 400)
    steady, hasty = (np.column_stack([v, v**2]) for v in (u, u**3))
    arc = resample([clean(steady), clean(hasty)], "arc", 16)
    np.testing.assert_allclose(arc[0], arc[1], atol=1e-4)
    timed = resample([clean(steady), clean(hasty)], "time", 16)
    assert np.abs(timed[0] - timed[1]).max() > 0.2


def test_time_stamps_decide_where_points_are():
    points = np.array([[0.0, 0.0], [1.0, 0.0], [2.0, 0.0]])
    (row,) = resample([clean(Trajectory(points, np.array([0.0, 3.0, 4.0])))], "time", 5)
    np.testing.assert_allclose(row[:, 0], [0.0, 1 / 3, 2 / 3, 1.0, 2.0])


def test_points_at_equal_distances_stay_where_they_are():
    line = np.linspace([0.0, 0.0], [3.0, 4.0], 9)[None]
    np.testing.assert_allclose(even(line), line, atol=1e-12)


@pytest.mark.parametrize("scale", ["spread", "box"])
def test_normalised_trajectories_have_one_place_and_size(scale):
    points = resample([clean(100.0 * curve() + 77.0)], "arc", 32)
    unit = normalise(points, scale)
    np.testing.assert_allclose(unit.mean(axis=1), 0.0, atol=1e-12)
    size = np.ptp(unit, axis=1).max() if scale == "box" else np.sqrt((unit**2).sum(axis=2).mean())
    assert size == pytest.approx(1.0)
    assert normalise(points, "none") is points


def test_features_have_their_meaning():
    circle = 0.5 * np.pi * np.linspace(0, 1, 32)
    points = np.column_stack([np.cos(circle), np.sin(circle)])[None]
    stream = Stream(("direction", "turning", "box"), smoothing=0)
    x = describe(points, stream)[0]
    np.testing.assert_allclose(np.hypot(x[:, 0], x[:, 1]), 1.0)
    assert (x[:, 2] > 0).all()  # turns to the left
    np.testing.assert_allclose(x[:, 2] ** 2 + x[:, 3] ** 2, 1.0)
    assert x[:, 4:].min() == pytest.approx(-0.5) and x[:, 4:].max() == pytest.approx(0.5)


def test_a_picture_shows_where_ink_lies_and_which_way_it_runs():
    bar = np.linspace([-0.5, 0.2], [0.5, 0.2], 32)[None]
    rows, columns = ink(bar, 1).reshape(LINES, 3, ACROSS), ink(bar, 0).reshape(LINES, 3, ACROSS)
    assert rows[:, 0].sum(axis=1).argmax() == round(0.7 * LINES - 0.5)  # one line is full
    assert (rows[:, 0].sum(axis=1) > 1e-9).sum() <= 2
    np.testing.assert_allclose(rows[:, 1], rows[:, 0])  # along x: cosine of twice the angle is 1
    np.testing.assert_allclose(np.ptp(columns[1:-1, 0], axis=0), 0.0, atol=0.02)  # every column is crossed once
    np.testing.assert_allclose(ink(bar[:, ::-1], 1), ink(bar, 1))


@pytest.mark.parametrize("d", [1, 2, 3, 4])
def test_every_feature_serves_any_number_of_coordinates(d):
    points = np.cumsum(np.random.default_rng(d).normal(size=(3, 32, d)), axis=1)
    for feature in FEATURES:
        x = describe(points, Stream((feature,)))
        assert x.shape[0] == 3 and np.isfinite(x).all()


def test_distorted_copies_are_near_and_none_changes_nothing():
    points = normalise(resample([clean(curve(60, 3))] * 50, "arc", 32))
    copies = normalise(distort(points, Stream(), np.random.default_rng(0), Distortion()))
    distance = np.sqrt(((copies - points) ** 2).sum(axis=2).mean(axis=1))
    assert 0.02 < np.median(distance) < 0.5
    same = distort(points, Stream(sampling="time"), np.random.default_rng(0), Distortion(0.0, 0.0, 0.0, 0.0))
    np.testing.assert_allclose(same, points, atol=1e-9)


def test_places_are_measured_in_another_unit_only_where_they_mean_something():
    points, still = resample([clean(curve(60, 3))] * 50, "time", 32), Distortion(0.0, 0.0, 0.0, 0.0, size=0.2)
    shape, place = (
        distort(points, Stream(sampling="time", scale=scale), np.random.default_rng(0), still)
        for scale in ("spread", "none")
    )
    np.testing.assert_allclose(shape, points, atol=1e-9)
    unit = (place / points).reshape(50, -1)
    assert np.ptp(unit, axis=1).max() < 1e-6
    assert 0.1 < np.log(unit[:, 0]).std() < 0.3


def test_small_classes_are_filled_up():
    labels = np.array([0, 0, 1, 0])
    source = fill_up(labels, 3)
    assert source.tolist() == [2, 2]
    assert len(fill_up(labels, 1)) == 0


def test_impossible_streams_are_refused():
    for bad in (
        {"features": ("colour",)},
        {"sampling": "space"},
        {"points": 2},
        {"scale": "log"},
        {"features": ("rows", "box")},
    ):
        with pytest.raises(InputError, match="gesture stream"):
            Stream(**bad)


@pytest.fixture
def table():
    trajectories = [Trajectory(curve(n, n), np.arange(n) / 100.0) for n in (9, 12)]
    return GestureTable(np.array(["4", "7"]), np.array(["a", "b"]), np.array(["w1", "w2"]), trajectories)


def test_a_table_is_read_as_it_was_written(tmp_path, table):
    write_table(tmp_path / "t", table, {"name": "t"})
    again = read_table(tmp_path / "t")
    assert (
        again.seq.tolist() == ["4", "7"]
        and again.labels.tolist() == ["a", "b"]
        and again.writers.tolist() == ["w1", "w2"]
    )
    for ours, theirs in zip(again.trajectories, table.trajectories, strict=True):
        np.testing.assert_allclose(ours.points, theirs.points, rtol=1e-3)
        np.testing.assert_allclose(ours.times, theirs.times, atol=1e-4)


def test_plain_points_and_sequences_without_points_are_read(tmp_path):
    (tmp_path / "sequences.csv").write_text("seq,label\n1,a\n2,b\n")
    (tmp_path / "points.csv").write_text("seq,t_ms,x,y\n1,0,1,2\n1,40,,3\n1,80,2,4\n")
    table = read_table(tmp_path)
    assert [len(t) for t in table.trajectories] == [3, 0]
    assert np.isnan(table.trajectories[0].points[1, 0])
    assert table.writers.tolist() == ["", ""]


def test_rows_and_columns_stand_in_any_order_and_sequences_have_any_name(tmp_path):
    (tmp_path / "sequences.csv").write_text("label, seq\na b,two\nc,1\n", encoding="utf-8-sig")
    (tmp_path / "points.csv").write_text("t_ms, y, seq, x\r\n80,2,two,9\r\n0,1,1.0,5\r\n40,3,two,8\r\n40,4,1,6\r\n")
    table = read_table(tmp_path)
    assert table.seq.tolist() == ["two", "1"] and table.labels.tolist() == ["a b", "c"]
    two, one = table.trajectories
    assert two.points.tolist() == [[3, 8], [2, 9]] and two.times.tolist() == [0.04, 0.08]
    assert one.points.tolist() == [[1, 5], [4, 6]]


@pytest.mark.parametrize(
    ("sequences", "points", "message"),
    [
        (None, "seq,t_ms,x,y\n", "sequences.csv: cannot be read"),
        ("seq,label\n", "seq,t_ms,x,y\n1,0,1,2\n", "holds no sequences"),
        ("name,label\nq,a\n", "seq,t_ms,x,y\n1,0,1,2\n", "needs a column seq, has name, label"),
        ("seq,label\n1,a\n1,b\n", "seq,t_ms,x,y\n1,0,1,2\n", "listed twice"),
        ("seq,label\n1,a\n", None, "has neither points.csv.gz nor points.csv"),
        ("seq,label\n1,a\n", "x,y\n1,2\n", "columns must be seq,t_ms,x,y, got x,y"),
        ("seq,label\n1,a\n", "seq,t_ms,x,y\n1,0,1,2\n1,3\n", "points.csv: the header has 4 columns, row 2 has 2"),
        ("seq,label\n1,a\n", "seq,t_ms,x,y\n1,0,1,2\n,3,1,1\n", "points.csv: row 2 does not say its sequence"),
        ("seq,label\n1,a\n", "seq,t_ms,x,y\n1,0,1,2\n1,3,?,1\n", r"points.csv: x of row 2 is no number, got '\?'"),
        ("seq,label\n1,a\n", "seq,t_ms,x,x\n1,0,1,2\n", "points.csv: a column is named twice"),
        ("seq,label\n1,a\n,b\n", "seq,t_ms,x,y\n1,0,1,2\n", "sequences.csv: row 2 does not say its sequence"),
    ],
)
def test_bad_tables_are_told_in_one_line(tmp_path, sequences, points, message):
    for name, text in (("sequences.csv", sequences), ("points.csv", points)):
        if text is not None:
            (tmp_path / name).write_text(text)
    with pytest.raises(InputError, match=message) as error:
        read_table(tmp_path)
    assert "\n" not in str(error.value)


def test_truncated_packed_points_are_told(tmp_path):
    (tmp_path / "sequences.csv").write_text("seq,label\n1,a\n")
    whole = gzip.compress(b"seq,t_ms,x,y\n" + b"1,0,1,2\n" * 500)
    (tmp_path / "points.csv.gz").write_bytes(whole[: len(whole) // 2])
    with pytest.raises(InputError, match=r"points\.csv\.gz: cannot be read"):
        read_table(tmp_path)
