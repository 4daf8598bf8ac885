"""The pick robot's map and that of its task with a place: every wire, and none from truth to the task."""

from vipr.diagrams.pick import PickRobot
from vipr.diagrams.pick_then_place import PickThenPlace

import laws
from examples import EXAMPLES

WIRES = [
    "arm.desired_state -> workcell.arm_desired_state",
    "task.V_WE_W -> arm.V_WE_W",
    "task.initial_pose -> tracker.initial_pose",
    "task.motor_command -> workcell.motor_command",
    "task.torque_limit -> workcell.torque_limit",
    "tracker.object_pose -> annotator.object_pose",
    "tracker.object_pose -> task.object_pose",
    "tracker.object_pose -> tracking_error.object_pose",
    "workcell.X_CO_true -> tracking_error.X_CO_true",
    "workcell.frame -> annotator.frame",
    "workcell.frame -> tracker.frame",
    "workcell.joint_state -> task.joint_state",
    "workcell.motor_position -> task.motor_position",
    "workcell.motor_torque -> task.motor_torque",
]


def test_the_task_is_fed_by_these_wires_and_no_others():
    robot, _ = EXAMPLES[PickRobot]()
    assert laws.wires(robot) == WIRES


def test_the_servo_takes_over_from_the_pick_through_these_wires_and_no_others():
    task, _ = EXAMPLES[PickThenPlace]()
    assert laws.wires(task) == [
        "pick.V_WE_W -> hand_over.V_pick",
        "pick.phase -> hand_over.pick_phase",
        "pick.watching -> hand_over.pick_watching",
        "servo.V_WE_W -> hand_over.V_place",
        "servo.servo_error -> hand_over.servo_error",
        "servo.status -> hand_over.servo_status",
    ]
