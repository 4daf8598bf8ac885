"""The servo moves the arm once the object is held, and an object counts as placed only if it stays at its place."""

import numpy as np
import pytest
from pydrake.systems.analysis import Simulator

from vipr.systems.errors import InputError
from vipr.systems.grasping.hand_over import Arrival, HandOver, Progress, proceed
from vipr.systems.signals import Status

ARRIVAL = Arrival(within_mm=1.0, within_deg=1.0, stay_s=0.1, patience_s=1.0)
NEAR, FAR = np.array([0, 0, 0, 5e-4, 0, 0]), np.array([0, 0, 0, 5e-3, 0, 0])


def after(errors, picked=True, dt=0.04):
    progress = Progress()
    for k, error in enumerate(errors):
        progress = proceed(progress, k * dt, picked, error, ARRIVAL)
    return progress


def test_nothing_is_handed_over_before_the_object_is_held():
    assert not after([NEAR] * 50, picked=False).placing


def test_an_object_that_stays_at_its_place_is_placed():
    assert after([NEAR] * 3).end == ""
    assert after([NEAR] * 6).end == "placed"


def test_an_object_that_passes_its_place_is_not_placed():
    assert after([FAR, FAR, NEAR, NEAR, FAR, NEAR, NEAR]).end == ""


@pytest.mark.parametrize("error", [FAR, np.full(6, np.nan), np.array([0.1, 0, 0, 0, 0, 0])])
def test_an_object_that_does_not_come_to_its_place_is_given_up(error):
    assert after([error] * 40).end == "gave up: not at its place after 1 s"


def test_the_arm_follows_the_pick_and_then_the_servo_and_the_phase_says_what_the_servo_says():
    dut = HandOver(arrival=ARRIVAL)
    simulator = Simulator(dut)
    context = simulator.get_mutable_context()

    def tick(time, phase, servo=Status("servoing"), error=FAR):
        for name, value in (("V_pick", np.full(6, 0.1)), ("V_place", np.full(6, 0.2)), ("servo_error", error)):
            dut.GetInputPort(name).FixValue(context, value)
        dut.GetInputPort("pick_phase").FixValue(context, Status(phase))
        dut.GetInputPort("pick_watching").FixValue(context, [0.0])
        dut.GetInputPort("servo_status").FixValue(context, servo)
        simulator.AdvanceTo(time)
        simulator.AdvancePendingEvents()
        V, phase, watching = (dut.GetOutputPort(name).Eval(context) for name in ("V_WE_W", "phase", "watching"))
        return V[0], phase.text, phase.level, watching[0]

    assert tick(0.0, "carry") == (0.1, "carry", "info", 0.0)
    assert tick(0.04, "held, but slipped by 13 mm") == (0.2, "place", "info", 1.0)
    lost = Status("target lost: holding still", "warning")
    assert tick(0.08, "held", lost) == (0.2, "place: target lost: holding still", "warning", 1.0)
    assert tick(0.16, "held", error=NEAR)[1] == "place"
    assert tick(0.5, "held", error=NEAR) == (0.2, "placed", "info", 1.0)
    assert tick(0.6, "held", error=FAR)[1] == "placed", "how it ended stays said"


def test_settings_that_make_no_sense_are_refused():
    with pytest.raises(InputError, match="arrival: stay_s must be positive, got 0"):
        Arrival(stay_s=0)
