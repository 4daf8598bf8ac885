"""The table of ``vipr bench align``."""

from vipr.scenarios.bench.align import COLUMNS, print_table


def summary(seed, error, success=True):
    time = {"real_time_factor": 0.1 * seed, "share": {"render": 0.7, "physics": 0.2, "vision": 0.1}}
    return {"seed": seed, "success": success, "figures": dict.fromkeys(COLUMNS, error), "time": time}


def test_the_table_has_a_row_a_seed_the_median_the_worst_and_where_the_time_went(capsys):
    print_table([summary(1, 0.25), summary(2, 1.5), summary(3, 4.75, success=False)])
    printed = " ".join(capsys.readouterr().out.split())
    assert "| 3 | 4.75 |" in printed and "| median | 1.5 |" in printed and "| worst | 4.75 |" in printed
    assert "2 of 3" in printed
    assert "Real-time factor 0.20 (median); neither rendering nor physics: 10.0 %" in printed


def test_a_run_that_did_not_end_has_no_figures(capsys):
    print_table([{**summary(1, 0.0, success=False), "figures": {}}])
    assert "| 1 | - |" in " ".join(capsys.readouterr().out.split())
