"""The pick as a state machine, fed with senses that a test makes up: a perfect arm, a tracker that sees, fingers that feel or do not."""

from dataclasses import replace

import numpy as np
import pytest
from pick_doubles import TABLE, X_WO, picker, sighting

from vipr.systems import se3
from vipr.systems.arm import puma560
from vipr.systems.errors import InputError
from vipr.systems.grasping.pick_state import PHASES, PickSettings, Senses
from vipr.systems.grasping.support import Support
from vipr.systems.signals import ObjectPose


class World:
    """Plays the robot's part: the arm goes where it is told, fingers stop at ``stops`` and feel ``torque`` while ``feels(time)``."""

    def __init__(self, dut, *, stops=1.2, feels=lambda t: True, sees=lambda t: True, carried=True, met=-np.inf):
        self.dut, self.stops, self.feels, self.sees, self.carried = dut, stops, feels, sees, carried
        self.met = met  # m: below this height of the hand finger 2 is pushed
        self.X_CW = se3.inverse(dut.X_WC)
        self.state, self.time, self.phases = dut.start(self.X_CW @ X_WO), 0.0, ["look"]
        self.q, self.motors = puma560.NAMED["nominal"] + np.radians(5.0), np.zeros(4)
        self.X_WO, self.X_EO = X_WO, None

    def run(self, seconds):
        """Phases that came up to the end."""
        while self.time < seconds and not self.state.ended:
            self.step(0.02)
        return self.phases

    def step(self, dt):
        self.time += dt
        closed = self.state.phase not in ("look", "reach", "approach", "release", "retreat", "home")
        self.motors = np.minimum(self.state.command, [self.stops, self.stops, self.stops, 3.0])
        torque = np.array([1.0, 1.0, 1.8, 0.0]) * (closed and self.feels(self.time))
        torque[1] -= 0.5 * (self.dut.around.arm.tool_pose(self.q)[2, 3] < self.met)
        if self.state.phase == "lift" and self.X_EO is None:
            self.X_EO = se3.inverse(self.dut.around.arm.tool_pose(self.q)) @ self.X_WO
        if self.X_EO is not None and self.carried:
            self.X_WO = self.dut.around.arm.tool_pose(self.q) @ self.X_EO
        seen = sighting(self.time, self.X_WO) if self.sees(self.time) else ObjectPose()
        senses = Senses(self.time, self.q, self.motors, torque, seen)
        self.state = self.dut.step(self.state, senses)
        self.q = self.q + dt * self.dut.rates(self.state, senses)
        assert self.state.ended or self.state.phase in PHASES
        if self.state.phase != self.phases[-1]:
            self.phases.append(self.state.phase)


WHOLE = ["look", "reach", "approach", "close", "verify", "lift", "check", "carry", "hold", "confirm", "held"]


def test_a_pick_that_goes_well_runs_through_its_phases_and_carries_as_far_as_asked():
    world = World(picker(hold_s=0.5))
    assert world.run(30.0) == WHOLE
    moved = world.X_WO[:3, 3] - X_WO[:3, 3]
    np.testing.assert_allclose(moved[2], 0.15, atol=2e-3)
    np.testing.assert_allclose(np.linalg.norm(moved[:2]), 0.30, atol=2e-3)
    assert world.state.slip < 1e-3


def test_fingers_that_close_on_nothing_are_opened_and_the_arm_goes_back():
    world = World(picker(attempts=1), stops=2.4, feels=lambda t: False)
    assert world.run(30.0)[-4:] == ["release", "retreat", "home", "gave up"]
    assert "no grasp held in 1 attempts" in world.state.text
    assert not world.state.command[:3].any()


def test_with_no_other_grasp_left_it_says_so_after_the_first():
    world = World(picker(), stops=2.4, feels=lambda t: False)
    world.run(30.0)
    assert world.state.attempt == 1 and "no other grasp is known" in world.state.text


def test_another_grasp_is_tried_after_one_that_failed():
    dut = picker(hold_s=0.2)
    other = replace(TABLE.grasps[0], name="another", quality=0.1)
    dut = replace(dut, table=replace(TABLE, grasps=(*TABLE.grasps, other)))
    world = World(dut, feels=lambda t: world.state.attempt > 1)
    assert world.run(40.0)[-1] == "held"
    assert world.state.tried == ("above", "another")


def test_a_finger_that_meets_something_close_to_the_grasp_makes_the_hand_close_a_little_before_it():
    world = World(picker(hold_s=0.2), met=0.52 + 0.14 + 0.004)
    assert world.run(30.0) == WHOLE
    lowest = world.X_EO[2, 3]  # of the object's bottom before the hand that closed on it
    assert 0.14 + 0.006 < lowest < 0.14 + 0.012
    np.testing.assert_allclose(world.X_WO[:3, 2], [0, 0, 1], atol=0.02)


def test_a_finger_that_meets_something_far_from_the_grasp_sends_the_hand_back_the_way_it_came():
    world = World(picker(attempts=1), met=0.52 + 0.14 + 0.05)
    assert world.run(30.0)[-5:] == ["approach", "release", "retreat", "home", "gave up"]
    assert "attempts" in world.state.text


def test_an_error_in_what_is_seen_is_corrected_by_the_support_and_one_in_what_is_believed_is_not():
    dut = picker()
    support = Support(0.52, np.array([-0.03, -0.03, 0.0]), np.array([0.03, 0.03, 0.12]))
    dut = replace(dut, around=replace(dut.around, support=support), error=np.array([0.05, 0.0, 0.0, 0.0, 0.0, -0.01]))
    tilts, heights = {}, {}
    for believed in (False, True):
        world = World(replace(dut, error_believed=believed))
        world.run(0.5)
        tilts[believed], heights[believed] = world.state.X_WO[2, 2], world.state.X_WO[2, 3]
    assert tilts[False] > 1 - 1e-12 and heights[False] == pytest.approx(0.52, abs=1e-9)
    assert tilts[True] == pytest.approx(np.cos(0.05)) and heights[True] == pytest.approx(0.51, abs=1e-9)


def test_what_drops_while_it_is_carried_is_felt():
    world = World(picker(), feels=lambda t: world.state.phase != "hold")
    world.run(30.0)
    assert "release" in world.phases[world.phases.index("hold") :]


def test_what_is_left_behind_is_seen_though_the_fingers_feel_something():
    world = World(picker(), carried=False)
    phases = world.run(30.0)
    assert phases[phases.index("check") + 1] == "release" and "carry" not in phases


def test_an_object_that_is_not_seen_moves_nothing():
    world = World(picker(), sees=lambda t: False)
    q = world.q
    assert world.run(5.0) == ["look", "gave up"]
    assert "not seen" in world.state.text
    np.testing.assert_array_equal(world.q, q)


def test_what_is_out_of_sight_in_the_hand_is_carried_by_feel():
    world = World(picker(hold_s=0.2), sees=lambda t: world.state.phase == "look")
    assert world.run(30.0) == WHOLE
    assert world.state.text == "held, by feel: the object is not seen" and world.state.level == "warning"


def test_an_object_out_of_reach_is_refused_before_anything_moves():
    world = World(picker())
    world.X_WO = se3.pose(np.eye(3), [1.6, 0.0, 0.52])
    assert world.run(5.0) == ["look", "gave up"]
    assert "out of reach" in world.state.text and "(1600, 0, 520) mm" in world.state.text


def test_settings_must_be_positive():
    with pytest.raises(InputError, match="pick: hold_s must be positive, got 0"):
        PickSettings(hold_s=0)
