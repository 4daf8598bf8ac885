"""Starts in real recordings, whose models are not exact: edges that all lie a little off fit closer in wrong places too."""

import numpy as np
import pytest

from vipr.systems import se3
from vipr.systems.camera.image_files import ImageSequence
from vipr.systems.camera.lens import load_lens
from vipr.systems.tracking.belief import start
from vipr.systems.tracking.cad_model import load_model
from vipr.systems.tracking.evaluation import corner_distances, read_poses
from vipr.systems.tracking.model_tracking import step

FRAMES = 3  # after which the pose is compared
WRONG_PX = 3.0  # RMS of the corners


@pytest.mark.parametrize("name", ["teabox", "blender_teabox"])
def test_a_start_a_little_off_the_reference_leads_to_it(shared_data, name):
    folder = shared_data / "tracking" / name
    model, lens = load_model(folder / "object.obj"), load_lens(folder / "camera.yaml")
    reference = read_poses(folder / "reference.csv")
    images = [lens.undistort(image) for _, image in ImageSequence(str(folder / "images"))]
    rng, wrong = np.random.default_rng(4), []
    begins = [k for k in reference if k + FRAMES in reference and k + FRAMES < len(images)]
    for k in begins[:: len(begins) // 8]:
        centre = reference[k][:3, :3] @ model.centre + reference[k][:3, 3]
        axis, way = (v / np.linalg.norm(v) for v in rng.normal(size=(2, 3)))
        R = se3.exp_so3(np.deg2rad(1.5) * axis) @ reference[k][:3, :3]
        belief = start(se3.pose(R, centre + 0.005 * way - R @ model.centre))
        for j in range(k, k + FRAMES + 1):
            belief = step(belief, images[j], 0.04 * j, model, lens)
        off = np.sqrt(np.mean(corner_distances(model, lens, belief.X_CO, reference[k + FRAMES]) ** 2))
        wrong += [k] if off > WRONG_PX and belief.state == "tracking" else []
    assert not wrong
