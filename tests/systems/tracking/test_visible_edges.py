"""What of a model a camera sees: faces hide edges, bodies hide bodies, cylinders show limbs and rims."""

import numpy as np
from drawn_objects import LENS, box, l_shape

from vipr.systems import se3
from vipr.systems.tracking.cad_model import Shape, build_model
from vipr.systems.tracking.triangulation import box_triangles
from vipr.systems.tracking.visible_edges import visible_nodes

FACING = se3.pose(se3.exp_so3(np.array([np.pi, 0, 0])), np.array([0.0, 0.0, 0.4]))  # O's z towards the camera


def turned(x, y, z, depth=0.4):
    return se3.pose(se3.exp_so3(np.array([x, y, z])), np.array([0.0, 0.0, depth]))


def test_of_a_box_seen_from_the_front_only_the_front_face_has_nodes():
    nodes = visible_nodes(box(), FACING, LENS)
    assert len(set(nodes.edge)) == 4
    assert np.allclose(nodes.p_O[:, 2], 0.025)


def test_of_a_turned_box_nine_edges_are_seen_and_six_have_the_background_on_one_side():
    nodes = visible_nodes(box(), turned(0.5, 0.6, 0.1), LENS)
    assert len(set(nodes.edge)) == 9
    assert len({e for e, inside in zip(nodes.edge, nodes.inside, strict=True) if not inside.all()}) == 6


def test_the_inside_of_a_contour_is_on_the_side_of_the_object():
    X_CO = turned(0.5, 0.6, 0.1)
    nodes = visible_nodes(box(), X_CO, LENS)
    contour = ~nodes.inside.all(1)
    towards = LENS.project(X_CO[:3, 3]) - nodes.pixel
    side = np.where(nodes.inside[:, 0], 1.0, -1.0) * (towards * nodes.normal).sum(1)
    assert (side[contour] > 0).all()


def test_nodes_stand_at_regular_intervals_of_the_image():
    nodes = visible_nodes(box(), turned(0.2, 0.9, 0.0, 0.25), LENS, count=100, spacing=2.0)
    for edge in set(nodes.edge):
        gaps = np.linalg.norm(np.diff(nodes.pixel[nodes.edge == edge], axis=0), axis=1)
        assert np.allclose(gaps[1:-1], nodes.spacing, atol=0.05)


def test_the_arm_of_an_l_hides_what_is_behind_it():
    model = l_shape()
    R = np.array(
        [[0.0, 1.0, 0.0], [0.0, 0.0, -1.0], [-1.0, 0.0, 0.0]]
    )  # the camera looks from +x along -x, y to the right
    seen = visible_nodes(model, se3.pose(R, np.array([-0.05, 0.025, 0.4])), LENS)
    # The end of the foot, y from 0 to 50 mm, is in front; the arm's own end face shows above it, its root and back do not.
    assert seen.p_O[:, 0].min() > 0.04
    assert {round(x, 3) for x in seen.p_O[seen.p_O[:, 1] > 0.055, 0]} == {0.05}


def test_a_body_in_front_hides_edges():
    hand = box_triangles(np.array([0.04, 0.3, 0.01])) + (0.04, 0.0, 0.3)
    free, hidden = visible_nodes(box(), FACING, LENS), visible_nodes(box(), FACING, LENS, occluders_C=hand)
    assert (free.pixel[:, 0] > 100).any()
    assert not (hidden.pixel[:, 0] > 100).any()
    behind = box_triangles(np.array([0.04, 0.3, 0.01])) + (0.04, 0.0, 0.6)
    assert len(visible_nodes(box(), FACING, LENS, occluders_C=behind)) == len(free)


def test_a_cylinder_shows_its_limbs_where_the_line_of_sight_touches_it():
    model = build_model(Shape("can", cylinders=((np.array([0, -0.05, 0.0]), np.array([0, 0.05, 0.0]), 0.03),)))
    X_CO = turned(0.0, 0.0, 0.0)
    nodes = visible_nodes(model, X_CO, LENS)
    limb = nodes.edge < 2
    rays = nodes.p_O[limb] + X_CO[:3, 3]
    assert limb.any() and (~limb).any()
    assert np.allclose(np.hypot(nodes.p_O[limb, 0], nodes.p_O[limb, 2]), 0.03)
    assert np.allclose((nodes.p_O[limb] * (1, 0, 1) * rays).sum(1), 0.0, atol=1e-12)
    assert np.allclose(np.hypot(nodes.p_O[~limb, 0], nodes.p_O[~limb, 2]), 0.03)


def test_a_cap_that_looks_at_the_camera_shows_its_whole_rim():
    model = build_model(Shape("can", cylinders=((np.array([0, 0, -0.05]), np.array([0, 0, 0.05]), 0.03),)))
    nodes = visible_nodes(model, FACING, LENS)
    front = nodes.p_O[nodes.p_O[:, 2] > 0]
    angles = np.sort(np.arctan2(front[:, 1], front[:, 0]))
    assert np.diff(angles).max() < 0.4


def test_nothing_is_seen_of_what_is_behind_the_camera_or_out_of_view():
    assert len(visible_nodes(box(), se3.pose(np.eye(3), np.array([0, 0, -0.5])), LENS)) == 0
    assert len(visible_nodes(box(), se3.pose(np.eye(3), np.array([5.0, 0, 0.5])), LENS)) == 0


def test_a_body_that_reaches_behind_the_camera_is_cut_off_there():
    nodes = visible_nodes(box(), se3.pose(np.eye(3), np.array([0.0, 0.06, 0.01])), LENS)
    assert (nodes.depth > 0).all() and np.isfinite(nodes.pixel).all()
