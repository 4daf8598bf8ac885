"""The summary file: its keys, its rounding, the same bytes for the same run."""

import json

import numpy as np
import pytest

from vipr.systems.errors import InputError
from vipr.systems.recording.summary import plain, time_figures, without_time, write_summary

ENTRIES = {
    "scenario": "align",
    "seed": 3,
    "success": np.bool_(True),
    "reason": "held the pose",
    "figures": {"final_translation_error_mm": np.float64(1.23456789), "frames": np.int64(7), "missing_mm": np.nan},
    "settings": {"servo": {"gain": 1.5, "target": np.array([1.0, np.inf])}},
}


def test_keys_come_in_their_order_and_values_are_plain(tmp_path):
    summary = write_summary(tmp_path / "summary.json", time=time_figures(2.0, 1.0, {}), **ENTRIES)
    assert summary == json.loads((tmp_path / "summary.json").read_text())
    assert list(summary) == "scenario seed success reason figures time settings versions".split()
    assert summary["success"] is True
    assert summary["figures"] == {"final_translation_error_mm": 1.23457, "frames": 7, "missing_mm": None}
    assert summary["settings"]["servo"]["target"] == [1.0, None]
    assert {"python", "drake", "numpy", "vipr"} <= set(summary["versions"])


def test_shares_of_the_wall_time_and_the_rest_make_one():
    time = time_figures(4.0, 2.0, {"vision": 1.0, "render": 2.0})
    assert time["real_time_factor"] == 0.5
    assert time["share"] == {"render": 0.5, "vision": 0.25, "other": 0.25}


def test_the_same_run_gives_the_same_bytes_apart_from_its_timings(tmp_path):
    for k, wall in enumerate((2.0, 3.0)):
        write_summary(tmp_path / f"{k}.json", time=time_figures(wall, 1.0, {}), **ENTRIES)
    write_summary(tmp_path / "other.json", time=time_figures(2.0, 1.0, {}), **(ENTRIES | {"seed": 4}))
    assert (tmp_path / "0.json").read_bytes() != (tmp_path / "1.json").read_bytes()
    assert without_time(tmp_path / "0.json") == without_time(tmp_path / "1.json")
    assert without_time(tmp_path / "0.json") != without_time(tmp_path / "other.json")


def test_rounding_forgives_the_last_bits():
    assert plain(0.1 + 0.2) == plain(0.3) == 0.3


def test_a_failed_write_leaves_the_good_file_alone(tmp_path, monkeypatch):
    path = tmp_path / "summary.json"
    path.write_text("good")
    monkeypatch.setattr("pathlib.Path.write_bytes", _full)
    with pytest.raises(InputError, match=r"summary\.json: cannot be written \(No space left"):
        write_summary(path, time={}, **ENTRIES)
    assert path.read_text() == "good"
    assert list(tmp_path.iterdir()) == [path]


def _full(path, data):
    path.touch()
    raise OSError(28, "No space left on device")
