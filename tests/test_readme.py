"""What the README shows can be done as it stands."""

import re
from pathlib import Path

import pytest

from vipr.scenarios.command import main

README = Path(__file__).parents[1] / "README.md"


@pytest.mark.skipif(not README.exists(), reason="the README is not beside these tests: run them in a checkout")
@pytest.mark.parametrize("scenario", ["align", "pick"])
def test_the_stage_of_your_own_stands_in_the_robot(scenario, tmp_path, monkeypatch, capsys):
    (code,) = re.findall(r"```python\n# sure\.py\n(.*?)```", README.read_text(), re.DOTALL)
    (tmp_path / "sure.py").write_text(code)
    monkeypatch.chdir(tmp_path)
    with pytest.raises(SystemExit) as ended:
        main(["show", scenario, "--set", "stages.tracker=sure.py:SureTracker", "--json"])
    assert ended.value.code == 0
    assert '"SureTracker"' in capsys.readouterr().out
