"""The hand's driver on the hand's model: closing on nothing, on a block at the inner links, on a block between the tips, pushed aside."""

import numpy as np
import pytest
from pydrake.geometry import AddCompliantHydroelasticProperties, AddContactMaterial, Box, ProximityProperties
from pydrake.math import RigidTransform, RotationMatrix
from pydrake.multibody.parsing import Parser
from pydrake.multibody.plant import AddMultibodyPlantSceneGraph, CoulombFriction
from pydrake.multibody.tree import SpatialInertia
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder

from vipr.models import model_path
from vipr.systems.errors import InputError
from vipr.systems.hand import transmission
from vipr.systems.hand.driver import HandDriver
from vipr.systems.hand.torque_switch import PINCH, Drives
from vipr.systems.hand.transmission import DISTAL, PROXIMAL, SPREAD

# Blocks before the palm, which looks down: (size, depth of the middle below the base joints) [m].
AT_THE_INNER_LINKS = ((0.10, 0.08, 0.04), 0.03)
BETWEEN_THE_TIPS = ((0.10, 0.06, 0.06), 0.10)
CLOSE = [2.4, 2.4, 2.4, 0.0]


class Bench:
    """The hand fixed in the air, its palm looking down, closing on a block that is fixed too or on nothing."""

    def __init__(self, block=None, time_step=0.002, period=0.005, **drives):
        builder = DiagramBuilder()
        self.plant, _ = AddMultibodyPlantSceneGraph(builder, time_step)
        (self.hand,) = Parser(self.plant).AddModels(str(model_path("barrett_hand/barrett_hand.sdf")))
        X_WP = RigidTransform(RotationMatrix.MakeXRotation(np.pi), [0, 0, 0.0754])
        self.plant.WeldFrames(self.plant.world_frame(), self.plant.GetFrameByName("palm"), X_WP)
        if block:
            size, depth = block
            instance = self.plant.AddModelInstance("block")
            body = self.plant.AddRigidBody("block", instance, SpatialInertia.SolidBoxWithMass(0.3, *size))
            properties = ProximityProperties()
            AddCompliantHydroelasticProperties(0.02, 1e7, properties)
            AddContactMaterial(1.0, None, CoulombFriction(0.7, 0.7), properties)
            self.plant.RegisterCollisionGeometry(body, RigidTransform(), Box(*size), "block", properties)
            self.plant.WeldFrames(self.plant.world_frame(), body.body_frame(), RigidTransform([0, 0, -depth]))
        self.plant.Finalize()
        self.driver = builder.AddNamedSystem("driver", HandDriver(Drives(**drives), period=period))
        for writer, reader in (
            (self.driver.GetOutputPort("desired_state"), self.plant.get_desired_state_input_port(self.hand)),
            (self.plant.get_state_output_port(self.hand), self.driver.GetInputPort("hand_state")),
            (self.plant.get_net_actuation_output_port(self.hand), self.driver.GetInputPort("joint_torque")),
        ):
            builder.Connect(writer, reader)
        builder.ExportInput(self.driver.GetInputPort("motor_command"), "motor_command")
        self.simulator = Simulator(builder.Build())
        self.context = self.simulator.get_mutable_context()

    def run(self, command, seconds):
        """Joint angles (8,) after so many seconds of a motor command."""
        self.simulator.get_system().get_input_port().FixValue(self.context, np.asarray(command, float))
        self.simulator.AdvanceTo(self.context.get_time() + seconds)
        return self.joints

    @property
    def joints(self):
        return self.plant.GetPositions(self.plant.GetMyContextFromRoot(self.context), self.hand)

    def __getattr__(self, port):
        return self.driver.GetOutputPort(port).Eval(self.driver.GetMyContextFromRoot(self.context)).copy()


def test_an_empty_hand_closes_coupled_in_a_second_and_opens_again():
    bench = Bench()
    q = bench.run([2.0, 1.5, 1.0, 0.0], 0.5)
    np.testing.assert_allclose(q[PROXIMAL], [1.2, 1.2, 1.0], atol=0.03)  # 2.4 rad/s
    q = bench.run([2.0, 1.5, 1.0, 0.0], 0.5)
    np.testing.assert_allclose(q[PROXIMAL], [2.0, 1.5, 1.0], atol=2e-3)
    np.testing.assert_allclose(q[DISTAL], q[PROXIMAL] / 3, atol=2e-3)
    np.testing.assert_array_equal(bench.clutch, 1)
    np.testing.assert_allclose(bench.run([0, 0, 0, 0], 1.0), 0, atol=2e-3)


def test_both_fingers_spread_alike():
    bench = Bench()
    np.testing.assert_allclose(bench.run([0, 0, 0, np.pi / 2], 0.5)[SPREAD], np.pi / 2, atol=1e-3)


@pytest.mark.parametrize(("time_step", "period"), [(0.002, 0.005), (0.001, 0.005), (0.005, 0.005), (0.002, 0.002)])
def test_inner_links_that_meet_a_block_hold_and_outer_links_close_to_their_stop(time_step, period):
    bench = Bench(AT_THE_INNER_LINKS, time_step, period)
    q = bench.run(CLOSE, 1.2)
    np.testing.assert_array_equal(bench.clutch, 0)
    np.testing.assert_allclose(q[PROXIMAL], 1.615, atol=2e-3)  # the same for all steps and periods
    np.testing.assert_allclose(q[DISTAL], np.radians(48), atol=2e-3)


def test_the_clutch_seats_again_where_it_let_go():
    bench = Bench(AT_THE_INNER_LINKS)
    held = bench.run(CLOSE, 1.2)[PROXIMAL]
    away = bench.motor_position[:3]
    q = bench.run(np.append((held + away) / 2, 0), 0.5)
    np.testing.assert_array_equal(bench.clutch, 0)  # wound back half way: the inner links still hold
    np.testing.assert_allclose(q[PROXIMAL], held, atol=2e-3)
    q = bench.run(np.append(held - 0.2, 0), 0.5)
    np.testing.assert_array_equal(bench.clutch, 1)
    np.testing.assert_allclose(q[PROXIMAL], held - 0.2, atol=2e-3)
    np.testing.assert_allclose(q[DISTAL], q[PROXIMAL] / 3, atol=2e-3)


def test_without_the_torque_switch_the_outer_links_stop_with_the_inner_ones():
    bench = Bench(AT_THE_INNER_LINKS, break_away_torque=np.inf)
    q = bench.run(CLOSE, 1.2)
    np.testing.assert_array_equal(bench.clutch, 1)
    assert (q[DISTAL] < 0.56).all()


def test_a_stronger_setting_squeezes_harder_before_it_lets_go():
    weak, strong = (
        Bench(AT_THE_INNER_LINKS, break_away_torque=torque, torque_limit=(3, 3, 3, 2)).run(CLOSE, 1.2)
        for torque in (0.5, 1.5)
    )
    assert (strong[PROXIMAL] > weak[PROXIMAL] + 0.01).all()


def test_tips_that_meet_a_block_stop_at_the_torque_limit_and_the_worms_hold():
    bench = Bench(BETWEEN_THE_TIPS, torque_limit=PINCH, speed=(0.5, 0.5, 0.5, 6.3))
    bench.run(CLOSE, 2.8)
    np.testing.assert_allclose(bench.motor_torque[:3], [0.8, 0.8, 1.6], rtol=0.15)
    assert (bench.finger_torque > 0.1).all()
    stopped = bench.motor_position
    bench.run(stopped, 0.5)
    np.testing.assert_allclose(bench.motor_position, stopped, atol=1e-3)
    assert (bench.motor_torque[:3] > 0.6).all()  # motors off, grip kept


def test_the_spread_can_be_pushed_back_and_a_finger_cannot():
    driver = HandDriver(initial=np.array([0.5, 0.5, 0.5, 1.0]))
    context = driver.CreateDefaultContext()
    joints = transmission.joint_angles(np.array([0.5, 0.5, 0.5, 1.0]), transmission.SEATED)
    push = np.zeros(8)
    push[SPREAD], push[PROXIMAL] = 2.0, 3.0  # 4 N m on the spread motor, more than its 2 N m
    for port, value in (
        ("motor_command", [0.5, 0.5, 0.5, 1.0]),
        ("hand_state", np.concatenate([joints, np.zeros(8)])),
        ("joint_torque", push),
    ):
        driver.GetInputPort(port).FixValue(context, value)
    simulator = Simulator(driver, context)
    simulator.AdvanceTo(0.021)
    position = driver.GetOutputPort("motor_position").Eval(context)
    assert position[3] < 0.98
    np.testing.assert_array_equal(position[:3], 0.5)
    np.testing.assert_array_equal(driver.GetOutputPort("clutch").Eval(context), 1)  # clutches let go while closing only


def test_set_points_go_on_between_ticks_and_nothing_feeds_through():
    driver = HandDriver()
    assert not driver.HasAnyDirectFeedthrough()
    context = driver.CreateDefaultContext()
    for port, size in (("hand_state", 16), ("joint_torque", 8)):
        driver.GetInputPort(port).FixValue(context, np.zeros(size))
    driver.GetInputPort("motor_command").FixValue(context, [0.5, 0.5, 0.5, 0])
    simulator = Simulator(driver, context)
    desired = []
    for t in (0.001, 0.003):
        simulator.AdvanceTo(t)
        desired.append(driver.GetOutputPort("desired_state").Eval(context).copy())
    np.testing.assert_allclose(desired[1][:8] - desired[0][:8], 0.002 * desired[0][8:], atol=1e-12)
    assert desired[0][8 + PROXIMAL[0]] > 0


@pytest.mark.parametrize(
    ("settings", "message"),
    [
        ({"speed": (1.0, 1.0, 1.0)}, "speed must be 4 positive numbers"),
        ({"torque_limit": (1.0, 1.0, -1.0, 1.0)}, "torque_limit must be 4 positive numbers"),
        ({"break_away_torque": 0.0}, "break-away torque must be positive, got 0.0 N m"),
    ],
)
def test_impossible_drives_are_refused(settings, message):
    with pytest.raises(InputError, match=message):
        Drives(**settings)
