"""Settings: what is given is what is used, and bad input is one clear line."""

from dataclasses import dataclass

import pytest

from vipr.scenarios.settings import as_dict, load_settings
from vipr.systems.camera.imperfections import Imperfection
from vipr.systems.errors import InputError
from vipr.systems.servo.position_based import PositionBased


@dataclass(frozen=True, kw_only=True)
class Settings:
    servo: PositionBased = PositionBased()
    camera: Imperfection = Imperfection()
    object: str = "milk_carton"


@pytest.fixture
def file(tmp_path):
    path = tmp_path / "settings.yaml"
    path.write_text("servo: {gain: 3}\nobject: can\n")
    return path


def test_overrides_come_after_the_file_and_defaults_before(file):
    settings = load_settings(
        Settings, file, ["servo.max_turn=0.5", "object=rice_box", "camera.colour_cast=[1, 0.9, 0.8]"]
    )
    assert (settings.servo.gain, settings.servo.max_turn, settings.servo.feed_forward) == (3.0, 0.5, True)
    assert settings.object == "rice_box"
    assert settings.camera.colour_cast == (1.0, 0.9, 0.8)
    assert as_dict(settings)["servo"]["gain"] == 3.0


@pytest.mark.parametrize(
    ("override", "message"),
    [
        ("servo.gian=2", r"unknown setting servo\.gian; allowed are servo\.gain, .* Did you mean servo\.gain\?"),
        ("servo.gain=fast", r"setting servo\.gain: .*valid number.*got 'fast'"),
        ("servo.gain=-1", r"gain must be positive, got -1\.0"),
        ("servo=3", r"setting servo"),
        ("servo.gain.x=3", "gain has no settings below it"),
        ("object", "expected key=value"),
        ("object=[", "is not a YAML value"),
    ],
)
def test_bad_overrides_are_refused_in_one_line(file, override, message):
    with pytest.raises(InputError, match=message) as caught:
        load_settings(Settings, file, [override])
    assert "\n" not in str(caught.value)
