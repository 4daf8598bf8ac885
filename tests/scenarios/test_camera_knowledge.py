"""What a scenario believes of its camera."""

from dataclasses import replace

import numpy as np
import pytest
import yaml

from vipr.diagrams.workcell_layout import fixed_camera
from vipr.models import model_path
from vipr.scenarios.align import Align, AlignSettings
from vipr.scenarios.camera_knowledge import CameraKnowledge
from vipr.scenarios.settings import load_settings
from vipr.systems import se3
from vipr.systems.camera.lens import load_lens, save_lens
from vipr.systems.errors import InputError

LENS, X_WC = load_lens(model_path("xc77/camera.yaml")), fixed_camera()


@pytest.fixture
def folder(tmp_path):
    """As ``vipr calibrate`` leaves it: a lens a little longer, the camera 10 mm aside."""
    save_lens(tmp_path / "camera.yaml", replace(LENS, fx=1.01 * LENS.fx))
    found = X_WC + np.array([[0, 0, 0, 0.01]] + [[0] * 4] * 3)
    (tmp_path / "X_WC.yaml").write_text(yaml.safe_dump({"X_WC": found.tolist()}))
    return tmp_path


def test_by_default_the_truth_is_known():
    lens, X = CameraKnowledge().believed(LENS, X_WC, seed=1)
    assert lens == LENS and np.array_equal(X, X_WC)


def test_a_calibration_is_believed_by_the_robot_and_not_by_the_world(folder):
    settings = load_settings(AlignSettings, None, [f"calibration.folder={folder}"])
    scenario = Align(settings, seed=2)
    assert scenario.lens.fx == pytest.approx(1.01 * LENS.fx) and scenario.X_WC[0, 3] == pytest.approx(X_WC[0, 3] + 0.01)
    assert scenario.config.lens == LENS and np.array_equal(scenario.config.X_WC, X_WC)
    assert np.array_equal(scenario.task().X_WC, scenario.X_WC)


def test_errors_have_the_size_that_is_asked_for_and_the_seed_their_direction():
    knowledge = CameraKnowledge(focal_error_percent=10, X_WC_error_mm=50, X_WC_error_deg=5)
    beliefs = [knowledge.believed(LENS, X_WC, seed) for seed in (1, 1, 2)]
    for lens, X in beliefs:
        error = se3.difference(X_WC, X)
        assert np.linalg.norm(error[3:]) == pytest.approx(0.05) and np.linalg.norm(error[:3]) == pytest.approx(
            np.deg2rad(5)
        )
        assert (lens.fx, lens.fy) == pytest.approx((1.1 * LENS.fx, 1.1 * LENS.fy))
    assert np.array_equal(beliefs[0][1], beliefs[1][1]) and not np.allclose(beliefs[0][1], beliefs[2][1])


def test_errors_and_folders_that_cannot_be_are_refused(folder, tmp_path):
    with pytest.raises(InputError, match=r"calibration\.X_WC_error_mm must be 0 to 500 mm, got -1"):
        CameraKnowledge(X_WC_error_mm=-1)
    with pytest.raises(InputError, match="cannot be read"):
        CameraKnowledge(folder=str(tmp_path / "none")).believed(LENS, X_WC, 1)
    save_lens(folder / "camera.yaml", replace(LENS, width=320, height=240))
    with pytest.raises(InputError, match="of images of 320 x 240 px, the camera's are 640 x 480 px"):
        CameraKnowledge(folder=str(folder)).believed(LENS, X_WC, 1)


def test_a_saved_lens_is_read_back(tmp_path):
    lens = replace(LENS, distortion=(-0.2, 0.1, 0.0, 0.0, 0.0))
    save_lens(tmp_path / "camera.yaml", lens)
    assert load_lens(tmp_path / "camera.yaml") == lens
