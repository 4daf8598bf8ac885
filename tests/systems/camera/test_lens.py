"""The lens and its file."""

import numpy as np
import pytest

from vipr.systems.camera.lens import Lens, load_lens
from vipr.systems.errors import InputError

GOOD = "image_width: 640\nimage_height: 480\ncamera_matrix: {rows: 3, cols: 3, data: [800, 0, 320, 0, 810, 240, 0, 0, 1]}\n"


def test_ros_camera_info_is_read(tmp_path):
    (tmp_path / "camera.yaml").write_text(GOOD + "distortion_coefficients: {data: [0.1, 0, 0, 0, 0]}\n")
    lens = load_lens(tmp_path / "camera.yaml")
    assert (lens.width, lens.fx, lens.fy, lens.cx) == (640, 800, 810, 320)
    assert lens.distortion[0] == 0.1


def test_projection_is_the_pinhole():
    lens = Lens(640, 480, 800, 810, 320, 240)
    assert np.allclose(lens.project([[0.1, -0.2, 2.0]]), [[360, 159]])


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("image_width: 640\nimage_height: 480\n", "camera_matrix"),
        ("[1, 2]", "expected the fields of a ROS camera_info"),
        ("a: [", "cannot be read"),
        (GOOD.replace("800", "-800"), "focal lengths must be positive"),
        (GOOD.replace("800", ".nan"), "finite"),
        (GOOD.replace("[800, 0,", "[800,"), "9 numbers"),
        (GOOD + "distortion_model: fisheye\ndistortion_coefficients: [0.1, 0, 0, 0]\n", "distortion_model must be"),
    ],
)
def test_a_bad_camera_file_is_one_clear_line(tmp_path, text, message):
    path = tmp_path / "camera.yaml"
    path.write_text(text)
    with pytest.raises(InputError, match=message):
        load_lens(path)
