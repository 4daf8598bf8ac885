"""Settings: what is given is what is used, and bad input is one clear line."""

from dataclasses import dataclass
from typing import Annotated

import pytest

from vipr.scenarios.settings import ONE_OF, as_dict, load_settings
from vipr.systems.camera.imperfections import Imperfection
from vipr.systems.errors import InputError
from vipr.systems.servo.gain import AdaptiveGain
from vipr.systems.servo.image_based import ImageBased
from vipr.systems.servo.laws import ServoLaw
from vipr.systems.servo.position_based import PositionBased


@dataclass(frozen=True, kw_only=True)
class Settings:
    servo: Annotated[ServoLaw, ONE_OF] = PositionBased()
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
    "overrides",
    [
        ["servo=image_based", "servo.jacobian=mean", "servo.gain=3"],
        ["servo.jacobian=mean", "servo=image_based"],
        ["servo.kind=image_based", "servo.jacobian=mean"],
    ],
)
def test_one_of_several_dataclasses_is_chosen_by_its_name(file, overrides):
    settings = load_settings(Settings, file, overrides)
    assert settings.servo == ImageBased(jacobian="mean", gain=3.0)
    assert as_dict(settings)["servo"]["kind"] == "image_based"


def test_a_number_or_a_dataclass_is_told_by_what_is_given(file):
    settings = load_settings(Settings, None, ["servo=hybrid", "servo.gain.near=5"])
    assert settings.servo.gain == AdaptiveGain(near=5.0)


@pytest.mark.parametrize(
    ("override", "message"),
    [
        ("servo=magnetic", r"setting servo: must be one of position_based, image_based, hybrid, got 'magnetic'"),
        ("servo.jacobian=mean", r"unknown setting servo\.jacobian; allowed are servo\.gain"),
        ("servo.gain.naer=3", r"unknown setting servo\.gain\.naer; allowed are servo\.gain\.near"),
        ("servo.gain.near=0.5", r"gain\.far must be positive and below gain\.near"),
        ("servo.gian=2", r"unknown setting servo\.gian; allowed are servo\.gain, .* Did you mean servo\.gain\?"),
        ("servo.gain=fast", r"setting servo\.gain: .*valid number.*got 'fast'"),
        ("servo.gain=-1", r"gain must be positive, got -1\.0"),
        ("servo=3", r"setting servo"),
        ("servo.max_turn=1e", r"setting servo\.max_turn: .*number"),
        ("camera.noise.x=3", r"setting camera\.noise: .*number"),
        ("object", "expected key=value"),
        ("object=[", "is not a YAML value"),
    ],
)
def test_bad_overrides_are_refused_in_one_line(file, override, message):
    with pytest.raises(InputError, match=message) as caught:
        load_settings(Settings, file, [override])
    assert "\n" not in str(caught.value)
