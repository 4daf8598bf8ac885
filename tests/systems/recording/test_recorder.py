"""The recorder in a simulation: what reaches the folder, when, and how errors come back."""

import numpy as np
import pytest
from pydrake.common.value import Value
from pydrake.math import RigidTransform
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder
from pydrake.systems.primitives import ConstantValueSource, ConstantVectorSource
from recording_ticks import CHANNELS, tick

from vipr.systems.errors import InputError
from vipr.systems.recording.channels import PoseChannel, VectorChannel
from vipr.systems.recording.recorder import Recorder
from vipr.systems.timing import LEDGER


def simulated(recorder, until, inputs=None):
    context = recorder.CreateDefaultContext()
    for name, value in (inputs or {}).items():
        recorder.GetInputPort(name).FixValue(context, value)
    simulator = Simulator(recorder, context)
    simulator.Initialize()
    simulator.AdvanceTo(until)
    return simulator


def test_every_channel_is_recorded_once_a_period_from_the_offset_on():
    ticks = []
    recorder = Recorder(CHANNELS, lambda t, values: ticks.append((t, values)), period=0.04, offset=0.01)
    given = tick(3)
    simulated(recorder, 0.1301, given | {"X_CO_true": RigidTransform(given["X_CO_true"])})
    assert [t for t, _ in ticks] == pytest.approx([0.01, 0.05, 0.09, 0.13])
    _, values = ticks[2]
    assert list(values) == [channel.name for channel in CHANNELS]
    assert values["camera"] is given["camera"]
    assert values["phase"] is given["phase"]
    assert values["X_CO"] is given["X_CO"]
    np.testing.assert_allclose(values["X_CO_true"], given["X_CO_true"], atol=1e-15)
    np.testing.assert_array_equal(values["servo_error"], given["servo_error"])
    np.testing.assert_array_equal(values["q"], given["q"])


def test_recorded_numbers_do_not_change_when_the_ports_do():
    ticks = []
    recorder = Recorder([VectorChannel("e", ("a",), ("m",)), PoseChannel("X")], lambda t, v: ticks.append(v))
    simulator = simulated(recorder, 0.001, {"e": [1.0], "X": RigidTransform([1.0, 0, 0])})
    context = simulator.get_mutable_context()
    recorder.GetInputPort("e").FixValue(context, [2.0])
    recorder.GetInputPort("X").FixValue(context, RigidTransform([2.0, 0, 0]))
    simulator.AdvanceTo(0.041)
    assert [v["e"][0] for v in ticks] == [1.0, 2.0]
    assert [v["X"][0, 3] for v in ticks] == [1.0, 2.0]


def test_ports_that_nobody_wired_are_left_out():
    ticks = []
    recorder = Recorder(CHANNELS, lambda t, values: ticks.append(values))
    simulated(recorder, 0.001, {"q": [0.0, 1.0, 2.0, 3.0]})
    assert [list(values) for values in ticks] == [["q"]]


def test_it_reads_a_diagram_s_wires():
    ticks = []
    builder = DiagramBuilder()
    recorder = builder.AddSystem(
        Recorder([PoseChannel("X"), VectorChannel("e", ("a",), ("m",))], lambda t, v: ticks.append(v))
    )
    pose = builder.AddSystem(ConstantValueSource(Value(RigidTransform([0, 0, 3.0]))))
    error = builder.AddSystem(ConstantVectorSource([0.5]))
    builder.Connect(pose.get_output_port(), recorder.GetInputPort("X"))
    builder.Connect(error.get_output_port(), recorder.GetInputPort("e"))
    simulated(builder.Build(), 0.001)
    assert ticks[0]["X"][2, 3] == 3.0
    assert ticks[0]["e"][0] == 0.5


def test_an_error_of_the_folder_comes_out_of_the_simulation():
    def record(time, values):
        raise InputError("log.mcap: cannot be written (No space left on device)")

    with pytest.raises(InputError, match=r"log\.mcap: cannot be written"):
        simulated(Recorder([], record), 0.001)


def test_its_work_is_charged_to_logging():
    LEDGER.reset()
    simulated(Recorder([], lambda t, v: sum(range(10_000))), 0.1)
    assert list(LEDGER.seconds) == ["logging"]
