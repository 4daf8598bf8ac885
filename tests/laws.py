"""The laws that every system obeys, as functions that raise AssertionError with the place and the reason.

``tests/test_laws.py`` applies them to every ``LeafSystem`` and ``Diagram`` found under ``vipr.systems`` and ``vipr.diagrams``; each of
them has an example in ``tests/examples.py``, so a new system cannot dodge them.
"""

import importlib
import inspect
import pkgutil
import re

import numpy as np
import yaml
from pydrake.common.value import AbstractValue
from pydrake.systems.framework import Diagram, LeafSystem, PortDataType

import vipr.diagrams
import vipr.systems

# Systems that turn truth into a measurement, the only legal way from a plant to a controller.
SENSORS = {"RgbdSensor", "JointEncoders", "GeometricSight"}
# Plant outputs that are measurements: what the motors spend, which their amplifiers know.
MEASURED_BY_PLANT = "_net_actuation"
# Systems that decide what the robot does: no truth may reach them but through a sensor.
CONTROLLER_PACKAGES = ("vipr.systems.servo", "vipr.systems.arm", "vipr.systems.hand", "vipr.systems.grasping")


def modules(*packages):
    """Every module below the packages."""
    for package in packages:
        for info in pkgutil.walk_packages(package.__path__, package.__name__ + "."):
            yield importlib.import_module(info.name)


def systems(kind=LeafSystem):
    """Every public class of the kind that VIPR defines, in a fixed order."""
    found = {
        cls
        for module in modules(vipr.systems, vipr.diagrams)
        for _, cls in inspect.getmembers(module, inspect.isclass)
        if issubclass(cls, kind) and cls.__module__.startswith("vipr.") and not cls.__name__.startswith("_")
    }
    return sorted(found, key=lambda cls: (cls.__module__, cls.__name__))


def documented_ports(cls):
    """(input names, output names) of the ``.. pydrake_system::`` block of the docstring."""
    doc = inspect.getdoc(cls) or ""
    block = re.search(r"\.\. pydrake_system::\n\n((?:[ ]+\S.*\n?|\n)+)", doc + "\n")
    assert block, f"{cls.__module__}.{cls.__name__}: the docstring has no '.. pydrake_system::' block"
    lines = []
    for line in block.group(1).splitlines():
        if line and not line.startswith(" "):
            break
        lines.append(line)
    spec = yaml.safe_load(inspect.cleandoc("\n".join(lines)))
    assert spec.get("name") == cls.__name__, f"{cls.__name__}: its port block is named {spec.get('name')!r}"
    return spec.get("input_ports") or [], spec.get("output_ports") or []


def assert_ports_documented(system):
    inputs = [system.get_input_port(i).get_name() for i in range(system.num_input_ports())]
    outputs = [system.get_output_port(i).get_name() for i in range(system.num_output_ports())]
    assert (inputs, outputs) == documented_ports(type(system)), (
        f"{type(system).__name__}: ports are {inputs} -> {outputs}, its docstring says {documented_ports(type(system))}"
    )
    for name in inputs + outputs:
        assert not re.fullmatch(r"[uy]\d+", name), f"{type(system).__name__}: port {name} has no name of its own"


def wires(diagram):
    """Sorted ``"camera.color_image -> tracker.color_image"`` of one diagram level."""
    names = []
    for (reader, i), (writer, o) in diagram.connection_map().items():
        names.append(
            f"{writer.get_name()}.{writer.get_output_port(o).get_name()} -> {reader.get_name()}.{reader.get_input_port(i).get_name()}"
        )
    return sorted(names)


def sub_diagrams(diagram):
    """The diagram and every diagram inside it."""
    yield diagram
    for system in diagram.GetSystems():
        if isinstance(system, Diagram):
            yield from sub_diagrams(system)


def assert_wires_typed(diagram):
    """pydrake connects any Python value to any abstract port: the model values of both ends must be of one type."""
    for level in sub_diagrams(diagram):
        for (reader, i), (writer, o) in level.connection_map().items():
            wanted_port, given_port = reader.get_input_port(i), writer.get_output_port(o)
            if given_port.get_data_type() != PortDataType.kAbstractValued:
                continue
            given, wanted = _value(given_port.Allocate()), _value(reader.AllocateInputAbstract(wanted_port))
            if given is None or wanted is None:
                continue  # a C++ type without a binding: Drake checks those itself
            assert type(given) is type(wanted), (
                f"{writer.get_name()}.{given_port.get_name()} gives {type(given).__name__}, but "
                f"{reader.get_name()}.{wanted_port.get_name()} wants {type(wanted).__name__}"
            )


def _value(abstract: AbstractValue):
    try:
        return abstract.get_value()
    except (AttributeError, TypeError, RuntimeError):
        return None


def assert_no_truth_reaches_a_controller(diagram):
    """From every output of a plant and every port named for truth, follow the wires; only sensors may stop the walk."""
    for level in sub_diagrams(diagram):
        edges = {}
        for (reader, i), (writer, o) in level.connection_map().items():
            edges.setdefault((writer, int(o)), []).append((reader, i))
        reached = [
            (s, o, f"{s.get_name()}.{s.get_output_port(o).get_name()}")
            for s in level.GetSystems()
            for o in range(s.num_output_ports())
            if (
                type(s).__name__ == "MultibodyPlant" and not s.get_output_port(o).get_name().endswith(MEASURED_BY_PLANT)
            )
            or is_truth(s.get_output_port(o).get_name())
        ]
        seen = set()
        while reached:
            writer, o, path = reached.pop()
            for reader, i in edges.get((writer, o), []):
                here = f"{path} -> {reader.get_name()}.{reader.get_input_port(i).get_name()}"
                if reader in seen or type(reader).__name__ in SENSORS:
                    continue
                assert not decides(type(reader)), f"truth reaches a controller: {here}"
                if type(reader).__name__ in ("MultibodyPlant", "SceneGraph"):
                    continue
                seen.add(reader)
                reached += [(reader, out, here) for out in range(reader.num_output_ports())]


def decides(cls) -> bool:
    """Whether a system's class belongs to one of the packages that decide what the robot does."""
    return any(f"{cls.__module__}.".startswith(f"{package}.") for package in CONTROLLER_PACKAGES)


def is_truth(port_name: str) -> bool:
    """Whether a port is named as ground truth."""
    return port_name.endswith("_true") or "truth" in port_name


def assert_context_pure_and_deterministic(make, times):
    """Two interleaved simulations of one object, and one of a second object alone, give the same bytes.

    ``make()`` builds ``(system, fix_inputs)``; ``fix_inputs(context, t)`` sets the inputs for time t.
    """
    system, fix_inputs = make()
    alone = list(_run(*make(), times))
    for lone, *pair in zip(alone, _run(system, fix_inputs, times), _run(system, fix_inputs, times), strict=True):
        assert pair == [lone, lone], f"{type(system).__name__}: hidden state, or not deterministic"


def _run(system, fix_inputs, times):
    from pydrake.systems.analysis import Simulator

    context = system.CreateDefaultContext()
    fix_inputs(context, 0.0)
    simulator = Simulator(system, context)
    simulator.Initialize()
    for t in times:
        fix_inputs(context, t)
        simulator.AdvanceTo(t)
        yield tuple(_bytes(_eval(system.get_output_port(o), context)) for o in range(system.num_output_ports()))


def _eval(port, context):
    return port.Eval(context)


def _bytes(value):
    """A value as bytes, down to each array of a signal."""
    if hasattr(value, "__dataclass_fields__"):
        return (type(value).__name__, *(_bytes(getattr(value, f)) for f in value.__dataclass_fields__))
    if hasattr(value, "GetAsMatrix4"):
        value = value.GetAsMatrix4()
    if isinstance(value, dict):
        return tuple((k, _bytes(v)) for k, v in value.items())
    if isinstance(value, list | tuple):
        return tuple(_bytes(v) for v in value)
    data = getattr(value, "data", None)
    if isinstance(data, np.ndarray):
        value = data
    if isinstance(value, np.ndarray):
        return (value.dtype.str, value.shape, np.ascontiguousarray(value).tobytes())
    return repr(value)
