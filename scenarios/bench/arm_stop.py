"""How the simulated arm stops under its joint servo when it is told to stand, from the greatest speed that servoing allows."""

from dataclasses import replace

import numpy as np
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder
from pydrake.systems.primitives import ConstantVectorSource, TrajectorySource
from pydrake.trajectories import PiecewisePolynomial

from vipr.diagrams.servo_robot import STOPPING_TIME, Schedule
from vipr.diagrams.workcell import Workcell, WorkcellConfig, held_shapes
from vipr.diagrams.workcell_layout import collision_guard, obstacles
from vipr.scenarios.bench.tables import Table
from vipr.scenarios.motions import out_and_back
from vipr.scenarios.servoing import stage_and_fingers
from vipr.systems import se3
from vipr.systems.arm import puma560
from vipr.systems.arm.commander import ArmCommander

TOLD = 0.44  # s, when the arm is told to stand; before that it is asked for more than it may do
WATCHED, STEP = 0.5, 0.002  # s after that, and how often it is looked at
NEAR = 0.0005  # m, from where it ends, of a hand that stands
FREE = 0.08  # m, that arm, hand and carton are from everything at the start: farther than they go
CARTON = se3.pose(np.diag([1.0, -1.0, -1.0]), [0.0, 0.0, 0.2])  # X_EO: upright below the hand, its top in the fingers


def stopping(count: int, seed: int) -> Table:
    """The table of ``count`` random places and directions."""
    rows = np.array([_stop(np.random.default_rng([seed, k])) for k in range(count)])
    table = Table(
        f"Stopping from the greatest speed of servoing, {count} random places and directions, a milk carton in the hand that the joint "
        "servo does not know",
        ("quantity", "median", "worst"),
        note=f"From the first set-point that brakes, {1e3 * Schedule().exposure_to_command:g} ms after the exposure that it answers. "
        f"Stands: within {1e3 * NEAR:g} mm of where it ends, for good. Swing: the farthest from there once the set-points have stood for "
        "10 ms.",
    )
    names = ("speed of the hand before, mm/s", "set-points at rest, ms", "the hand stands, ms", "swing, mm")
    for name, values in zip(names, rows.T, strict=True):
        table.rows.append((name, float(np.median(values)), float(values.max())))
    return table


def _stop(rng: np.random.Generator) -> tuple[float, ...]:
    simulator, cell, arm = _told_to_stand(rng)
    context = simulator.get_context()
    plant, moving = cell.plant, cell.plant.GetMyContextFromRoot(context)
    palm, begin = plant.GetBodyByName("palm"), TOLD + Schedule().arm_offset
    p, rates = [], []
    for t in np.arange(0.0, WATCHED, STEP):
        simulator.AdvanceTo(begin + t - 1e-6)
        p.append(plant.EvalBodyPoseInWorld(moving, palm).translation().copy())
        rates.append(np.abs(arm.GetOutputPort("desired_state").Eval(arm.GetMyContextFromRoot(context))[6:]).max())
    away, ms = np.linalg.norm(np.array(p) - p[-1], axis=1), 1e3 * STEP
    rest, stands = int(np.argmax(np.array(rates) < 1e-9)), int(np.flatnonzero(away > NEAR)[-1]) + 1
    return 1e3 * (away[0] - away[1]) / STEP, ms * rest, ms * stands, 1e3 * away[rest + round(0.01 / STEP) :].max()


def _told_to_stand(rng: np.random.Generator) -> tuple[Simulator, Workcell, ArmCommander]:
    """The workcell, its camera off, and its set-points, asked for a random twist and from ``TOLD`` on for none."""
    builder, schedule = DiagramBuilder(), Schedule()
    config = WorkcellConfig(X_EO_held=CARTON)
    guard = collision_guard(held_shapes(config))
    q = puma560.NAMED["nominal"]
    while guard.body.clearance(q, obstacles())[0] < FREE:
        q = puma560.NAMED["nominal"] + rng.uniform(-0.6, 0.6, 6)
    cell = builder.AddSystem(Workcell(replace(config, q_initial=q)))
    arm = builder.AddSystem(
        ArmCommander(
            cell.arm, cell.joint_limits, q, stopping_time=STOPPING_TIME, period=schedule.arm, offset=schedule.arm_offset
        )
    )
    V = 20.0 * rng.normal(size=6) * [1, 1, 1, 0.5, 0.5, 0.5]
    asked = PiecewisePolynomial.ZeroOrderHold([0.0, TOLD, 10.0], np.column_stack([V, np.zeros(6), np.zeros(6)]))
    still = out_and_back(np.zeros(3), np.zeros(3), begin=1.0, cruise=0.0)
    sources = {**stage_and_fingers(still), "watching": ConstantVectorSource([0.0])}
    for name, source in sources.items():
        builder.Connect(builder.AddSystem(source).get_output_port(), cell.GetInputPort(name))
    builder.Connect(builder.AddSystem(TrajectorySource(asked)).get_output_port(), arm.GetInputPort("V_WE_W"))
    builder.Connect(arm.GetOutputPort("desired_state"), cell.GetInputPort("arm_desired_state"))
    return Simulator(builder.Build()), cell, arm
