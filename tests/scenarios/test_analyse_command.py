"""``vipr analyse servo``: tables, picture, and what it refuses."""

import json

import pytest

from vipr.scenarios.command import main


def command(*arguments):
    with pytest.raises(SystemExit) as end:
        main(["analyse", "servo", *map(str, arguments)])
    return end.value.code


def test_it_prints_limits_and_behaviour_and_draws_them(tmp_path, capsys):
    assert command("--gain", 2, "--latency", 100, "--out", tmp_path, "--json") == 0
    limits, behaviour = json.loads(capsys.readouterr().out)
    bridged, delayed = (row["largest stable gain 1/s"] for row in limits["rows"])
    assert bridged > 1.5 * delayed > 10
    assert [row["gain margin"] > 5 for row in behaviour["rows"]] == [True, True]
    assert (tmp_path / "servo.png").stat().st_size > 10_000


@pytest.mark.parametrize(
    "arguments, said",
    [
        (("--gain", 0), "gain must be above 0 and at most 1000 1/s, got 0 1/s"),
        (("--latency", -5), "latency must be 0 to 2000 ms, got -5 ms"),
        (("--latency", "soon"), "Invalid value for '--latency'"),
    ],
)
def test_bad_input_is_one_line_and_nothing_is_drawn(tmp_path, capsys, arguments, said):
    assert command(*arguments, "--out", tmp_path / "out") == 2
    error = capsys.readouterr().err.strip()
    assert said in error and error.startswith("vipr: error: ") and "\n" not in error
    assert not (tmp_path / "out").exists()
