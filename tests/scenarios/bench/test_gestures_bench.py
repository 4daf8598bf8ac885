"""The gesture benchmark: parts by name, verdicts on cuts, and its own references."""

import numpy as np
import pytest

from vipr.scenarios.bench.benchmark import measure
from vipr.scenarios.bench.gestures.phases import judge, read_recording
from vipr.systems.errors import InputError
from vipr.systems.gestures.segmentation import segment
from vipr.systems.gestures.trajectories import Trajectory


def test_likelihoods_agree_with_enumeration_and_hmmlearn():
    (table,) = measure("gestures", ["likelihoods"], quick=True)
    assert len(table.rows) == 9
    assert all(row[-1] < 1e-9 for row in table.rows)


def test_gaps_that_are_told_cost_the_papers_models_fewer_letters():
    (table,) = measure("gestures", ["gaps"], quick=True)
    shares, untold, told, _, default = (np.array(column) for column in zip(*table.rows, strict=True))
    assert shares[0] == 0.0 and untold[0] == told[0] > 90.0 and default[0] > 90.0
    assert told[-1] > untold[-1] + 5.0


def test_movements_are_judged_by_the_frames_they_cover():
    times = np.arange(100) / 25.0
    phases = np.repeat(["rest", "stroke", "hold", "stroke", "rest"], 20)
    found = judge(
        times, phases, [Trajectory(np.zeros((15, 2)), times[25:40]), Trajectory(np.zeros((10, 2)), times[90:])]
    )
    assert (found["movements"], found["right"], found["strokes"], found["found"]) == (2, 1, 2, 1)
    assert found["moving_precision"] == pytest.approx(60.0)
    assert found["moving_recall"] == pytest.approx(37.5)
    assert found["pause_recall"] == pytest.approx(100.0 * 50 / 60)
    assert judge(times, phases, [])["moving_recall"] == 0.0


def test_a_speakers_gestures_are_cut_at_his_pauses(shared_data):
    times, points, phases = read_recording(shared_data / "gestures" / "gesture_phase" / "raw" / "a1_raw.csv")
    found = judge(times, phases, segment(times, points))
    assert found["moving_precision"] > 75.0 and found["moving_recall"] > 75.0


def test_files_that_are_no_recordings_are_told_in_one_line(tmp_path):
    with pytest.raises(InputError, match=r"a1_raw\.csv: cannot be read"):
        list(measure("gestures", ["phases"], data=tmp_path))
    (tmp_path / "x.csv").write_text("a,b\n1,2\n")
    with pytest.raises(InputError, match="is not a recording of gesture phases"):
        read_recording(tmp_path / "x.csv")
