"""One pick without a folder: simulated to its end, watched at every camera tick, judged against truth."""

from dataclasses import replace

import numpy as np
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import Diagram

from vipr.scenarios.pick import Pick, judge_pick
from vipr.scenarios.settings import load_settings
from vipr.systems.errors import InputError
from vipr.systems.grasping.pick_state import ENDS
from vipr.systems.timing import LEDGER

TICK, OFFSET = 0.04, 0.039  # s, of what is watched


def pick_trial(object_: str, seed: int, overrides: tuple[str, ...] = ()) -> dict:
    """Figures of one pick by name; ``refused`` says why the robot did not begin."""
    settings = load_settings(Pick.settings_type, Pick.settings_file(), [f"object={object_}", *overrides])
    row = {"object": object_, "seed": seed}
    try:
        scenario = Pick(replace(settings, film=False), seed)
    except InputError as error:
        return row | {"refused": str(error), "held": 0.0, "success": False, "reason": str(error)}
    diagram = scenario.build()
    LEDGER.reset()
    times, X_WO, X_WE, phases, kinetic = _watch(diagram, scenario.duration)
    outcome = judge_pick(times, X_WO, X_WE, phases, settings.pick.errand.lift)
    hold = [t for t, text in phases if text == "hold"]
    if hold and outcome.success and settings.pick.hold_s > 1.0:
        during = (times > hold[-1] + 0.5) & (times < hold[-1] + settings.pick.hold_s)
        energy = kinetic[during]
        third = max(1, len(energy) // 3)
        row |= {"kinetic_first_j": float(energy[:third].max()), "kinetic_last_j": float(energy[-third:].max())}
    up = scenario.placement.X_PO[:3, :3].T @ [0.0, 0.0, 1.0]
    grasp = next((text.removeprefix("reach for ") for _, text in reversed(phases) if text.startswith("reach")), "")
    row |= {"lie": "".join(a for a, v in zip("xyz", up, strict=True) if abs(v) > 0.5), "grasp": grasp}
    return row | outcome.figures | {"success": outcome.success, "reason": outcome.reason}


def _watch(diagram: Diagram, duration: float):
    """Times, true poses of object and hand, the task's phases, and the kinetic energy of everything [J], until the task has ended."""
    simulator = Simulator(diagram)
    context = simulator.get_mutable_context()
    plant = diagram.GetSubsystemByName("robot").GetSubsystemByName("workcell").plant
    moving = plant.GetMyContextFromRoot(context)
    ports = {name: diagram.GetOutputPort(name) for name in ("X_WO_true", "X_WE_true", "phase")}
    times, X_WO, X_WE, kinetic, phases = [], [], [], [], []
    ended = np.inf
    for tick in range(round(duration / TICK)):
        time = tick * TICK + OFFSET
        simulator.AdvanceTo(time)
        times.append(time)
        X_WO.append(ports["X_WO_true"].Eval(context).GetAsMatrix4())
        X_WE.append(ports["X_WE_true"].Eval(context).GetAsMatrix4())
        kinetic.append(plant.EvalKineticEnergy(moving))
        text = ports["phase"].Eval(context).text
        if not phases or phases[-1][1] != text:
            phases.append((time, text))
        if text.startswith(ENDS):
            ended = min(ended, time + 0.2)
        if time > ended:
            break
    return np.array(times), np.array(X_WO), np.array(X_WE), phases, np.array(kinetic)
