"""Connected components against OpenCV's."""

import cv2
import numpy as np
import pytest

from vipr.systems.skin.density import components


@pytest.mark.parametrize("seed", range(8))
def test_components_areas_and_boxes_are_those_of_opencv(seed):
    rng = np.random.default_rng(seed)
    dense = cv2.GaussianBlur(rng.random(rng.integers(1, 60, 2)).astype(np.float32), (0, 0), 0.6 + 0.2 * seed)
    dense = cv2.normalize(dense, None, 0, 255, cv2.NORM_MINMAX).astype(np.uint8)
    labels, areas, boxes = components(dense, 128, 1.0, 250)
    n, expected, stats, _ = cv2.connectedComponentsWithStats((dense > 128).astype(np.uint8), connectivity=8)
    assert len(areas) == n - 1 and np.all(np.diff(areas) <= 0)
    assert ((labels > 0) == (expected > 0)).all()
    for k, (area, box) in enumerate(zip(areas, boxes, strict=True), 1):
        other = expected[labels == k]
        assert len(set(other.tolist())) == 1
        assert area == stats[other[0], cv2.CC_STAT_AREA] and box.tolist() == stats[other[0], :4].tolist()


def test_small_components_and_those_beyond_the_most_are_left_out():
    dense = np.zeros((20, 40), np.uint8)
    dense[2:4, 2:4] = dense[2:8, 10:14] = dense[2:9, 20:28] = 255
    labels, areas, boxes = components(dense, 120, 5.0, 8)
    assert areas.tolist() == [56.0, 24.0] and not labels[2:4, 2:4].any() and boxes[1].tolist() == [10, 2, 4, 6]
    assert components(dense, 120, 1.0, 1)[1].tolist() == [56.0]
    assert components(dense * 0, 120, 1.0, 8)[2].shape == (0, 4)
