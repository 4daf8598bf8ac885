"""The Barrett Hand's model against finger points from an independent implementation, to 1e-9."""

import numpy as np
import pytest
from pydrake.multibody.parsing import Parser
from pydrake.multibody.plant import MultibodyPlant

from vipr.models import model_path
from vipr.systems.hand import transmission

MOUNT_TO_K = 0.0754  # m: the vectors' origin lies at the height of the fingers' base joints
VECTOR_TIP = np.array([0.05, 0, 0])  # the vectors' tip on the outer link


@pytest.fixture(scope="module")
def hand():
    plant = MultibodyPlant(0.001)
    Parser(plant).AddModels(str(model_path("barrett_hand/barrett_hand.sdf")))
    plant.WeldFrames(plant.world_frame(), plant.GetFrameByName("palm"))
    plant.Finalize()
    return plant


@pytest.fixture(scope="module")
def vectors(shared_facts):
    return np.load(shared_facts / "barrett_vectors.npz")


def test_loads_without_a_warning(caplog):
    plant = MultibodyPlant(0.001)
    Parser(plant).AddModels(str(model_path("barrett_hand/barrett_hand.sdf")))
    plant.Finalize()
    assert not caplog.records


def test_joints_and_actuators_are_in_the_order_of_the_transmission(hand):
    joints = [hand.get_joint(i) for i in hand.GetJointIndices() if hand.get_joint(i).num_positions()]
    assert tuple(j.name() for j in joints) == transmission.JOINTS
    assert [j.position_start() for j in joints] == list(range(8))
    actuators = [hand.get_joint_actuator(i) for i in hand.GetJointActuatorIndices()]
    assert tuple(a.joint().name() for a in actuators) == transmission.JOINTS
    assert all(a.has_controller() for a in actuators)
    np.testing.assert_allclose(hand.GetPositionUpperLimits(), transmission.JOINT_UPPER, rtol=0, atol=1e-9)
    np.testing.assert_array_equal(hand.GetPositionLowerLimits(), 0)


def test_coupled_fingers_are_where_the_vectors_say(hand, vectors):
    motor = np.column_stack([vectors["q2"], vectors["spread"]])
    joints = np.array([transmission.joint_angles(m, transmission.SEATED) for m in motor])
    np.testing.assert_allclose(joints[:, [2, 5, 7]], vectors["q3"], rtol=0, atol=1e-9)
    check_fingers(hand, joints, vectors["jhu_tip"], vectors["jhu_distal_frame"])


def test_broken_away_fingers_are_where_the_vectors_say(hand, vectors):
    motor = np.column_stack([vectors["bk_motor_rad"] / transmission.FINGER_RATIO, vectors["spread"]])
    joints = np.array([transmission.joint_angles(m, b) for m, b in zip(motor, vectors["bk_b"], strict=True)])
    np.testing.assert_allclose(joints[:, [2, 5, 7]], vectors["bk_q3"], rtol=0, atol=1e-9)
    check_fingers(hand, joints, vectors["bk_jhu_tip"])


def check_fingers(hand, joints, tips, frames=None):
    context = hand.CreateDefaultContext()
    for i, q in enumerate(joints):
        hand.SetPositions(context, q)
        for k in range(3):
            X_KD = hand.GetFrameByName(f"finger_{k + 1}_outer").CalcPoseInWorld(context).GetAsMatrix4()
            X_KD[2, 3] -= MOUNT_TO_K
            np.testing.assert_allclose(X_KD[:3, :3] @ VECTOR_TIP + X_KD[:3, 3], tips[i, k], rtol=0, atol=1e-9)
            if frames is not None:
                np.testing.assert_allclose(X_KD, frames[i, k], rtol=0, atol=1e-9)


def test_the_mass_is_that_of_the_hand(hand):
    assert hand.CalcTotalMass(hand.CreateDefaultContext()) == pytest.approx(1.0985, abs=1e-4)
