"""Robots are built of named stages: any of them may be replaced by another system that is called and wired as it was."""

import inspect
from collections.abc import Callable, Iterable, Mapping

from pydrake.systems.framework import DiagramBuilder, PortDataType, System

from vipr.systems.errors import InputError

Maker = Callable[..., System]  # a system's class, or a function that returns a system
Wire = tuple[System, str, System, str]  # writer, its output port, reader, its input port


class Stages:
    """The stages of a robot by their names: the robot's own makers, and those that take their place.

    A maker is called with the arguments that the robot's own is called with (see the robot's ``__init__``); the system it returns needs
    the ports that the robot wires.
    """

    def __init__(self, own: Mapping[str, Maker], others: Mapping[str, Maker] | None = None):
        self._own, self._others = own, dict(others or {})
        for name in self._others:
            if name not in own:
                raise InputError(f"unknown stage {name!r}; those that can be replaced are {', '.join(own)}")

    def add(self, builder: DiagramBuilder, name: str, *arguments, **settings) -> System:
        """Make the stage and add it to the builder under its name."""
        return builder.AddNamedSystem(name, self.make(name, *arguments, **settings))

    def make(self, name: str, *arguments, **settings) -> System:
        """Make the stage; InputError for another's maker that cannot be called so or gives no system."""
        make = self._others.get(name, self._own[name])
        if name in self._others:
            try:
                inspect.signature(make).bind(*arguments, **settings)
            except TypeError as error:
                own = self._own[name]
                raise InputError(
                    f"stage {name}: {_called(make)} is called as {own.__name__}{_plain(own)} is; {error}"
                ) from None
        system = make(*arguments, **settings)
        if not isinstance(system, System):
            raise InputError(f"stage {name}: {_called(make)} must give a system, got {type(system).__name__}")
        return system


def connect(builder: DiagramBuilder, wires: Iterable[Wire]) -> None:
    """Connect the wires; InputError where a port is missing, or where the two ends carry different things.

    Drake checks the sizes of vectors, but lets any Python value onto any abstract port.
    """
    for writer, output, reader, input_ in wires:
        if not writer.HasOutputPort(output):
            raise InputError(_missing(writer, "output", output, writer.num_output_ports(), writer.get_output_port))
        if not reader.HasInputPort(input_):
            raise InputError(_missing(reader, "input", input_, reader.num_input_ports(), reader.get_input_port))
        given, wanted = _carried(writer, output), _wanted(reader, input_)
        if given != wanted and None not in (given, wanted):
            raise InputError(
                f"{writer.get_name()}.{output} gives {given}, but {reader.get_name()}.{input_} takes {wanted}"
            )
        builder.Connect(writer.GetOutputPort(output), reader.GetInputPort(input_))


def _carried(system: System, name: str) -> str | None:
    port = system.GetOutputPort(name)
    return _kind(port, port.Allocate)


def _wanted(system: System, name: str) -> str | None:
    port = system.GetInputPort(name)
    return _kind(port, lambda: system.AllocateInputAbstract(port))


def _kind(port, allocate) -> str | None:
    """What a port carries, in words; None for a C++ type without a binding, which Drake checks by itself."""
    if port.get_data_type() == PortDataType.kVectorValued:
        return f"{port.size()} numbers"
    try:
        return type(allocate().get_value()).__name__
    except (AttributeError, TypeError, RuntimeError):
        return None


def _missing(system: System, kind: str, name: str, count: int, port) -> str:
    there = ", ".join(port(i).get_name() for i in range(count)) or "none"
    return (
        f"stage {system.get_name()}: {type(system).__name__} has no {kind} port {name!r}; its {kind} ports are {there}"
    )


def _plain(make: Maker) -> inspect.Signature:
    """The signature without types, which would hide it."""
    signature = inspect.signature(make)
    bare = [p.replace(annotation=p.empty) for p in signature.parameters.values()]
    return signature.replace(parameters=bare, return_annotation=signature.empty)


def _called(make: Maker) -> str:
    return getattr(make, "__name__", type(make).__name__)
