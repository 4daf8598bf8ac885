"""What the analysis predicts is what the simulated workcell does: a step of the loop, with the tracker replaced by exact geometry."""

import numpy as np
import pytest
from pydrake.common.value import Value
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder, LeafSystem

from vipr.diagrams.servo_loop import arm_response, workcell_loop
from vipr.diagrams.servo_robot import Schedule
from vipr.diagrams.workcell import Workcell, WorkcellConfig
from vipr.diagrams.workcell_layout import standing
from vipr.systems import se3
from vipr.systems.arm import puma560
from vipr.systems.arm.commander import ArmCommander
from vipr.systems.camera.lens import Lens
from vipr.systems.servo.analysis import largest_stable_gain, quickest_gain, step_response
from vipr.systems.servo.controller import VisualServo
from vipr.systems.servo.position_based import PositionBased
from vipr.systems.servo.tasks import Reach
from vipr.systems.signals import ObjectPose

GOAL = puma560.NAMED["nominal"] + np.array([0.0, 0.15, -0.05, 0.0, 0.0, 0.0])
START = 0.003 * np.array([1.0, -0.6, 0.8, -1.0, 0.7, 1.0])  # rad: small, so that no limit interferes
BEGIN = 0.4  # s: the arm has come to rest under the weight of its hand
SCHEDULE = Schedule()


class ExactVision(LeafSystem):
    """Sees an object that rests at X_CO in every exposure from the first one at ``BEGIN``."""

    def __init__(self, X_CO):
        super().__init__()
        self._X_CO = X_CO
        self._state = self.DeclareAbstractState(Value(ObjectPose()))
        self.DeclareStateOutputPort("object_pose", self._state)
        self.DeclarePeriodicUnrestrictedUpdateEvent(SCHEDULE.camera, BEGIN, self._update)

    def _update(self, context, state):
        seen = ObjectPose(X_CO=self._X_CO, covariance=1e-12 * np.eye(6), state="tracking", time=context.get_time())
        state.get_mutable_abstract_state(int(self._state)).set_value(seen)


class DelayedServo(LeafSystem):
    """The simplest servo: the twist that takes away the error of an exposure that is ``latency`` old."""

    def __init__(self, arm, X_WG, gain, latency):
        super().__init__()
        self._arm, self._X_WG, self._gain = arm, X_WG, gain
        self._behind = int(latency // SCHEDULE.camera)
        self._joint_state = self.DeclareVectorInputPort("joint_state", 12)
        self._seen = self.DeclareDiscreteState(6 * (self._behind + 1))
        self._twist = self.DeclareDiscreteState(6)
        self.DeclarePeriodicDiscreteUpdateEvent(SCHEDULE.camera, BEGIN, self._expose)
        self.DeclarePeriodicDiscreteUpdateEvent(
            SCHEDULE.camera, BEGIN + latency - self._behind * SCHEDULE.camera, self._answer
        )
        self.DeclareStateOutputPort("V_WE_W", self._twist)

    def _expose(self, context, state):
        error = se3.difference(self._arm.tool_pose(self._joint_state.Eval(context)[:6]), self._X_WG)
        old = context.get_discrete_state(self._seen).CopyToVector()
        state.set_value(self._seen, np.concatenate([error, old[:-6]]))

    def _answer(self, context, state):
        state.set_value(self._twist, self._gain * context.get_discrete_state(self._seen).CopyToVector()[-6:])


def simulated_step(make_servo, duration):
    """Deviation (K, 6) of the joints from the goal, every 10 ms from ``BEGIN``, of the real workcell, commander and servo."""
    lens = Lens(16, 12, 50.0, 50.0, 7.5, 5.5)  # nobody looks
    cell = Workcell(WorkcellConfig(q_initial=GOAL + START, lens=lens, supersampling=1))
    builder = DiagramBuilder()
    builder.AddNamedSystem("workcell", cell)
    servo = make_servo(builder, cell)
    arm = builder.AddNamedSystem(
        "arm", ArmCommander(cell.arm, cell.joint_limits, GOAL + START, offset=SCHEDULE.arm_offset, guard=cell.guard)
    )
    builder.Connect(cell.GetOutputPort("joint_state"), servo.GetInputPort("joint_state"))
    builder.Connect(servo.GetOutputPort("V_WE_W"), arm.GetInputPort("V_WE_W"))
    builder.Connect(arm.GetOutputPort("desired_state"), cell.GetInputPort("arm_desired_state"))
    for name in ("motor_command", "stage_desired_state"):
        builder.ExportInput(cell.GetInputPort(name), name)
    diagram = builder.Build()
    simulator = Simulator(diagram)
    context = simulator.get_mutable_context()
    diagram.GetInputPort("motor_command").FixValue(context, np.zeros(4))
    diagram.GetInputPort("stage_desired_state").FixValue(context, np.zeros(6))
    plant, puma = cell.plant, cell.plant.GetModelInstanceByName("puma560")
    places = []
    for k in range(round(duration / 0.01)):
        simulator.AdvanceTo(BEGIN + 0.01 * k + 0.001)  # the plant's state of the last millisecond
        places.append(plant.GetPositions(plant.GetMyContextFromRoot(context), puma) - GOAL)
    return np.array(places)


def visual_servo(gain):
    def make(builder, cell):
        X_WO, X_WE = standing(np.zeros(3)), cell.arm.tool_pose(GOAL)
        vision = builder.AddNamedSystem("vision", ExactVision(se3.inverse(cell.config.X_WC) @ X_WO))
        task = Reach(cell.config.X_WC, se3.inverse(X_WO) @ X_WE, np.eye(3))
        law = PositionBased(gain=gain)
        servo = builder.AddNamedSystem("servo", VisualServo(cell.arm, task, law=law, offset=SCHEDULE.servo_offset))
        builder.Connect(vision.GetOutputPort("object_pose"), servo.GetInputPort("object_pose"))
        return servo

    return make


def delayed_servo(gain, latency):
    return lambda builder, cell: builder.AddNamedSystem(
        "servo", DelayedServo(cell.arm, cell.arm.tool_pose(GOAL), gain, latency)
    )


@pytest.mark.parametrize("gain", [2.0, 7.0])
def test_the_step_of_the_visual_servo_is_the_predicted_one(gain):
    loop = workcell_loop(GOAL)
    simulated = simulated_step(visual_servo(gain), 0.8)
    _, predicted = step_response(loop, gain, 0.8, simulated[0])
    assert np.abs(simulated - predicted).max() < 0.03 * np.abs(START).max()


def test_the_step_of_a_servo_that_does_not_predict_is_the_predicted_one_with_its_overshoot():
    latency = 0.122  # s: three exposures are under way
    loop = workcell_loop(GOAL, latency=latency, use="delayed")
    gain = 0.6 * largest_stable_gain(loop)
    simulated = simulated_step(delayed_servo(gain, latency), 1.2)
    _, predicted = step_response(loop, gain, 1.2, simulated[0])
    overshoot = [float((-places / simulated[0]).max()) for places in (predicted, simulated)]
    assert overshoot[0] > 0.2 and overshoot[1] == pytest.approx(overshoot[0], abs=0.05)
    assert np.abs(simulated - predicted).max() < 0.04 * np.abs(START).max()


def test_the_linear_arm_comes_to_rest_at_its_set_points_and_is_stable():
    response = arm_response(GOAL)
    assert np.linalg.eigvals(response.A).real.max() < -5.0
    rest = np.linalg.solve(response.A, -response.B @ np.concatenate([np.ones(6), np.zeros(12)]))
    assert np.allclose(rest, np.concatenate([np.ones(6), np.zeros(6)]), atol=0.01)


def test_the_default_gain_has_the_margin_it_needs():
    loop = workcell_loop()
    assert largest_stable_gain(loop) > 5.0 * PositionBased().gain
    assert quickest_gain(loop) > PositionBased().gain
