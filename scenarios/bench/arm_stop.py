"""How the simulated arm stops under its joint servo when it is told to stand, from the greatest speed that servoing allows."""

import numpy as np
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder
from pydrake.systems.primitives import ConstantVectorSource, TrajectorySource
from pydrake.trajectories import PiecewisePolynomial

from vipr.diagrams.servo_robot import STOPPING_TIME, Schedule
from vipr.diagrams.workcell import Workcell, WorkcellConfig
from vipr.scenarios.bench.tables import Table
from vipr.scenarios.motions import out_and_back
from vipr.scenarios.servoing import stage_and_fingers
from vipr.systems.arm import puma560
from vipr.systems.arm.commander import ArmCommander

TOLD = 0.44  # s, when the arm is told to stand; before that it is asked for more than it may do
WATCHED, STEP = 0.6, 0.002  # s after that, and how often it is looked at
SLOW = 0.005  # m/s, of a hand that stands


def stopping(count: int, seed: int) -> Table:
    """The table of ``count`` random directions."""
    rows = np.array([_stop(np.random.default_rng([seed, k])) for k in range(count)])
    table = Table(
        f"Stopping from the greatest speed of servoing, {count} random directions, the arm's dynamics and joint servo",
        ("quantity", "median", "worst"),
        note="From the first set-point that brakes. Turns: when the hand first comes to rest or begins to swing back; swing: the farthest "
        f"from where it ends after that; still: slower than {1e3 * SLOW:g} mm/s for good.",
    )
    names = ("speed of the hand before, mm/s", "set-points at rest, ms", "the hand turns, ms", "swing, mm", "still, ms")
    for name, values in zip(names, rows.T, strict=True):
        table.rows.append((name, float(np.median(values)), float(values.max())))
    return table


def _stop(rng: np.random.Generator) -> tuple[float, ...]:
    q = puma560.NAMED["nominal"] + rng.uniform(-0.3, 0.3, 6)
    simulator, cell, arm = _told_to_stand(q, 20.0 * rng.normal(size=6) * [1, 1, 1, 0.5, 0.5, 0.5])
    context = simulator.get_context()
    plant, moving = cell.plant, cell.plant.GetMyContextFromRoot(context)
    palm, begin = plant.GetBodyByName("palm"), TOLD + Schedule().arm_offset
    p, v, rates = [], [], []
    for t in np.arange(0.0, WATCHED, STEP):
        simulator.AdvanceTo(begin + t - 1e-6)
        p.append(plant.EvalBodyPoseInWorld(moving, palm).translation().copy())
        v.append(plant.EvalBodySpatialVelocityInWorld(moving, palm).translational().copy())
        rates.append(np.abs(arm.GetOutputPort("desired_state").Eval(arm.GetMyContextFromRoot(context))[6:]).max())
    p, v, ms = np.array(p), np.array(v), 1e3 * STEP
    onward = v @ v[0]
    turn = int(np.argmax(onward <= 0)) if (onward <= 0).any() else len(v)
    swing = np.linalg.norm(p[turn:] - p[-1], axis=1).max(initial=0.0)
    still = int(np.flatnonzero(np.linalg.norm(v, axis=1) > SLOW)[-1]) + 1
    return 1e3 * np.linalg.norm(v[0]), ms * int(np.argmax(np.array(rates) < 1e-9)), ms * turn, 1e3 * swing, ms * still


def _told_to_stand(q: np.ndarray, V: np.ndarray) -> tuple[Simulator, Workcell, ArmCommander]:
    """The workcell, its camera off, and its set-points, asked for the twist V (6,) and from ``TOLD`` on for none."""
    builder, schedule = DiagramBuilder(), Schedule()
    cell = builder.AddSystem(Workcell(WorkcellConfig(q_initial=q)))
    arm = builder.AddSystem(
        ArmCommander(
            cell.arm, cell.joint_limits, q, stopping_time=STOPPING_TIME, period=schedule.arm, offset=schedule.arm_offset
        )
    )
    asked = PiecewisePolynomial.ZeroOrderHold([0.0, TOLD, 10.0], np.column_stack([V, np.zeros(6), np.zeros(6)]))
    still = out_and_back(np.zeros(3), np.zeros(3), begin=1.0, cruise=0.0)
    sources = {**stage_and_fingers(still), "watching": ConstantVectorSource([0.0])}
    for name, source in sources.items():
        builder.Connect(builder.AddSystem(source).get_output_port(), cell.GetInputPort(name))
    builder.Connect(builder.AddSystem(TrajectorySource(asked)).get_output_port(), arm.GetInputPort("V_WE_W"))
    builder.Connect(arm.GetOutputPort("desired_state"), cell.GetInputPort("arm_desired_state"))
    return Simulator(builder.Build()), cell, arm
