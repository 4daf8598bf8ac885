"""The servo robot's map: every wire, and none from truth to a controller."""

from vipr.diagrams.servo_robot import Schedule, ServoRobot

import laws
from examples import EXAMPLES

WIRES = [
    "arm.desired_state -> limit_use.desired_state",
    "arm.desired_state -> workcell.arm_desired_state",
    "servo.V_WE_W -> arm.V_WE_W",
    "tracker.object_pose -> annotator.object_pose",
    "tracker.object_pose -> servo.object_pose",
    "tracker.object_pose -> tracking_error.object_pose",
    "workcell.X_CO_true -> tracking_error.X_CO_true",
    "workcell.X_WE_true -> alignment_error.X_WE_true",
    "workcell.X_WO_true -> alignment_error.X_WO_true",
    "workcell.frame -> annotator.frame",
    "workcell.frame -> tracker.frame",
    "workcell.joint_state -> servo.joint_state",
    "workcell.motor_position -> arm.motor_position",
]


def test_the_loop_is_closed_by_these_wires_and_no_others():
    robot, _ = EXAMPLES[ServoRobot]()
    assert laws.wires(robot) == WIRES


def test_delay_from_exposure_to_command_is_that_of_the_schedule():
    assert abs(Schedule().exposure_to_command - 0.024) < 1e-12
    assert abs(Schedule(delay_frames=2).exposure_to_command - 0.104) < 1e-12


def test_a_slow_tracker_stands_between_tracker_and_servo():
    robot, _ = EXAMPLES[ServoRobot](Schedule(delay_frames=2))
    wires = laws.wires(robot)
    assert "tracker.object_pose -> delay.object_pose" in wires and "delay.delayed_pose -> servo.object_pose" in wires
    assert "tracker.object_pose -> servo.object_pose" not in wires
