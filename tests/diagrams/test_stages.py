"""Stages of a robot are replaced by name, and what does not fit is refused in one line."""

import numpy as np
import pytest
from pydrake.common.value import Value
from pydrake.systems.framework import DiagramBuilder, LeafSystem
from pydrake.systems.primitives import ConstantVectorSource, Gain

from vipr.diagrams.stages import Stages, connect
from vipr.systems.errors import InputError
from vipr.systems.signals import Gesture, ObjectPose, Status


class Writer(LeafSystem):
    def __init__(self, model=Status, *, period=0.04):
        super().__init__()
        self.period = period
        self.DeclareAbstractOutputPort("told", lambda: Value(model()), lambda context, output: None)


class Reader(LeafSystem):
    def __init__(self):
        super().__init__()
        self.DeclareAbstractInputPort("heard", Value(Status()))
        self.DeclareVectorInputPort("speed", 3)


def test_a_stage_is_the_robots_own_unless_another_takes_its_place():
    def other(model, *, period):
        return Writer(model, period=2 * period)

    builder = DiagramBuilder()
    own = Stages({"eye": Writer, "ear": Writer}, {"ear": other})
    assert own.add(builder, "eye", Status, period=0.1).period == 0.1
    assert own.add(builder, "ear", Status, period=0.1).period == 0.2
    assert [s.get_name() for s in builder.GetSystems()] == ["eye", "ear"]


@pytest.mark.parametrize(
    ("others", "message"),
    [
        ({"nose": Writer}, "unknown stage 'nose'; those that can be replaced are eye, ear"),
        (
            {"eye": Reader},
            r"stage eye: Reader is called as Writer\(model=.*, \*, period=0.04\) is; too many positional",
        ),
        ({"eye": lambda model, period: 3}, "stage eye: <lambda> must give a system, got int"),
    ],
)
def test_what_cannot_take_a_stages_place_is_refused(others, message):
    with pytest.raises(InputError, match=message):
        Stages({"eye": Writer, "ear": Writer}, others).add(DiagramBuilder(), "eye", Status, period=0.1)


def wire(make_writer, output, make_reader, input_):
    builder = DiagramBuilder()
    writer, reader = builder.AddNamedSystem("one", make_writer()), builder.AddNamedSystem("two", make_reader())
    connect(builder, [(writer, output, reader, input_)])
    return builder.Build()


def test_ports_that_carry_the_same_are_connected():
    assert len(wire(Writer, "told", Reader, "heard").connection_map()) == 1
    assert len(wire(lambda: ConstantVectorSource(np.zeros(3)), "y0", Reader, "speed").connection_map()) == 1


@pytest.mark.parametrize(
    ("writer", "output", "reader", "input_", "message"),
    [
        (Writer, "said", Reader, "heard", "stage one: Writer has no output port 'said'; its output ports are told"),
        (
            Writer,
            "told",
            Reader,
            "herd",
            "stage two: Reader has no input port 'herd'; its input ports are heard, speed",
        ),
        (Writer, "told", lambda: ConstantVectorSource([1.0]), "u0", "has no input port 'u0'; its input ports are none"),
        (lambda: Writer(Gesture), "told", Reader, "heard", r"one\.told gives Gesture, but two\.heard takes Status"),
        (Writer, "told", Reader, "speed", r"one\.told gives Status, but two\.speed takes 3 numbers"),
        (lambda: Gain(1.0, 2), "y0", Reader, "speed", r"one\.y0 gives 2 numbers, but two\.speed takes 3 numbers"),
        (
            lambda: Writer(ObjectPose),
            "told",
            lambda: Gain(1.0, 2),
            "u0",
            "one.told gives ObjectPose, but two.u0 takes 2 num",
        ),
    ],
)
def test_ports_that_do_not_fit_are_named(writer, output, reader, input_, message):
    with pytest.raises(InputError, match=message):
        wire(writer, output, reader, input_)
