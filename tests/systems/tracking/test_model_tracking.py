"""The tracker follows a drawn box, and says what it cannot read."""

import numpy as np
import pytest
from drawn_objects import LENS, box, picture, pose_at

from vipr.systems import se3
from vipr.systems.errors import InputError
from vipr.systems.tracking.model_tracking import start, step


def test_a_turning_box_is_followed():
    model, belief = box(), start(pose_at(0.0))
    for k in range(15):
        belief = step(belief, picture(model, pose_at(0.04 * k)), 0.04 * k, model, LENS)
        assert belief.state == "tracking"
    assert np.linalg.norm(belief.X_CO[:3, 3] - pose_at(0.56)[:3, 3]) < 2e-3
    assert np.degrees(se3.angle_between(belief.X_CO, pose_at(0.56))) < 0.5


def test_a_pose_behind_the_camera_is_refused():
    with pytest.raises(InputError, match="in front of the camera"):
        start(se3.pose(np.eye(3), np.array([0.0, 0.0, -1.0])))
