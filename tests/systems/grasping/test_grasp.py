"""Grasps as data: files, refusals, symmetry."""

from dataclasses import replace

import numpy as np
import pytest

from vipr.models import model_path, object_names
from vipr.systems import se3
from vipr.systems.errors import InputError
from vipr.systems.grasping.candidates import Solid, candidates, resting_pose, rests, symmetry
from vipr.systems.grasping.grasp import Grasp, GraspTable, Symmetry, load_grasps, save_grasps
from vipr.systems.grasping.options import suitable, unrolled
from vipr.systems.grasping.payload import DYNAMIC_LOAD, dynamic_load
from vipr.systems.tracking.cad_model import load_model

GRASP = Grasp(
    name="above",
    X_OG=se3.pose(np.diag([1.0, -1.0, -1.0]), [0.01, 0.0, 0.10]),
    spread=0.2,
    preshape=np.full(3, 0.9),
    closed=np.full(3, 1.1),
    quality=0.1,
    held=1.0,
)
TABLE = GraspTable("box", 0.4, Symmetry(np.array([0.0, 0.0, 0.05]), "z"), (GRASP,))


@pytest.mark.parametrize("name", object_names())
def test_every_object_has_grasps_that_the_hand_can_do(name):
    table = load_grasps(model_path(f"{name}/grasps.yaml"))
    assert table.object == name and all(grasp.held > 0.6 and grasp.quality > 0 for grasp in table.grasps)


def test_a_table_comes_back_from_its_file(tmp_path):
    save_grasps(TABLE, tmp_path / "grasps.yaml", "by a test")
    again = load_grasps(tmp_path / "grasps.yaml")
    assert again.mass == 0.4 and again.symmetry.half_turns == "z"
    np.testing.assert_allclose(again.grasps[0].X_OG, GRASP.X_OG, atol=1e-5)
    np.testing.assert_allclose(again.grasps[0].closed, GRASP.closed, atol=1e-3)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"preshape": np.array([0.0, 2.6, 0.0])}, "finger_2 commanded to 149.0 deg, allowed 0 to 140 deg"),
        ({"spread": -0.1}, "spread commanded to -5.7 deg"),
        ({"width": 0.32}, "320 mm is too wide, the hand opens to 291 mm"),
        ({"torque": np.array([0.8, 0.8, 5.0])}, "torque_nm must be above 0 and at most 1.8"),
        ({"approach": 1.0}, "approach_mm must be 20 to 300, got 1000"),
    ],
)
def test_a_grasp_that_the_hand_cannot_do_is_refused(change, message):
    with pytest.raises(InputError, match=message):
        replace(GRASP, **change).check()


def test_an_empty_table_and_a_heavy_object_are_refused():
    with pytest.raises(InputError, match="the table is empty; teach some"):
        replace(TABLE, grasps=()).check()
    with pytest.raises(InputError, match=r"3 kg is too heavy, the arm carries 2\.5 kg, 1\.4 kg beside the hand"):
        TABLE.check(3.0)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("object: box\n", "'mass_kg' is missing"),
        (
            "object: box\nmass_kg: 1\ncentre_mm: [0, 0]\nhalf_turns: x\nrevolution: true\n",
            "centre_mm must be 3 numbers",
        ),
        (": : :", "g.yaml: while parsing"),
    ],
)
def test_a_broken_file_is_named_with_what_is_wrong(text, message, tmp_path):
    (tmp_path / "g.yaml").write_text(text)
    with pytest.raises(InputError, match=message):
        load_grasps(tmp_path / "g.yaml")


def test_what_looks_the_same_can_be_grasped_the_same():
    upright = se3.pose(np.eye(3), [0.5, 0.0, 0.5])
    assert len(suitable(TABLE, upright)) == 2  # as taught, and turned by half
    assert not suitable(
        TABLE, upright @ se3.pose(np.diag([1.0, -1.0, -1.0]), np.zeros(3))
    )  # upside down is another thing
    half = suitable(TABLE, upright)[1]
    np.testing.assert_allclose(half.X_OG[:3, 3], [-0.01, 0.0, 0.10], atol=1e-12)


def test_a_grasp_that_lets_too_much_hang_too_far_out_of_the_wrist_is_never_chosen():
    far = replace(GRASP, name="far", X_OG=se3.pose(np.diag([1.0, -1.0, -1.0]), [0.0, 0.0, 0.25]), quality=1.0)
    table = replace(TABLE, grasps=(far, GRASP))
    assert {grasp.name for grasp in suitable(table, se3.pose(np.eye(3), [0.5, 0.0, 0.5]))} == {"above"}
    assert table.load(GRASP) < DYNAMIC_LOAD < table.load(far)
    with pytest.raises(
        InputError, match=r"0.4 kg is too heavy so far out, 0.0761 kg m2 about joint 5 with the hand, allowed 0.0403"
    ):
        replace(TABLE, grasps=(far,)).check()


def test_the_dynamic_load_is_a_moment_of_inertia_about_joint_5():
    held_at = se3.pose(se3.exp_so3(np.array([0.3, 0.2, -0.5])), [0.02, -0.01, 0.03])
    p_5O = [0.0, 0.0, 0.05625 + 0.135] + se3.inverse(held_at)[:3, 3]
    hand = dynamic_load(held_at, 0.0, np.zeros(3))
    assert hand == pytest.approx(1.1 * 0.11625**2)
    assert dynamic_load(held_at, 0.4, np.zeros(3)) == pytest.approx(hand + 0.4 * np.linalg.norm(p_5O) ** 2)


def test_a_rolled_lying_round_is_believed_with_its_x_up_and_an_upright_one_as_it_is_seen():
    lying = se3.pose(se3.exp_so3(np.array([0.0, -np.pi / 2, 0.0])), [0.5, 0.1, 0.55])
    rolled = lying @ se3.pose(se3.exp_so3(np.array([0.0, 0.0, 2.1])), np.zeros(3))
    np.testing.assert_allclose(unrolled(Symmetry(revolution=True), rolled), lying, atol=1e-12)
    np.testing.assert_array_equal(unrolled(Symmetry(), rolled), rolled)
    np.testing.assert_array_equal(unrolled(Symmetry(revolution=True), np.eye(4)), np.eye(4))


def test_a_lying_round_is_grasped_where_its_way_up_is():
    round_ = replace(
        TABLE, mass=0.2, symmetry=Symmetry(revolution=True), grasps=(replace(GRASP, up=np.array([1.0, 0.0, 0.0])),)
    )
    roll = se3.pose(se3.exp_so3(np.array([0.0, 0.0, 0.7])), np.zeros(3))
    lying = se3.pose(se3.exp_so3(np.array([0.0, -np.pi / 2, 0.0])), np.zeros(3))  # O's x points up
    (there,), (as_taught,) = suitable(round_, lying @ roll), suitable(round_, lying)
    np.testing.assert_allclose((lying @ roll @ there.X_OG)[2], (lying @ as_taught.X_OG)[2], atol=1e-12)


@pytest.mark.parametrize(
    ("name", "half_turns", "revolution", "ways"),
    [("rice_box", "xyz", False, 3), ("milk_carton", "z", False, 3), ("can", "x", True, 2), ("bottle", "", True, 2)],
)
def test_symmetry_and_ways_to_rest_are_found_from_the_shape(name, half_turns, revolution, ways):
    model = load_model(model_path(f"{name}/model.yaml"))
    found = symmetry(model)
    assert (found.half_turns, found.revolution, len(rests(model))) == (half_turns, revolution, ways)


def test_candidates_leave_room_between_hand_and_support():
    model = load_model(model_path("rice_box/model.yaml"))
    solid = Solid.of(model)
    for up in rests(model):
        X_WO = resting_pose(solid, up)
        corners = model.corners @ X_WO[:3, :3].T + X_WO[:3, 3]
        assert corners[:, 2].min() == pytest.approx(0.0, abs=1e-9)
        for grasp in candidates(solid, up):
            X_WG = X_WO @ grasp.X_OG
            assert X_WG[2, 2] < -0.99 or X_WG[2, 3] > 0.0445, grasp.name  # from above, or the palm clear of the table
