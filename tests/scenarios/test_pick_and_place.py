"""``vipr run pick_and_place``: one run with short pauses, its judge, and what is refused."""

import json

import numpy as np
import pytest

from vipr.scenarios.command import main
from vipr.scenarios.pick_and_place import judge_place
from vipr.systems import se3

SHORT = ["film=false", "supersampling=1", "pick.hold_s=0.1", "servo.gain=3", "arrival={within_mm: 1, stay_s: 0.2}"]
LIMITS = {"final_translation_error_mm": 2.0, "final_rotation_error_deg": 0.5}
PHASES = [(0.0, "look"), (0.2, "reach for x"), (1.0, "place"), (2.0, "placed")]


def test_a_grasped_carton_comes_to_where_it_was_shown(tmp_path):
    with pytest.raises(SystemExit) as ended:
        main(
            [
                "run",
                "pick_and_place",
                "--seed",
                "1",
                "--out",
                str(tmp_path / "p"),
                "--no-video",
                *[f"--set={s}" for s in SHORT],
            ]
        )
    summary = json.loads((tmp_path / "p" / "summary.json").read_text())
    assert ended.value.code == 0, summary["reason"]
    figures = summary["figures"]
    assert figures["attempts"] == 1 and figures["slip_mm"] < 1.0
    assert figures["final_translation_error_mm"] < 2.0 and figures["final_rotation_error_deg"] < 0.5


def flown(shift):
    """Times and poses of an object that ends ``shift`` [m] from its place, the hand at its place."""
    X_WO = np.tile(np.eye(4), (51, 1, 1))
    X_WO[:, :3, 3] = np.linspace([0.1, 0.0, 0.0], shift, 51)
    X_WO[36:, :3, 3] = shift
    X_WE = np.tile(np.eye(4), (51, 1, 1))
    X_WE[:, :3, 3] = X_WO[:, :3, 3]
    return 0.04 * np.arange(51), X_WO, X_WE


def test_the_judge_measures_from_the_place_and_believes_no_claim():
    times, X_WO, X_WE = flown([0.0, 0.0, 1e-3])
    good = judge_place(times, X_WO, X_WE, PHASES, np.eye(4), LIMITS)
    assert good.success and good.figures["final_translation_error_mm"] == pytest.approx(1.0)
    assert good.figures["slip_mm"] == pytest.approx(0.0)
    far = judge_place(*flown([0.0, 0.0, 5e-3]), PHASES, np.eye(4), LIMITS)
    assert not far.success and far.reason == "final_translation_error_mm 5.00, allowed 2"
    turned = judge_place(times, X_WO, X_WE, PHASES, se3.pose(se3.exp_so3(np.array([0, 0, 0.02])), np.zeros(3)), LIMITS)
    assert not turned.success and "final_rotation_error_deg 1.15" in turned.reason
    given_up = judge_place(times, X_WO, X_WE, [*PHASES[:3], (2.0, "gave up: dropped")], np.eye(4), LIMITS)
    assert not given_up.success and given_up.reason == "gave up: dropped"


@pytest.mark.parametrize(
    ("setting", "message"),
    [
        ("shown=nowhere.yaml", "shown place nowhere.yaml: cannot be read"),
        ("arrival.stay_s=0", "arrival: stay_s must be positive, got 0"),
        ("max_error_mm=-1", "max_error_mm must be 0 to 1000"),
        ("servo=telepathic", "must be one of position_based, image_based, hybrid"),
    ],
)
def test_what_cannot_be_done_is_refused_in_one_line(setting, message, tmp_path, capsys):
    with pytest.raises(SystemExit) as ended:
        main(["run", "pick_and_place", "--out", str(tmp_path / "out"), f"--set={setting}"])
    error = capsys.readouterr().err
    assert ended.value.code == 2 and message in error and error.count("\n") == 1
    assert not (tmp_path / "out").exists()
