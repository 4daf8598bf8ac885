"""``vipr run pick`` and the teaching of grasps: one pick, one trial, and what is refused before anything moves."""

import json

import numpy as np
import pytest

from vipr.models import model_path
from vipr.scenarios.command import main
from vipr.scenarios.pick import judge_pick
from vipr.scenarios.teaching.trial import attempt, fits
from vipr.systems import se3
from vipr.systems.grasping.candidates import Solid, resting_pose
from vipr.systems.grasping.grasp import load_grasps
from vipr.systems.tracking.cad_model import load_model

SHORT = ["film=false", "pick.hold_s=0.3", "lie=standing"]


def test_a_rice_box_is_picked_up_and_held(tmp_path):
    with pytest.raises(SystemExit) as ended:
        main(["run", "pick", "--seed", "1", "--out", str(tmp_path / "p"), "--no-video", *[f"--set={s}" for s in SHORT]])
    summary = json.loads((tmp_path / "p" / "summary.json").read_text())
    assert ended.value.code == 0, summary["reason"]
    figures = summary["figures"]
    assert figures["held"] == 1 and figures["slip_mm"] < 2 and figures["attempts"] == 1
    assert figures["raised_mm"] == pytest.approx(150, abs=5) and figures["object_tilt_deg"] < 5


@pytest.mark.parametrize(
    ("settings", "message"),
    [
        (["object=elephant"], "unknown object 'elephant'; there are: "),
        (["ballast_kg=3"], "3.4 kg is too heavy, the arm carries 2.5 kg"),
        (["place_m=[0.5, 0.0]"], "place_m must be within 0.20 and 0.15 m"),
        (["place_m=[0.2, 0.15]", "pick.errand.carry=1.2"], "none can be done"),
        (["object=mug", "lie=lying"], "no grasp is taught for a lying mug"),
        (["ballast_kg=0.4"], "0.8 kg is too heavy so far out, "),
        (["pose_error_in=dreams"], "unknown pose_error_in"),
        (["grasps=/nowhere.yaml"], "there is no file /nowhere.yaml"),
        (["pick.hold_s=-1"], "hold_s must be positive"),
        (["contact_model=jelly"], "unknown contact_model"),
        (["calibration.folder=/nowhere"], "camera file /nowhere/camera.yaml: cannot be read"),
    ],
)
def test_what_cannot_be_done_is_refused_in_one_line_before_anything_moves(settings, message, tmp_path, capsys):
    arguments = ["run", "pick", "--out", str(tmp_path / "out"), *(f"--set={s}" for s in settings)]
    with pytest.raises(SystemExit) as ended:
        main(arguments)
    error = capsys.readouterr().err
    assert ended.value.code == 2 and message in error and error.count("\n") == 1
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (("width_mm: 5", "width_mm: 35"), "is too wide, the hand opens to 291 mm"),
        (("preshape_deg: [", "preshape_deg: [1"), "deg, allowed 0 to 140 deg"),
        (("grasps:", "nothing:"), "the table is empty"),
    ],
)
def test_a_table_that_the_hand_cannot_do_is_refused(change, message, tmp_path, capsys):
    text = model_path("rice_box/grasps.yaml").read_text().replace(*change)
    (tmp_path / "g.yaml").write_text(text)
    with pytest.raises(SystemExit) as ended:
        main(["run", "pick", "--out", str(tmp_path / "out"), f"--set=grasps={tmp_path / 'g.yaml'}"])
    assert ended.value.code == 2 and message in capsys.readouterr().err


def test_a_trial_of_a_taught_grasp_holds_and_an_empty_one_does_not():
    table = load_grasps(model_path("can/grasps.yaml"))
    X_WO = resting_pose(Solid.of(load_model(model_path("can/model.yaml"))), np.array([0.0, 0.0, 1.0]))
    grasp = table.grasps[0]
    assert fits(grasp, "can", X_WO)
    good = attempt(grasp, "can", X_WO, shake=False)
    assert good.held and good.slip < 2e-3 and good.quality > 0.05
    beside = se3.pose(np.eye(3), [0.0, 0.3, 0.0]) @ X_WO @ grasp.X_OG
    assert not attempt(grasp, "can", X_WO, beside, shake=False).held


def test_an_object_left_behind_while_the_robot_says_held_counts_as_unnoticed():
    times = np.arange(50) * 0.04
    X_WO = np.tile(np.eye(4), (50, 1, 1))
    X_WE = X_WO.copy()
    X_WE[:, 2, 3] = np.linspace(0.1, 0.25, 50)
    outcome = judge_pick(times, X_WO, X_WE, [(0.0, "reach for x"), (0.1, "lift"), (1.9, "held")], 0.15)
    assert not outcome.success and outcome.figures["unnoticed"] == 1 and outcome.figures["held"] == 0
