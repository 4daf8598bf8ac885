"""``vipr run instruct``: a person is watched, and what the robot understood is judged against what was meant."""

import json
from types import SimpleNamespace

import numpy as np
import pytest

from vipr.models.person.generate import BODIES
from vipr.scenarios.command import main
from vipr.scenarios.experiments.instructions import GARBAGE, LANGUAGE, Person
from vipr.scenarios.instruct import NAMES, judge_names
from vipr.scenarios.people.performance import drawn_names, performance


def told(number, name, start, end, accepted=1.0, direction=(np.nan, np.nan)):
    return {
        "number": number, "name": NAMES.index(name), "accepted": accepted, "start": start, "end": end, "named": end + 0.1,
        "direction_x": direction[0], "direction_y": direction[1],
    }  # fmt: skip


MEANT = SimpleNamespace(
    names=("stop", GARBAGE, "fetch"),
    spans=np.array([[1.0, 2.0], [3.0, 4.0], [5.0, 6.0]]),
    targets=np.array([[np.nan, np.nan], [np.nan, np.nan], [0.0, 1.0]]),
)


def test_a_gesture_is_recognised_by_the_movement_that_overlaps_it_most():
    answers = [told(0, "yes", 0.5, 1.2), told(1, "stop", 1.2, 2.1), told(2, "fetch", 5.1, 6.0, direction=(1.0, 0.0))]
    figures = judge_names(MEANT, answers)
    assert figures["recognised_percent"] == 100
    assert figures["false_instructions_count"] == 1  # "yes", on the way to "stop"
    assert figures["named_after_end_ms"] == pytest.approx(150)
    assert figures["pointing_error_deg"] == pytest.approx(90)


def test_wrong_names_rejections_and_idle_movements_count_against_the_robot():
    answers = [told(0, "stop", 1.0, 2.0, accepted=0.0), told(1, "come", 3.0, 4.0), told(2, "put", 5.0, 6.0)]
    assert judge_names(MEANT, answers) == {"recognised_percent": 0, "false_instructions_count": 1}
    assert judge_names(MEANT, []) == {"recognised_percent": 0, "false_instructions_count": 0}


def test_a_performance_holds_what_was_drawn_at_its_times_and_moves_smoothly():
    rng = np.random.default_rng(3)
    names = drawn_names(list(LANGUAGE), 14, 2, rng)
    assert len(set(names)) == 13 and names.count(GARBAGE) == 2
    shown = performance(Person.drawn(77), BODIES["medium"], names[:4], rng)
    assert shown.names == tuple(names[:4]) and (np.diff(shown.spans.ravel()) > 0.2).all()
    q = shown.q.vector_values(np.arange(0.0, shown.q.end_time(), 0.04))
    assert q.shape[0] == 15 and np.abs(np.diff(q[:5])).max() < 0.05


def test_a_short_run_sees_the_person_and_leaves_its_folder(tmp_path):
    folder = tmp_path / "run"
    with pytest.raises(SystemExit) as ended:
        main(["run", "instruct", "--seed", "2", "--out", str(folder), "--set=gestures=1", "--set=idle=0"])
    assert ended.value.code in (0, 1)
    figures = json.loads((folder / "summary.json").read_text())["figures"]
    assert figures["face_tracked_percent"] > 90 and figures["face_rms_px"] < 2
    assert {"log.mcap", "video.mp4", "report.html"} <= {path.name for path in folder.iterdir()}


@pytest.mark.parametrize(
    ("setting", "message"),
    [
        ("gestures=0", "gestures must be 1 to 100, got 0"),
        ("body=giant", "unknown body 'giant'; there are: any, "),
        ("model=no.npz", "gesture model no.npz: cannot be read"),
        ("stages.ears=a:b", "stages.ears: cannot import a"),
        ("stages.tracker=vipr.systems.truth:PoseTruth", "those that can be replaced are skin, hands, gestures"),
    ],
)
def test_bad_input_is_refused(setting, message, tmp_path, capsys):
    with pytest.raises(SystemExit) as ended:
        main(["run", "instruct", "--out", str(tmp_path / "o"), "--set", setting])
    assert ended.value.code == 2 and message in capsys.readouterr().err
    assert not (tmp_path / "o").exists()
