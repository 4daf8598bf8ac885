"""The servo loop of the workcell as ``systems.servo.analysis`` examines it: Drake linearises the arm, the schedule gives the clocks."""

from typing import Literal

import numpy as np
from pydrake.systems.controllers import InverseDynamics
from pydrake.systems.framework import DiagramBuilder
from pydrake.systems.primitives import Adder, Linearize, MatrixGain

from vipr.diagrams.servo_robot import Schedule
from vipr.diagrams.workcell import DAMPING, STIFFNESS, nominal_arm
from vipr.systems.arm import puma560
from vipr.systems.servo.analysis import ArmResponse, SampledLoop


def arm_response(q: np.ndarray) -> ArmResponse:
    """How the arm, with its hand and its joint servo, follows set-points near q (6,) [rad]: Drake's linearisation of the plant.

    The loop is that of ``Workcell``: a PD controller in each joint and gravity compensation, on rotor and link inertia and viscous
    friction; encoder steps and the plant's own time step (2 ms) are left out.
    """
    builder = DiagramBuilder()
    plant = builder.AddSystem(nominal_arm())
    gains = np.hstack([np.diag(STIFFNESS), np.diag(DAMPING)])
    servo, back = builder.AddSystem(MatrixGain(gains)), builder.AddSystem(MatrixGain(-gains))
    gravity = builder.AddSystem(InverseDynamics(plant, InverseDynamics.InverseDynamicsMode.kGravityCompensation))
    torque = builder.AddSystem(Adder(3, len(STIFFNESS)))
    state = plant.get_state_output_port()
    builder.Connect(state, back.get_input_port())
    builder.Connect(state, gravity.get_input_port_estimated_state())
    for k, part in enumerate((servo, back, gravity)):
        builder.Connect(part.get_output_port(), torque.get_input_port(k))
    builder.Connect(torque.get_output_port(), plant.get_actuation_input_port())
    builder.ExportInput(servo.get_input_port(), "desired_state")
    builder.ExportOutput(state, "state")
    diagram = builder.Build()
    context = diagram.CreateDefaultContext()
    rest = np.concatenate([q, np.zeros(6)])
    context.SetContinuousState(rest)
    diagram.get_input_port().FixValue(context, rest)
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
    )
