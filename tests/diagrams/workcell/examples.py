"""Examples of the workcell's diagrams for the laws."""

import numpy as np

from vipr.diagrams.geometric_servo import GeometricServo
from vipr.diagrams.hand_bench import HandBench, HandBenchConfig
from vipr.diagrams.pick import PickRobot
from vipr.diagrams.pick_then_place import PickThenPlace
from vipr.diagrams.servo_robot import Schedule, ServoRobot
from vipr.diagrams.workcell import Workcell, WorkcellConfig
from vipr.diagrams.workcell_layout import JOINT_LIMITS, fixed_camera, puma_with_hand, standing
from vipr.models import model_path
from vipr.systems import se3
from vipr.systems.arm import puma560
from vipr.systems.grasping.grasp import load_grasps
from vipr.systems.grasping.pick import Picker
from vipr.systems.grasping.planning import Surroundings
from vipr.systems.servo.image_based import ImageBased
from vipr.systems.servo.tasks import Place, Reach
from vipr.systems.signals import ObjectPose
from vipr.systems.tracking.cad_model import load_model
from vipr.systems.tracking.geometric_sight import GeometricSight, SightErrors
from vipr.systems.truth import AlignmentError, KinematicTruth


def workcell():
    config = WorkcellConfig(supersampling=1)
    system = Workcell(config)

    def fix(context, t):
        system.GetInputPort("arm_desired_state").FixValue(context, np.concatenate([config.q_initial, np.zeros(6)]))
        system.GetInputPort("motor_command").FixValue(context, np.zeros(4))
        system.GetInputPort("stage_desired_state").FixValue(context, np.zeros(6))

    return system, fix


def servo_robot(schedule=Schedule()):
    config = WorkcellConfig(supersampling=1)
    X_CO = se3.inverse(config.X_WC) @ standing(config.stage_initial)
    X_OG = se3.pose(np.diag([1.0, -1.0, -1.0]), [0, 0, 0.3])
    model = load_model(model_path("milk_carton/model.yaml"))
    task = Reach(config.X_WC, X_OG, model.corners)
    system = ServoRobot(Workcell(config), model, X_CO, task, AlignmentError(X_OG), schedule=schedule)

    def fix(context, t):
        system.GetInputPort("motor_command").FixValue(context, np.zeros(4))
        system.GetInputPort("stage_desired_state").FixValue(context, np.zeros(6))

    return system, fix


def geometric_servo():
    arm, X_WC, q = puma_with_hand(), fixed_camera(), puma560.NAMED["nominal"]
    corners = load_model(model_path("milk_carton/model.yaml")).corners
    truth = KinematicTruth(arm, standing((0.0, 0.0, 0.0)), X_WC=X_WC)
    sight = GeometricSight(corners, SightErrors(lateral_noise=1e-4), hand_points=corners, seed=1)
    task = Reach(X_WC, se3.pose(np.diag([1.0, -1.0, -1.0]), [0, 0, 0.3]), corners)
    system = GeometricServo(arm, JOINT_LIMITS, q, truth, sight, task, ImageBased(), see_hand=True)
    return system, lambda context, t: system.get_input_port().FixValue(context, 0.01 * np.sin(np.arange(6) + t))


def pick_robot():
    config = WorkcellConfig(supersampling=1)
    model = load_model(model_path("milk_carton/model.yaml"))
    cell = Workcell(config)
    picker = Picker(
        load_grasps(model_path("milk_carton/grasps.yaml")), Surroundings(cell.arm, cell.joint_limits), config.X_WC
    )
    X_CO = se3.inverse(config.X_WC) @ standing(config.stage_initial)
    system = PickRobot(cell, model, picker, X_CO)

    def fix(context, t):
        system.GetInputPort("stage_desired_state").FixValue(context, np.zeros(6))

    return system, fix


def pick_then_place():
    arm, X_WC = puma_with_hand(), fixed_camera()
    model = load_model(model_path("milk_carton/model.yaml"))
    picker = Picker(load_grasps(model_path("milk_carton/grasps.yaml")), Surroundings(arm, JOINT_LIMITS), X_WC)
    X_CO = se3.inverse(X_WC) @ standing((0.0, 0.0, 0.0))
    shown = model.corners @ X_CO[:3, :3].T + X_CO[:3, 3]
    place = Place(X_WC, X_CO, model.corners, shown[:, :2] / shown[:, 2:])
    system = PickThenPlace(picker, X_CO, place=place)

    def fix(context, t):
        seen = ObjectPose(X_CO=X_CO, state="tracking", time=t, number=round(t / 0.04))
        system.GetInputPort("object_pose").FixValue(context, seen)
        system.GetInputPort("joint_state").FixValue(context, np.concatenate([puma560.NAMED["nominal"], np.zeros(6)]))
        system.GetInputPort("motor_position").FixValue(context, [0.1, 0.1, 0.1, 0.0])
        system.GetInputPort("motor_torque").FixValue(context, np.zeros(4))

    return system, fix


def hand_bench():
    system = HandBench(HandBenchConfig())

    def fix(context, t):
        system.GetInputPort("motor_command").FixValue(context, [t, t, t, 0.0])
        system.GetInputPort("torque_limit").FixValue(context, np.full(4, 1.8))
        system.GetInputPort("carriage_desired_state").FixValue(context, np.zeros(6))

    return system, fix


EXAMPLES = {
    GeometricServo: geometric_servo,
    Workcell: workcell,
    ServoRobot: servo_robot,
    PickRobot: pick_robot,
    PickThenPlace: pick_then_place,
    HandBench: hand_bench,
}
