"""The workcell: what stands where, what the camera sees, and that the joint servo holds the arm."""

import numpy as np
import pytest
from pydrake.systems.analysis import Simulator

from vipr.diagrams.workcell import Workcell
from vipr.diagrams.workcell_layout import fixed_camera
from vipr.systems.hand.finger import GRASP_HEIGHT

from examples import EXAMPLES


@pytest.fixture(scope="module")
def run():
    """The workcell after a quarter of a second at rest."""
    system, fix = EXAMPLES[Workcell]()
    simulator = Simulator(system)
    fix(simulator.get_mutable_context(), 0.0)
    simulator.AdvanceTo(0.25)
    return system, simulator.get_context()


def test_only_the_object_is_free(run):
    plant = run[0].plant
    assert [plant.get_body(i).name() for i in plant.GetFloatingBaseBodies()] == ["milk_carton"]


def test_camera_is_two_metres_from_the_stage_and_sees_it_in_the_middle(run):
    system, context = run
    X_CO = system.GetOutputPort("X_CO_true").Eval(context)
    assert np.linalg.norm(X_CO.translation()) == pytest.approx(2.0, abs=0.1)
    middle = system.config.lens.project(X_CO.multiply([0, 0, 0.16]))
    assert np.allclose(middle, [319.5, 239.5], atol=3.0)
    assert np.allclose(fixed_camera()[:3, :3] @ fixed_camera()[:3, :3].T, np.eye(3))


def test_frame_shows_the_carton_where_truth_says(run):
    system, context = run
    frame = system.GetOutputPort("frame").Eval(context)
    X_CO = system.GetOutputPort("X_CO_true").Eval(context)
    u, v = np.round(system.config.lens.project(X_CO.multiply([0.036, 0.0, 0.02]))).astype(int)
    blue, green, red = frame.image[v, u].astype(int)
    assert green > red + 20 and green > blue + 20, "the carton's green foot"
    assert frame.time == pytest.approx(0.24) and frame.number == 6


def test_joint_servo_holds_the_arm_to_half_a_milliradian(run):
    system, context = run
    q = system.GetOutputPort("joint_state").Eval(context)[:6]
    assert np.abs(q - system.config.q_initial).max() < 5e-4


def test_kinematics_of_the_controller_are_those_of_the_plant(run):
    system, context = run
    plant = system.plant
    grasp = plant.GetFrameByName("grasp").GetFixedPoseInBodyFrame()
    assert np.allclose(grasp.translation(), [0, 0, GRASP_HEIGHT])
    X_WE = system.GetOutputPort("X_WE_true").Eval(context).GetAsMatrix4()
    q = plant.GetPositions(plant.GetMyContextFromRoot(context), plant.GetModelInstanceByName("puma560"))
    assert np.allclose(system.arm.tool_pose(q), X_WE, atol=1e-9)
