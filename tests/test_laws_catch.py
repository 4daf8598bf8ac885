"""Each law fails on a system that breaks it: a law that cannot fail protects nothing."""

import numpy as np
import pytest
from pydrake.common.value import Value
from pydrake.systems.framework import BasicVector, DiagramBuilder, LeafSystem

from vipr.systems.arm.encoders import JointEncoders
from vipr.systems.signals import CameraFrame, ObjectPose

import laws

TIMES = [0.01, 0.05, 0.09]


class Counter(LeafSystem):
    """Counts in self, which the law on context purity must notice.

    .. pydrake_system::

        name: Counter
        output_ports:
        - total
    """

    def __init__(self):
        super().__init__()
        self._n = 0
        self.DeclareVectorOutputPort("count", BasicVector(1), self._calc, {self.time_ticket()})

    def _calc(self, context, output):
        self._n += 1
        output[0] = self._n


class Sink(LeafSystem):
    def __init__(self, model):
        super().__init__()
        self.DeclareAbstractInputPort("value", Value(model))


class Source(LeafSystem):
    def __init__(self, model):
        super().__init__()
        self.DeclareAbstractOutputPort(
            "value", lambda: Value(model), lambda context, output: None, {self.nothing_ticket()}
        )


class Truth(LeafSystem):
    def __init__(self):
        super().__init__()
        self.DeclareVectorOutputPort("q_true", BasicVector(4), lambda context, output: None, {self.nothing_ticket()})


class Controller(LeafSystem):
    __module__ = "vipr.systems.servo.cheat"

    def __init__(self):
        super().__init__()
        self.DeclareVectorInputPort("joint_state", 4)


class Relay(LeafSystem):
    def __init__(self):
        super().__init__()
        port = self.DeclareVectorInputPort("in", 4)
        self.DeclareVectorOutputPort("out", BasicVector(4), lambda context, output: None, {port.ticket()})


def test_hidden_state_is_caught():
    with pytest.raises(AssertionError, match="hidden state"):
        laws.assert_context_pure_and_deterministic(lambda: (Counter(), lambda context, t: None), TIMES)


def test_a_port_that_is_documented_otherwise_is_caught():
    with pytest.raises(AssertionError, match=r"ports are \[\] -> \['count'\]"):
        laws.assert_ports_documented(Counter())


def test_a_missing_port_block_is_caught():
    with pytest.raises(AssertionError, match=r"no '\.\. pydrake_system::' block"):
        laws.assert_ports_documented(Truth())


def test_a_mistyped_wire_is_caught():
    builder = DiagramBuilder()
    source, sink = (
        builder.AddNamedSystem("source", Source(CameraFrame())),
        builder.AddNamedSystem("sink", Sink(ObjectPose())),
    )
    builder.Connect(source.get_output_port(), sink.get_input_port())
    with pytest.raises(AssertionError, match=r"source\.value gives CameraFrame, but sink\.value wants ObjectPose"):
        laws.assert_wires_typed(builder.Build())


@pytest.mark.parametrize("between", [None, Relay])
def test_truth_that_reaches_a_controller_is_caught_however_far(between):
    builder = DiagramBuilder()
    port = builder.AddNamedSystem("truth", Truth()).get_output_port()
    if between:
        relay = builder.AddNamedSystem("relay", between())
        builder.Connect(port, relay.get_input_port())
        port = relay.get_output_port()
    builder.Connect(port, builder.AddNamedSystem("controller", Controller()).get_input_port())
    with pytest.raises(AssertionError, match=r"truth reaches a controller: truth\.q_true"):
        laws.assert_no_truth_reaches_a_controller(builder.Build())


def test_truth_through_a_sensor_is_allowed():
    builder = DiagramBuilder()
    truth = builder.AddNamedSystem("truth", Truth())
    encoders = builder.AddNamedSystem("encoders", JointEncoders(np.ones(2)))
    controller = builder.AddNamedSystem("controller", Controller())
    builder.Connect(truth.get_output_port(), encoders.get_input_port())
    builder.Connect(encoders.get_output_port(), controller.get_input_port())
    diagram = builder.Build()
    laws.assert_no_truth_reaches_a_controller(diagram)
    assert laws.wires(diagram) == ["encoders.joint_state -> controller.joint_state", "truth.q_true -> encoders.state"]
