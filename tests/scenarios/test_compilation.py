"""The ``vipr compile`` command."""

import pytest

from vipr.scenarios.command import main


def test_compile_says_that_the_tracker_is_compiled(capsys):
    with pytest.raises(SystemExit) as done:
        main(["compile"])
    assert done.value.code == 0
    assert "the tracker is compiled" in capsys.readouterr().out
