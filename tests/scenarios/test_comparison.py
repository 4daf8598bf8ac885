"""A stage of the user's own, named in a setting, stands in the robot; a change is told by its paired differences."""

import numpy as np
import pytest

from vipr.scenarios.bench.runs import spread
from vipr.scenarios.command import main
from vipr.scenarios.comparison import paired_table

OWN = """
from dataclasses import dataclass

from vipr.systems.tracking.tracker import ModelTracker


@dataclass
class Patience:
    frames: int = 3


class MyTracker(ModelTracker):
    def __init__(self, model, lens, **settings):
        super().__init__(model, lens, **settings)


class Narrow(ModelTracker):
    def __init__(self, model):
        super().__init__(model, None)
"""


@pytest.fixture
def mine(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    path = tmp_path / "mine.py"
    path.write_text(OWN)
    return path


@pytest.mark.parametrize("scenario", ["align", "pick"])
def test_a_stage_of_the_users_own_stands_in_the_robot(scenario, mine, capsys):
    with pytest.raises(SystemExit) as ended:
        main(["show", scenario, "--set", "stages.tracker=mine.py:MyTracker", "--json"])
    printed = capsys.readouterr().out
    assert ended.value.code == 0
    assert '"MyTracker"' in printed and '"ModelTracker"' not in printed


@pytest.mark.parametrize(
    ("stage", "message"),
    [
        ("tracker=mine.py:YourTracker", "stages.tracker: mine.py has no class or function YourTracker"),
        ("tracker=thine.py:MyTracker", "stages.tracker: there is no file thine.py"),
        ("tracker=no.such.module:MyTracker", "stages.tracker: cannot import no.such.module"),
        ("tracker=mine.py", "stages.tracker: expected FILE.py:CLASS or MODULE:CLASS, got 'mine.py'"),
        ("tracker=mine.py:Narrow", "stage tracker: Narrow is called as ModelTracker(model, lens, *, X_CO_initial=None"),
        ("traker=mine.py:MyTracker", "unknown stage 'traker'; those that can be replaced are tracker, servo, arm"),
        ("tracker=vipr.systems.signals:ObjectPose", "stage tracker: ObjectPose is called as ModelTracker(model, lens"),
    ],
)
def test_a_stage_that_does_not_fit_is_one_line_and_exit_code_2(stage, message, mine, capsys):
    with pytest.raises(SystemExit) as ended:
        main(["show", "align", "--set", f"stages.{stage}"])
    error = capsys.readouterr().err
    assert ended.value.code == 2
    assert message in error and error.count("\n") == 1


def runs(errors, success=True):
    return [{"success": success, "reason": "far", "seed": k, "figures": {"error_mm": e}} for k, e in enumerate(errors)]


def test_figures_are_compared_seed_by_seed():
    before = np.array([1.0, 2.0, 8.0, 3.0, 5.0, 4.0])
    table = paired_table("align", ["gain=2"], runs(before), runs(before - 0.5, success=False))
    done, error = table.rows
    assert done[:5] == ("done", 6, 6, 0, -6)
    assert error[:7] == ("error_mm", 6, 3.5, 3.0, -0.5, 6, 0)
    assert error[7] == pytest.approx(2 / 2**6)  # all six differences of one sign
    assert table.note.startswith("seed 0 changed: far; seed 1 changed")


def test_seeds_without_the_figure_and_differences_of_zero_count_for_nothing():
    before, after = runs([1.0, 2.0, float("nan")]), runs([1.0, 2.0, 3.0])
    (error,) = paired_table("align", ["gain=2"], before, after).rows[1:]
    assert error[:7] == ("error_mm", 2, 1.5, 1.5, 0.0, 0, 0)
    assert np.isnan(error[7])


def test_the_figures_of_many_runs_have_their_spread():
    table = spread("align", [*runs([1.0, 2.0, 6.0]), *runs([float("nan")], success=False)])
    assert table.title == "align: 3 of 4 runs did their task"
    assert table.rows == [("error_mm", 3, 2.0, 3.0, 1.0, 6.0)]
    assert table.note == "seed 0: far"


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["align"], "compare: nothing is changed"),
        (["allign", "--set", "servo.gain=3"], "unknown scenario 'allign'"),
        (["align", "--set", "servo.gian=3"], "unknown setting servo.gian"),
        (["align", "--both", "object=elephant", "--set", "servo.gain=3"], "unknown object 'elephant'"),
    ],
)
def test_bad_input_is_refused_before_anything_runs(arguments, message, tmp_path, capsys, monkeypatch):
    monkeypatch.chdir(tmp_path)
    with pytest.raises(SystemExit) as ended:
        main(["compare", *arguments])
    assert ended.value.code == 2
    assert message in capsys.readouterr().err
    assert not any(tmp_path.iterdir())
