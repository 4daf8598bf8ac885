"""``vipr run torque_switch``: what the clutches are for, on the hand alone."""

import json

import pytest

from vipr.scenarios.command import main


def run(folder, *settings):
    arguments = ["run", "torque_switch", "--out", str(folder), "--no-video", "--set=time_step_s=0.004"]
    with pytest.raises(SystemExit):
        main([*arguments, *(f"--set={s}" for s in settings)])
    return json.loads((folder / "summary.json").read_text())["figures"]


def test_clutches_let_go_and_the_outer_links_wrap_further_than_without(tmp_path):
    with_switch, without = run(tmp_path / "a"), run(tmp_path / "b", "break_away_nm=.inf")
    assert with_switch["clutches_open_count"] == 3 and without["clutches_open_count"] == 0
    assert with_switch["outer_links_deg"] > without["outer_links_deg"] + 4
    assert min(with_switch["raised_mm"], without["raised_mm"]) > 95


@pytest.mark.parametrize(
    ("setting", "message"),
    [
        ("torque_nm=3", "torque_nm must be above 0 and at most 1.8, got 3"),
        ("break_away_nm=0", "break_away_nm must be positive"),
        ("object=book", "book cannot be wrapped from the side"),
    ],
)
def test_what_cannot_be_shown_is_refused(setting, message, tmp_path, capsys):
    with pytest.raises(SystemExit) as ended:
        main(["run", "torque_switch", "--out", str(tmp_path / "o"), "--set", setting])
    assert ended.value.code == 2 and message in capsys.readouterr().err
