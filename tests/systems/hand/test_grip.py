"""A box is pinched, lifted and held by contact and friction alone."""

import numpy as np
import pytest
from pydrake.math import RigidTransform, RotationMatrix
from pydrake.multibody.parsing import Parser
from pydrake.multibody.plant import AddMultibodyPlantSceneGraph
from pydrake.multibody.tree import PdControllerGains, PrismaticJoint, SpatialInertia
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder

from vipr.models import model_path
from vipr.systems.hand.driver import HandDriver
from vipr.systems.hand.torque_switch import PINCH, Drives

MOUNT = 0.305  # m, height of the mounting face over the table while the hand closes


@pytest.fixture(scope="module")
def lifted():
    """Poses X_PO of the box in the palm after closing, after a lift of 0.1 m, after holding; and the clutches."""
    builder = DiagramBuilder()
    plant, _ = AddMultibodyPlantSceneGraph(builder, 0.002)
    plant.set_stiction_tolerance(1e-4)
    parser = Parser(plant)
    parser.AddModels(str(model_path("table/table.sdf")))
    parser.AddModels(str(model_path("rice_box/rice_box.sdf")))
    (hand,) = parser.AddModels(str(model_path("barrett_hand/barrett_hand.sdf")))
    plant.WeldFrames(plant.world_frame(), plant.GetFrameByName("top"))
    lift = plant.AddModelInstance("lift")
    carriage = plant.AddRigidBody("carriage", lift, SpatialInertia.SolidSphereWithMass(2.0, 0.05))
    joint = plant.AddJoint(PrismaticJoint("lift", plant.world_frame(), carriage.body_frame(), [0, 0, 1]))
    plant.AddJointActuator("lift", joint, 1e4).set_controller_gains(PdControllerGains(p=2e5, d=6e3))
    palm, box = plant.GetFrameByName("palm"), plant.GetBodyByName("rice_box")
    plant.WeldFrames(carriage.body_frame(), palm, RigidTransform(RotationMatrix.MakeXRotation(np.pi), [0, 0, 0]))
    plant.Finalize()
    driver = builder.AddNamedSystem("driver", HandDriver(Drives(torque_limit=PINCH), initial=[0.9, 0.9, 0.9, 0.0]))
    builder.Connect(driver.GetOutputPort("desired_state"), plant.get_desired_state_input_port(hand))
    builder.Connect(plant.get_state_output_port(hand), driver.GetInputPort("hand_state"))
    builder.Connect(plant.get_net_actuation_output_port(hand), driver.GetInputPort("joint_torque"))
    builder.ExportInput(driver.GetInputPort("motor_command"), "motor_command")
    builder.ExportInput(plant.get_desired_state_input_port(lift), "lift")
    diagram = builder.Build()
    simulator = Simulator(diagram)
    root = simulator.get_mutable_context()
    context = plant.GetMyContextFromRoot(root)
    plant.SetPositions(context, lift, [MOUNT])
    plant.SetPositions(context, hand, [0, 0.9, 0.3, 0, 0.9, 0.3, 0.9, 0.3])
    plant.SetFreeBodyPose(context, box, RigidTransform())
    command, height = diagram.GetInputPort("motor_command"), diagram.GetInputPort("lift")
    height.FixValue(root, [MOUNT, 0])
    poses = []

    def note():
        poses.append(palm.CalcPoseInWorld(context).inverse() @ box.EvalPoseInWorld(context))

    for t in np.arange(0.02, 0.61, 0.02):
        command.FixValue(root, np.append(np.full(3, 0.9 + 0.8 * t), 0))
        simulator.AdvanceTo(t)
    motors = driver.GetMyContextFromRoot(root)
    command.FixValue(root, driver.GetOutputPort("motor_position").Eval(motors).copy())
    simulator.AdvanceTo(0.8)
    note()
    for s in np.arange(0.02, 1.01, 0.02):
        rise = 0.1 * (s - np.sin(2 * np.pi * s) / (2 * np.pi))
        height.FixValue(root, [MOUNT + rise, 0.2 * (1 - np.cos(2 * np.pi * s))])
        simulator.AdvanceTo(0.8 + 0.5 * s)
    height.FixValue(root, [MOUNT + 0.1, 0])
    note()
    simulator.AdvanceTo(2.3)
    note()
    return poses, driver.GetOutputPort("clutch").Eval(motors).copy(), box.EvalPoseInWorld(context)


def test_the_box_is_in_the_air_and_upright(lifted):
    X_WO = lifted[2]
    assert X_WO.translation()[2] > 0.098
    assert X_WO.rotation().matrix()[2, 2] > np.cos(np.radians(2))


def test_it_hardly_slips(lifted):
    closed, up, held = (X.translation() for X in lifted[0])
    assert np.linalg.norm(up - closed) < 1e-3
    assert np.linalg.norm(held - up) < 2e-4


def test_a_pinch_within_its_limits_leaves_the_clutches_seated(lifted):
    np.testing.assert_array_equal(lifted[1], 1)
