"""What commands print besides their results."""

from vipr.scenarios.command import output


def test_without_a_terminal_progress_is_told_in_lines_not_too_often(capsys, monkeypatch):
    now = [0.0]
    monkeypatch.setattr(output.time, "monotonic", lambda: now[0])
    with output.progress_line("bench") as tell:
        for now[0], text in ((1.0, "early"), (31.0, "[half] done"), (40.0, "soon after"), (62.0, "nearly")):
            tell(text)
    printed = capsys.readouterr()
    assert printed.err.splitlines() == ["[half] done", "nearly"]
    assert printed.out == ""
