"""Limbs and rims of round bodies are found where they are, beside shading and however curved."""

import numpy as np
import pytest

from vipr.systems import se3
from vipr.systems.camera.lens import Lens
from vipr.systems.tracking.belief import start
from vipr.systems.tracking.cad_model import Shape, build_model
from vipr.systems.tracking.displacements import normal_jacobian
from vipr.systems.tracking.edge_pass import placed_edges
from vipr.systems.tracking.limbs import UNSURE
from vipr.systems.tracking.settings import TrackerSettings
from vipr.systems.tracking.sight import Sight
from vipr.systems.tracking.visible_edges import visible_nodes

LENS = Lens(160, 160, 900.0, 900.0, 79.5, 79.5)
RADIUS, DISTANCE, FINER = 0.03, 1.0, 8
CAN = build_model(Shape("can", cylinders=((np.zeros(3), np.array([0.0, 0.0, 0.2]), RADIUS),)))
COIN = build_model(Shape("coin", circles=((np.zeros(3), np.array([0.0, 0.0, 1.0]), 0.006),)))
UPRIGHT = se3.pose(
    se3.exp_so3(np.array([0.5 * np.pi, 0.0, 0.0])), np.array([0.0013, 0.1, DISTANCE])
)  # fills the picture's height


def fine_pixels():
    """Rays (x, y, 1) through FINER x FINER places in each pixel, no two of them above or beside each other."""
    count = np.arange(LENS.width * FINER)
    between = (count % FINER + 0.5) / FINER - 0.5
    x, y = (count + 0.5 + between[:, None]) / FINER - 0.5, (count[:, None] + 0.5 + between) / FINER - 0.5
    return (x - LENS.cx) / LENS.fx, (y - LENS.cy) / LENS.fy


def as_image(fine, noise=0.0):
    image = fine.reshape(LENS.height, FINER, LENS.width, FINER).mean((1, 3))
    return np.clip(np.rint(image + noise * np.random.default_rng(0).normal(size=image.shape)), 0, 255).astype(np.uint8)


def shaded(background, light, noise=0.0, ground=20.0):
    """The upright can, matt, under a sky that is brightest in a direction (x, z)."""
    x, _ = fine_pixels()
    p, c = UPRIGHT[0, 3], x * x + 1.0  # the ray (x, 0, 1) s meets the cylinder about (p, DISTANCE)
    b = x * p + DISTANCE
    root = b * b - c * (p * p + DISTANCE**2 - RADIUS**2)
    s = (b - np.sqrt(np.maximum(root, 0.0))) / c
    across, towards = (s * x - p) / RADIUS, (s - DISTANCE) / RADIUS
    lit = ground + 80.0 * (1.0 + across * light[0] + towards * light[1])
    return as_image(np.where(root > 0.0, lit, background), noise)


def placed(model, X_CO, image, **options):
    """Offsets (N,) of the first sharp edges, their strength, the noise told, how far the nodes are trusted, and the nodes."""
    belief = start(X_CO)
    settings = TrackerSettings(**options)
    sight = Sight(image, model, LENS, settings, None, belief, belief.motion, 0.0, belief.motion)
    sight.open([X_CO], margin=20.0)
    nodes = visible_nodes(model, X_CO, LENS, 200, 3.0)
    matches, noise, certain, _ = placed_edges(sight, nodes, X_CO, 5.0, sharp=True)
    k = matches.wide
    return matches.offset[:, k], matches.strength[:, k], noise[:, k], certain * np.ones(len(nodes)), nodes


@pytest.mark.parametrize("background, light", [(20.0, (0.0, -1.0)), (200.0, (0.3, -0.95)), (220.0, (-0.6, -0.8))])
def test_a_limb_is_found_beside_its_shading(background, light):
    offset, strength, _, certain, nodes = placed(CAN, UPRIGHT, shaded(background, light))
    for limb in np.unique(nodes.edge[nodes.edge < 2]):
        here = (nodes.edge == limb) & (certain == 1.0) & (strength != 0.0)
        assert (
            here.sum() > 20 and abs(np.median(offset[here])) < 0.09
        )  # what part of the light comes from everywhere is unknown


def test_the_noise_of_a_limbs_place_is_told():
    offset, strength, noise, certain, nodes = placed(CAN, UPRIGHT, shaded(30.0, (0.0, -1.0), noise=2.0))
    here = (nodes.edge < 2) & (certain == 1.0) & (strength != 0.0)
    assert here.sum() > 30 and 0.4 < np.sqrt(np.mean((offset[here] / noise[here]) ** 2)) < 1.6


def test_a_limb_as_bright_as_what_is_behind_it_is_hardly_trusted():
    *_, certain, nodes = placed(CAN, UPRIGHT, shaded(100.0, (0.0, -1.0), noise=2.0))
    assert (certain[nodes.edge < 2] == UNSURE).mean() > 0.9


@pytest.mark.parametrize("tilt", [0.0, 1.0])
def test_a_narrow_rim_is_as_large_as_it_is(tilt):
    X_CO = se3.pose(se3.exp_so3(np.array([tilt, 0.0, 0.0])), np.array([0.0004, 0.0002, 0.6]))
    x, y = fine_pixels()
    n = X_CO[:3, 2]
    s = n @ X_CO[:3, 3] / (n[0] * x + n[1] * y + n[2])
    off = np.stack([s * x, s * y, s], -1) - X_CO[:3, 3]
    image = as_image(np.where((off**2).sum(-1) < 0.006**2, 190.0, 70.0))
    offset, strength, _, _, nodes = placed(COIN, X_CO, image)
    J = normal_jacobian(nodes, X_CO, LENS)
    closer = np.sign(J[:, 5])  # the edges of a nearer coin lie outside
    assert (strength != 0.0).all() and abs(np.mean(closer * offset)) < 0.03


def test_what_shading_may_hide_at_a_limb_is_told_as_common_to_its_nodes():
    belief = start(UPRIGHT)
    told = []
    for light in ((0.0, -1.0), (0.0, 0.0)):  # from the camera: steep shading at the limb; from everywhere: none
        image = shaded(20.0, light)
        sight = Sight(image, CAN, LENS, TrackerSettings(), None, belief, belief.motion, 0.0, belief.motion)
        sight.open([UPRIGHT], margin=20.0)
        nodes = visible_nodes(CAN, UPRIGHT, LENS, 200, 3.0)
        told.append(placed_edges(sight, nodes, UPRIGHT, 5.0, sharp=True)[3][nodes.edge < 2])
    steep, flat = (np.median(common) for common in told)
    assert 0.01 < steep < 0.2 and flat < 0.5 * steep
