"""An object that stands on a known surface is placed far better than one that is only seen."""

import numpy as np

from vipr.diagrams.workcell_layout import fixed_camera
from vipr.systems import se3
from vipr.systems.grasping.support import Support, settled, settled_doubt

SUPPORT = Support(0.52, np.array([-0.03, -0.03, 0.0]), np.array([0.03, 0.03, 0.12]))
X_WO = se3.pose(se3.exp_so3(np.array([0.0, 0.0, 0.4])), [0.55, 0.05, 0.52])
UP = np.array([0.0, 0.0, 1.0])


def test_an_error_along_the_line_of_sight_and_a_tilt_are_taken_away():
    X_WC = fixed_camera()
    middle = X_WO[:3, 3] + [0.0, 0.0, 0.06]
    ray = middle - X_WC[:3, 3]
    tilt = se3.exp_so3(np.array([0.05, 0.03, 0.0]))
    seen_middle = middle + 0.02 * ray / np.linalg.norm(ray)
    seen = se3.pose(tilt @ X_WO[:3, :3], seen_middle - tilt @ X_WO[:3, :3] @ [0.0, 0.0, 0.06])
    found = settled(seen, UP, SUPPORT, X_WC)
    np.testing.assert_allclose(found[:3, 3], X_WO[:3, 3], atol=1e-9)
    assert found[2, 2] > 1 - 1e-12
    assert se3.angle_between(found[:3, :3], X_WO[:3, :3]) < 2e-3


def test_the_doubt_is_that_across_the_line_of_sight_by_its_slope():
    X_WC = fixed_camera()
    slope = abs((X_WO[:3, 3] - X_WC[:3, 3])[2]) / np.linalg.norm(X_WO[:3, 3] - X_WC[:3, 3])
    doubt = settled_doubt(X_WO, np.diag([1e-6, 0.0, 1.0e-4]), X_WC)
    assert 1e-3 / slope < doubt < 2.5e-3 / slope  # little of the 10 mm along it is left
