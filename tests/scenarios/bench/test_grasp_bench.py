"""``vipr bench grasp``: its tables, from picks that are already there."""

import json

import numpy as np
import pytest

from vipr.models import object_names
from vipr.scenarios.bench import grasp_switch
from vipr.scenarios.bench.grasp import CHOICES, ERROR_PLACES, ERRORS, HALF_STEP, run
from vipr.scenarios.teaching.trial import Trial
from vipr.systems.errors import InputError


def row(name, seed, held=True):
    figures = {"slip_mm": 0.5, "slip_after_lift_mm": 0.1, "object_tilt_deg": 0.2, "attempts": 1}
    return {
        "object": name,
        "seed": seed,
        "success": held,
        "reason": "held",
        "knocked_over": 0.0,
        "unnoticed": 0.0,
        **figures,
    }


@pytest.fixture
def kept(tmp_path):
    """Every pick of six placements and of one with each change; the fourth dropped."""
    errors = [(f"pose_error_mm={e}", f"pose_error_deg={e}", f"pose_error_in={p}") for p in ERROR_PLACES for e in ERRORS]
    changes = [(), HALF_STEP, *CHOICES.values(), *errors]
    path = tmp_path / "picks.jsonl"
    with path.open("w") as file:
        for overrides in changes:
            for i, name in enumerate(object_names()):
                file.write(json.dumps([[name, 5 + i, list(overrides)], row(name, 5 + i, held=i != 3)]) + "\n")
    return path


def test_what_was_done_before_is_not_done_again_and_all_tables_come_out(kept):
    before = kept.read_text()
    tables = list(run(6, ["placements", "errors", "choices", "physics"], 5, 1, [], kept, lambda text: None))
    assert [len(t.rows) for t in tables] == [7, 4, 4, 5, 2]
    last = tables[0].rows[-1]
    assert last[:3] == ("all", 6, pytest.approx(500 / 6))
    assert kept.read_text() == before


def test_an_unknown_part_is_refused():
    with pytest.raises(
        InputError, match="unknown part 'luck', allowed are placements, errors, choices, physics, switch"
    ):
        list(run(6, ["luck"], 0, 1, [], None, lambda text: None))


def test_each_setting_of_the_torque_switch_gets_the_same_grasps_and_what_failed_counts_as_not_held(monkeypatch):
    asked = {}

    def attempt(grasp, name, X_WO, X_WG, *, drives):
        asked.setdefault(drives.break_away_torque, []).append((grasp.name, X_WG.tobytes()))
        fails = "pinch" in grasp.name and drives.break_away_torque < 1.5
        slip = np.inf if fails else 1e-3 * len(asked[drives.break_away_torque])
        return Trial(not fails, slip, 0.01, 0.0, np.zeros(3), np.zeros(3), 0.2, let_go=1)

    monkeypatch.setattr(grasp_switch, "attempt", attempt)
    monkeypatch.setattr(grasp_switch, "fits", lambda *_: True)
    table = grasp_switch.run(1, lambda text: None, ["can"])
    assert len({tuple(grasps) for grasps in asked.values()}) == 1
    shares = {row[:2]: row[3] for row in table.rows}
    assert (
        shares["pinch", "0.5"] == shares["pinch", "1"] == 0 and shares["pinch", "1.5"] == shares["wrap", "none"] == 100
    )
    (wrap,) = (row for row in table.rows if row[:2] == ("wrap", "1"))
    assert wrap[4:7] == (1.0, pytest.approx(0.2), pytest.approx(4.5)) and wrap[7] == pytest.approx(8.0)
