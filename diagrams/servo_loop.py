"""The servo loop of the workcell as ``systems.servo.analysis`` examines it: Drake linearises the arm, the schedule gives the clocks."""

from typing import Literal

import numpy as np
from pydrake.systems.controllers import InverseDynamics
from pydrake.systems.framework import DiagramBuilder
from pydrake.systems.primitives import Adder, Demultiplexer, Linearize, MatrixGain

from vipr.diagrams.servo_robot import Schedule
from vipr.diagrams.workcell import DAMPING, STIFFNESS, nominal_arm
from vipr.systems.arm import puma560
from vipr.systems.servo.analysis import ArmResponse, SampledLoop


def arm_response(q: np.ndarray) -> ArmResponse:
    """How the arm, with its hand and its joint servo, follows a reference near q (6,) [rad]: Drake's linearisation of the plant.

    The loop is that of ``Workcell``: a PD controller in each joint about a reference, and the torques that the reference takes, on rotor
    and link inertia and viscous friction; encoder steps and the plant's own time step (2 ms) are left out.
    """
    builder = DiagramBuilder()
    plant = builder.AddSystem(nominal_arm())
    n = len(STIFFNESS)
    gains = np.hstack([np.diag(STIFFNESS), np.diag(DAMPING)])
    reference = builder.AddSystem(Demultiplexer([2 * n, n]))
    servo, back = builder.AddSystem(MatrixGain(gains)), builder.AddSystem(MatrixGain(-gains))
    dynamics, torque = builder.AddSystem(InverseDynamics(plant)), builder.AddSystem(Adder(3, n))
    state = plant.get_state_output_port()
    builder.Connect(reference.get_output_port(0), servo.get_input_port())
    builder.Connect(reference.get_output_port(0), dynamics.get_input_port_estimated_state())
    builder.Connect(reference.get_output_port(1), dynamics.get_input_port_desired_acceleration())
    builder.Connect(state, back.get_input_port())
    for k, part in enumerate((servo.get_output_port(), back.get_output_port(), dynamics.get_output_port())):
        builder.Connect(part, torque.get_input_port(k))
    builder.Connect(torque.get_output_port(), plant.get_actuation_input_port())
    builder.ExportInput(reference.get_input_port(), "reference")
    builder.ExportOutput(state, "state")
    diagram = builder.Build()
    context = diagram.CreateDefaultContext()
    context.SetContinuousState(np.concatenate([q, np.zeros(n)]))
    diagram.get_input_port().FixValue(context, np.concatenate([q, np.zeros(2 * n)]))
    linear = Linearize(diagram, context)
    return ArmResponse(linear.A(), linear.B())


def workcell_loop(
    q: np.ndarray | None = None,
    *,
    latency: float | None = None,
    use: Literal["delayed", "predicted"] = "predicted",
    schedule: Schedule = Schedule(),
) -> SampledLoop:
    """The loop of ``ServoRobot`` about the joint angles q (6,) [rad] (default: the arm's nominal pose).

    latency: from an exposure to the servo's tick [s]; default: the schedule's.
    """
    return SampledLoop(
        arm_response(puma560.NAMED["nominal"] if q is None else q),
        latency=schedule.latency if latency is None else latency,
        use=use,
        camera=schedule.camera,
        arm=schedule.arm,
        arm_offset=schedule.arm_offset,
        smooth=True,
    )
