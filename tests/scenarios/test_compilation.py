"""The ``vipr compile`` command."""

import pytest

from vipr.scenarios.command import main


def test_compile_says_what_it_has_done(capsys):
    with pytest.raises(SystemExit) as done:
        main(["compile"])
    assert done.value.code == 0
    assert "compiled" in capsys.readouterr().out
