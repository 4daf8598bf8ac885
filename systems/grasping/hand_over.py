"""From the pick to the servo: who moves the arm, once an object is held, and when it has come to its place."""

from dataclasses import dataclass, replace

import numpy as np
from pydrake.common.value import Value
from pydrake.systems.framework import BasicVector, LeafSystem

from vipr.systems.errors import InputError
from vipr.systems.signals import Signal, Status

HELD = "held"  # how a pick's phase begins that has succeeded
ENDS = ("placed", "gave up")


@dataclass(frozen=True)
class Arrival:
    """When an object counts as placed, by the servo's own belief, and how long it may take."""

    within_mm: float = 0.5
    within_deg: float = 0.2
    stay_s: float = 0.6
    patience_s: float = 12.0

    def __post_init__(self):
        for name in self.__dataclass_fields__:
            if not getattr(self, name) > 0:
                raise InputError(f"arrival: {name} must be positive, got {getattr(self, name)}")


@dataclass(frozen=True, eq=False)
class Progress(Signal):
    """Since when the servo has moved the arm, and since when the object has been close to its place [s]; NaN: not yet."""

    since: float = float("nan")
    close_since: float = float("nan")
    end: str = ""  # how it ended

    @property
    def placing(self) -> bool:
        return bool(np.isfinite(self.since))


def proceed(held: Progress, time: float, picked: bool, error: np.ndarray, arrival: Arrival) -> Progress:
    """The progress after a tick: ``picked``, whether the pick has ended well; error (6,) theta u [rad] and t [m], NaN while unknown."""
    if held.end or not picked:
        return held
    if not held.placing:
        return replace(held, since=time)
    deg, mm = np.rad2deg(np.linalg.norm(error[:3])), 1e3 * np.linalg.norm(error[3:])
    close = bool(mm < arrival.within_mm and deg < arrival.within_deg)
    if not close:
        late = time - held.since > arrival.patience_s
        end = f"gave up: not at its place after {arrival.patience_s:g} s" if late else ""
        return replace(held, close_since=float("nan"), end=end)
    if not np.isfinite(held.close_since):
        return replace(held, close_since=time)
    return replace(held, end="placed" if time - held.close_since >= arrival.stay_s else "")


class HandOver(LeafSystem):
    """Lets the pick move the arm until it holds the object, and the servo from then on.

    .. pydrake_system::

        name: HandOver
        input_ports:
        - V_pick
        - pick_phase
        - pick_watching
        - V_place
        - servo_error
        - servo_status
        output_ports:
        - V_WE_W
        - phase
        - watching

    Frames: W world, E hand. ``V_pick`` and ``V_place`` (6) are the twists (w, v) [rad/s, m/s] that pick and servo ask for; ``V_WE_W`` is
    the pick's until ``pick_phase`` (Status) begins with "held", then the servo's. Every ``period`` it looks whether ``servo_error`` (6),
    theta u [rad] and t [m], has stayed small (see ``Arrival``). ``phase`` (Status) is the pick's, then "place" with what the servo says,
    and at the end "placed", or "gave up" with the reason. ``watching`` (1) is the pick's, and 1 once the servo needs the camera.
    """

    def __init__(self, *, arrival: Arrival = Arrival(), period: float = 0.02, offset: float = 0.0):
        super().__init__()
        self._arrival = arrival
        self._V_pick = self.DeclareVectorInputPort("V_pick", 6)
        self._pick_phase = self.DeclareAbstractInputPort("pick_phase", Value(Status()))
        self._pick_watching = self.DeclareVectorInputPort("pick_watching", 1)
        self._V_place = self.DeclareVectorInputPort("V_place", 6)
        self._error = self.DeclareVectorInputPort("servo_error", 6)
        self._status = self.DeclareAbstractInputPort("servo_status", Value(Status()))
        self._progress = self.DeclareAbstractState(Value(Progress()))
        self.DeclarePeriodicUnrestrictedUpdateEvent(period, offset, self._update)
        held = self.abstract_state_ticket(self._progress)

        def reading(*ports):
            return {held, *(self.input_port_ticket(port.get_index()) for port in ports)}

        self.DeclareVectorOutputPort("V_WE_W", BasicVector(6), self._calc_V_WE_W, reading(self._V_pick, self._V_place))
        self.DeclareAbstractOutputPort(
            "phase", lambda: Value(Status()), self._calc_phase, reading(self._pick_phase, self._status)
        )
        self.DeclareVectorOutputPort("watching", BasicVector(1), self._calc_watching, reading(self._pick_watching))

    def _held(self, context) -> Progress:
        return context.get_abstract_state(int(self._progress)).get_value()

    def _update(self, context, state):
        picked = self._pick_phase.Eval(context).text.startswith(HELD)
        new = proceed(self._held(context), context.get_time(), picked, self._error.Eval(context), self._arrival)
        state.get_mutable_abstract_state(int(self._progress)).set_value(new)

    def _calc_V_WE_W(self, context, output):
        output.set_value((self._V_place if self._held(context).placing else self._V_pick).Eval(context))

    def _calc_phase(self, context, output):
        held = self._held(context)
        if not held.placing:
            output.set_value(self._pick_phase.Eval(context))
        elif held.end:
            output.set_value(Status(held.end, "info" if held.end == ENDS[0] else "error"))
        else:
            servo = self._status.Eval(context)
            output.set_value(Status("place" if servo.level == "info" else f"place: {servo.text}", servo.level))

    def _calc_watching(self, context, output):
        output.set_value([1.0] if self._held(context).placing else self._pick_watching.Eval(context))
