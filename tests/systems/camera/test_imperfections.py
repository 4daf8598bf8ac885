"""The camera's imperfections are what their names say, and repeat with the seed."""

import numpy as np
import pytest

from vipr.systems.camera.imperfections import ImperfectCamera, Imperfection
from vipr.systems.errors import InputError

PLAIN = Imperfection(noise=0, blur=0)
IMAGE = np.full((48, 64, 3), 100, np.uint8)


def camera(seed=1, **changes):
    return ImperfectCamera(Imperfection(**{"noise": 0, "blur": 0, **changes}), 64, 48, seed)


def test_a_perfect_camera_changes_nothing():
    assert np.array_equal(camera().expose(IMAGE, 0), IMAGE)


def test_noise_has_the_stated_strength_and_differs_between_frames():
    dut = camera(noise=5.0)
    first, second = (dut.expose(IMAGE, k).astype(float) for k in (0, 1))
    assert np.std(first) == pytest.approx(5.0, rel=0.05)
    assert np.mean(first) == pytest.approx(100, abs=0.2)
    assert not np.array_equal(first, second)
    assert np.array_equal(camera(noise=5.0).expose(IMAGE, 1), second)
    assert not np.array_equal(camera(noise=5.0, seed=2).expose(IMAGE, 1), second)


def test_exposure_and_cast_scale_the_channels():
    got = camera(exposure=0.5, colour_cast=(1.0, 0.8, 0.6)).expose(IMAGE, 0)
    assert got[0, 0].tolist() == [30, 40, 50]  # blue, green, red


def test_bright_pixels_clip():
    assert camera(exposure=4.0).expose(IMAGE, 0).max() == 255


def test_blur_spreads_an_edge():
    step = np.zeros((48, 64, 3), np.uint8)
    step[:, 32:] = 200
    width = np.count_nonzero(np.diff(camera(blur=2.0).expose(step, 0)[20, :, 0].astype(int)))
    assert width > 5


def test_frames_drop_at_the_stated_rate():
    dut = camera(dropped=0.2)
    assert np.mean([dut.drops(k) for k in range(2000)]) == pytest.approx(0.2, abs=0.03)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"noise": -1}, "noise must be 0 to 255"),
        ({"exposure": 0}, "must be positive"),
        ({"dropped": 2}, "dropped must be 0 to 1"),
    ],
)
def test_impossible_values_are_refused(changes, message):
    with pytest.raises(InputError, match=message):
        Imperfection(**changes)
