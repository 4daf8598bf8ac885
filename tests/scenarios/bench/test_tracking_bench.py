"""The tracking benchmark: its verdicts are right, whatever the tracker does."""

import json
from dataclasses import replace

import numpy as np
import pytest

from vipr.scenarios.bench.benchmark import Bench, measure
from vipr.scenarios.bench.tables import Table, print_json, print_tables
from vipr.scenarios.bench.tracking import accuracy, loss, parts, rounds
from vipr.scenarios.bench.tracking.workbench import WRONG_DEG, WRONG_MM, Run, Workbench, without_spin, wrong
from vipr.scenarios.sequences import trajectories
from vipr.scenarios.sequences.rendered import Conditions
from vipr.systems import se3
from vipr.systems.errors import InputError
from vipr.systems.tracking.belief import start


@pytest.fixture(scope="module")
def bench():
    return Workbench(Bench(quick=True))


def run_of(bench, name, poses, truth):
    return Run(bench.model(name), bench.lens, truth, [start(X) for X in poses], [True] * len(truth), [1.0] * len(truth))


def test_run_reports_errors_of_the_centre_and_the_first_frame_that_is_off(bench):
    X = bench.at("rice_box")
    shifted, turned = (
        X.copy(),
        trajectories.displaced(X, [0, np.radians(16), 0], np.zeros(3), bench.model("rice_box").centre),
    )
    shifted[:3, 3] += (0.001, 0.002, 0.01)
    run = run_of(bench, "rice_box", [X, shifted, turned], [X, X, X])
    np.testing.assert_allclose(run.millimetres, [[0, 0, 0], [1, 2, 10], [0, 0, 0]], atol=1e-9)
    np.testing.assert_allclose(run.degrees, [0, 0, 16], atol=1e-6)
    assert run.lost_at == 2 and not run.survived


def test_spin_of_a_can_is_no_error_but_its_tilt_is(bench):
    X = bench.at("can")
    spun = X @ se3.pose(se3.exp_so3(np.array([0, 0, 1.0])), np.zeros(3))
    tilted = trajectories.displaced(X, [0.05, 0, 0], np.zeros(3))
    run = run_of(bench, "can", [spun, tilted], [X, X])
    np.testing.assert_allclose(run.corner_px[0], 0, atol=1e-6)
    assert 1.0 < run.degrees[1] < np.degrees(0.05) + 1e-9
    np.testing.assert_array_equal(without_spin(bench.model("rice_box"), spun, X), spun)


def test_a_pose_that_is_off_counts_only_where_it_is_said_to_be_tracked(bench):
    X = bench.at("rice_box")
    aside = trajectories.displaced(X, np.zeros(3), [0.01, 0, 0])  # 10 px
    run = run_of(bench, "rice_box", [X, aside, aside], [X, X, X])
    run.beliefs[:2] = [replace(b, state="tracking") for b in run.beliefs[:2]]
    assert run.off.tolist() == [False, True, False]


def test_depth_told_is_that_of_the_centre(bench):
    X = bench.at("rice_box")
    run = run_of(bench, "rice_box", [X], [X])
    x, y, _ = X[:3, :3] @ bench.model("rice_box").centre
    variance = run.beliefs[0].covariance.diagonal()
    np.testing.assert_allclose(run.depth_told, 1e3 * np.sqrt(variance[5] + variance[0] * y**2 + variance[1] * x**2))


def test_starts_of_round_objects_are_wrong_by_what_is_said(bench):
    rng, centre = np.random.default_rng(1), bench.model("mug").centre
    turn, place = rounds.standing(rng)
    X = bench.at("mug", turn=turn, place=place)
    X_wrong = wrong(X, centre, rng)
    off = (X_wrong - X)[:3, :3] @ centre + (X_wrong - X)[:3, 3]
    np.testing.assert_allclose(1e3 * np.linalg.norm(off), WRONG_MM)
    np.testing.assert_allclose(np.degrees(se3.angle_between(X_wrong, X)), WRONG_DEG)
    assert 5 < np.degrees(np.arcsin(-X[2, 2])) < 41  # the axis, seen from above, leans towards the camera


def test_bound_shrinks_with_the_noise_and_has_no_spin(bench):
    for name in ("rice_box", "can (unprinted)"):
        frames = bench.render(name, trajectories.still(bench.at(name)), 1, Conditions(samples=4), background="plain")
        run = run_of(bench, name, [frames[0][1]], [frames[0][1]])
        sigma, bound = accuracy.edge_noise_and_bound(run, frames[0][0].image, frames[0][1], 200)
        assert 0.02 < sigma < 0.5
        depth, across = 1e3 * np.sqrt(bound[5, 5]), 1e3 * np.sqrt(bound[3, 3])
        assert 0.005 < across < 0.5 and 0.05 < depth < 5 and np.isfinite(bound).all()
    axis = frames[0][1][:3, 2]
    assert abs(axis @ bound[:3, :3] @ axis) < 1e-12


@pytest.mark.parametrize("kind", loss.KINDS)
def test_forced_loss_takes_the_object_away(bench, kind):
    name, frames = loss.forced_loss(bench, kind, 1)
    assert len(frames) == loss.BEFORE + loss.AFTER
    before, after = frames[loss.BEFORE - 1], frames[loss.BEFORE]
    p_C = bench.model(name).centre
    x, y = bench.lens.project(before[1][:3, :3] @ p_C + before[1][:3, 3]).astype(int)
    window = np.s_[y - 25 : y + 25, x - 20 : x + 20]
    assert np.abs(before[0].image[window].astype(int) - after[0].image[window]).mean() > 8
    assert (after[1] is not None) == (kind == "teleported")


def test_every_switch_of_the_tracker_is_tried_the_other_way():
    found = parts.variants()
    assert "no prediction" in found and "with quantised normals" in found and "all parts" in found
    assert not found["no prediction"].prediction


def test_tables_print_as_text_and_as_json(capsys):
    table = Table("Title", ("a", "b"), [("x", 1.23456), ("y", float("nan"))], note="A note.")
    print_tables([table])
    text = capsys.readouterr().out
    assert "Title" in text and "1.23" in text and "A note." in text
    print_json([table])
    assert json.loads(capsys.readouterr().out)[0]["rows"][1] == {"a": "y", "b": None}


def test_a_folder_without_sequences_is_said_clearly(tmp_path):
    with pytest.raises(InputError, match="holds no sequence"):
        list(measure("tracking", ["recordings"], data=tmp_path))


def test_recordings_stand_beside_the_other_trackers(shared_data):
    (table,) = measure("tracking", ["recordings"], data=shared_data / "tracking" / "teabox")
    assert [row[1].split(" (")[0] for row in table.rows] == [
        "VIPR",
        "ViSP 3.5 edges",
        "ViSP 3.5 edges + KLT",
        "OpenCV RAPID",
    ]
    visp = dict(zip(table.columns, table.rows[1], strict=True))
    assert visp["mm"] == "2.22 / 2.66 / 3.30" and visp["followed"] == "39 of 39"
