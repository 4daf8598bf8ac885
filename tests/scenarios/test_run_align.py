"""``vipr run align``, shortened: its folder, its figures, and the same bytes for the same seed."""

import json
from pathlib import Path

import av
import pytest

from vipr.scenarios.command import main
from vipr.systems.recording.summary import without_time

SHORT = [
    f"--set={setting}"
    for setting in ("approach_s=2", "settle_s=0.5", "cruise_s=0", "start_offset_m=0.02", "start_turn_deg=5")
]
BRIEF = [f"--set={setting}" for setting in ("approach_s=0.5", "settle_s=0.5", "cruise_s=0", "supersampling=1")]


@pytest.fixture(scope="module")
def folder(tmp_path_factory) -> Path:
    """A run of seed 3, which may or may not meet its targets in so short a time."""
    path = tmp_path_factory.mktemp("align") / "run"
    with pytest.raises(SystemExit) as ended:
        main(["run", "align", "--seed", "3", "--out", str(path), *SHORT])
    assert ended.value.code in (0, 1)
    return path


def test_hand_comes_near_its_reference_pose(folder):
    figures = json.loads((folder / "summary.json").read_text())["figures"]
    assert figures["final_translation_error_mm"] < 8
    assert figures["final_rotation_error_deg"] < 2


def test_folder_holds_all_that_a_run_leaves_behind(folder):
    names = {path.name for path in folder.iterdir()}
    assert {"summary.json", "log.mcap", "video.mp4", "report.html"} <= names
    with av.open(str(folder / "video.mp4")) as video:
        frames = sum(1 for _ in video.decode(video=0))
    simulated = json.loads((folder / "summary.json").read_text())["time"]["simulated_s"]
    assert frames == pytest.approx(simulated / 0.04, abs=1.5)


def test_same_seed_same_bytes_and_another_seed_others(tmp_path):
    texts = []
    for name, seed in (("a", 3), ("b", 3), ("c", 4)):
        with pytest.raises(SystemExit):
            main(["run", "align", "--seed", str(seed), "--out", str(tmp_path / name), "--no-video", *BRIEF])
        texts.append(without_time(tmp_path / name / "summary.json"))
    assert texts[0] == texts[1] != texts[2]


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["run", "allign"], "Did you mean align?"),
        (["run", "align", "--set", "servo.gian=2"], "unknown setting servo.gian"),
        (["run", "align", "--set", "object=elephant"], "unknown object 'elephant'; there are: "),
        (["run", "align", "--seed", "-1"], "--seed: must be 0 or larger, got -1"),
        (["run", "align", "--sead", "1"], "No such option"),
        (["run"], "Missing argument"),
        (["run", "align", "--set", "camera.noise=-1"], "noise must be 0 to 255"),
        (["run", "align", "--set", "clearance_m=0.29"], "out of reach within the joint limits"),
        (["run", "follow", "--set", "cruise_s=5"], "the object leaves its stage"),
        (["run", "align", "--set", "servo.gain=200"], "servo.gain must be below 76.9"),
        (["run", "align", "--set", "servo.gain=200", "--set", "delay_frames=5"], "at a latency of 222 ms, got 200 1/s"),
        (["run", "align", "--set", "delay_frames=-1"], "delay_frames must be 0 to 25, got -1"),
    ],
)
def test_bad_input_is_one_line_and_exit_code_2(arguments, message, tmp_path, capsys, monkeypatch):
    monkeypatch.chdir(tmp_path)
    with pytest.raises(SystemExit) as ended:
        main(arguments)
    error = capsys.readouterr().err
    assert ended.value.code == 2
    assert message in error and error.count("\n") == 1 and error.startswith("vipr: error: ")
    assert not any(tmp_path.iterdir())


def test_list_and_show_speak_to_programs(capsys):
    with pytest.raises(SystemExit):
        main(["list", "--json"])
    assert "align" in [entry["name"] for entry in json.loads(capsys.readouterr().out)]
    with pytest.raises(SystemExit):
        main(["show", "align", "--json"])
    shown = json.loads(capsys.readouterr().out)
    assert "robot.tracker" in [stage["name"] for stage in shown["stages"]]
    assert any(event["stage"] == "robot.tracker" and event["offset_s"] == 0.02 for event in shown["schedule"])
