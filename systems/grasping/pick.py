"""Picking an object up, as a state machine of pure functions: look, reach, approach, close, verify, lift, look again, carry, hold.

Nothing here knows where the object truly is: it is seen by the tracker, and felt by motor positions and torques of the hand. A grasp that
fails is undone, the object is looked for again, and the next grasp is tried; after the last the hand opens and the arm stands still.
Frames: W world = the arm's base, C camera, O object, E hand. Source: paper III-E.
"""

from dataclasses import dataclass, field, replace

import numpy as np

from vipr.systems import se3
from vipr.systems.errors import InputError
from vipr.systems.grasping.grasp import GraspTable
from vipr.systems.grasping.options import unrolled, way_up
from vipr.systems.grasping.pick_state import (
    CARRYING,
    WATCHING,
    PickSettings,
    PickState,
    Senses,
    end,
    go,
    hint,
    look_for,
    seen,
    stay,
    watch,
)
from vipr.systems.grasping.planning import Surroundings, free_path, plan_grasp
from vipr.systems.grasping.support import settled, settled_doubt
from vipr.systems.hand import transmission


@dataclass(frozen=True, eq=False)
class Picker:
    """What a pick is done with: the grasps, the arm and its surroundings, the calibrated camera."""

    table: GraspTable
    around: Surroundings
    X_WC: np.ndarray
    settings: PickSettings = PickSettings()
    error: np.ndarray = field(
        default_factory=lambda: np.zeros(6)
    )  # rad and m in W, added to what is seen: for measuring
    error_believed: bool = False  # it is added to what is believed after that: the support cannot correct it

    def start(self, X_CO: np.ndarray) -> PickState:
        """Before the first tick, with a rough idea of where the object is."""
        return PickState(initial=hint(X_CO, 0.0))

    def step(self, state: PickState, senses: Senses) -> PickState:
        """The state after a tick."""
        if len(state.q_hold) == 0:
            state = replace(state, q_home=senses.q, q_hold=senses.q, command=senses.motors)
        if state.ended:
            return state
        if state.phase in CARRYING:
            state = self._feel(state, senses)
        if state.phase in WATCHING:
            state = watch(state, senses)
        return getattr(self, f"_{state.phase}")(state, senses)

    def rates(self, state: PickState, senses: Senses) -> np.ndarray:
        """Joint rates (6,) [rad/s] for the arm now."""
        if state.path is None:
            return np.zeros(6) if len(state.q_hold) == 0 else self.settings.gain * (state.q_hold - senses.q)
        q, rate = state.path.at(senses.time - state.since)
        return rate + self.settings.gain * (q - senses.q)

    # One method a phase: the state that follows.

    def _look(self, state, senses):
        X_CO = seen(state, self.settings)
        X_WO, doubt = (None, np.inf) if X_CO is None else self._placed(self.X_WC @ X_CO, state.covariance)
        if not doubt <= 1e-3 * self.settings.sure_mm:
            if senses.time - state.since <= self.settings.look_s:
                return state
            known = "" if X_CO is None else f" well enough: its place is known to {1e3 * doubt:.0f} mm"
            return end(state, senses, "gave up", f"the object is not seen{known}")
        if self.error_believed:
            X_WO = self._spoilt(X_WO)
        try:
            plan = plan_grasp(
                self.table, X_WO, senses.q, self.around, self.settings.errand, senses.motors, tried=state.tried
            )
        except InputError as error:
            return end(state, senses, "gave up", str(error))
        tried = (*state.tried, plan.grasp.name)
        state = replace(state, plan=plan, X_WO=X_WO, tried=tried, attempt=state.attempt + 1, slack=float("nan"))
        command = np.append(plan.grasp.preshape, plan.grasp.spread)
        text = f"reach for {plan.grasp.name}"
        return go(replace(state, command=command, limit=np.full(4, 1.8)), senses, "reach", plan.reach, text)

    def _reach(self, state, senses):
        if not self._arrived(state, senses):
            return state
        return go(state, senses, "approach", state.plan.approach)

    def _approach(self, state, senses):
        if state.path is None:  # a little back from what it has met
            if senses.time - state.since < self.settings.ease_s:
                return state
        elif np.abs(senses.torque[:3]).max() > self.settings.touch_torque:
            return self._touched(state, senses)
        elif not self._arrived(state, senses):
            return state
        limit = np.append(state.plan.grasp.torque, 2.0)
        return replace(stay(state, senses, "close"), limit=limit, motors=senses.motors, moved=senses.time)

    def _touched(self, state, senses):
        """A finger has met something before the grasp was reached: back off, and close there if that is near enough."""
        arm = self.around.arm
        plan = state.plan.stopped(senses.q, arm)
        state = replace(state, plan=plan, path=None, q_hold=plan.approach.end)
        short, finger = 1e3 * plan.short(arm), int(np.abs(senses.torque[:3]).argmax()) + 1
        text = f"finger {finger} has met something {short:.0f} mm before the grasp"
        if short > self.settings.short_mm:
            return self._let_go(state, senses, text)
        return stay(state, senses, "approach", f"approach: {text}", "warning")

    def _close(self, state, senses):
        grasp, since = state.plan.grasp, senses.time - state.since
        fingers = np.minimum(grasp.preshape + self.settings.close_rate * since, transmission.MOTOR_UPPER[:3])
        state = replace(state, command=np.append(fingers, grasp.spread))
        if np.abs(senses.motors[:3] - state.motors[:3]).max() > 0.002:
            state = replace(state, motors=senses.motors, moved=senses.time)
        if since > 0.3 and senses.time - state.moved > 0.1:
            state = replace(state, command=np.append(senses.motors[:3], grasp.spread))
            return stay(state, senses, "verify")
        return state

    def _verify(self, state, senses):
        if senses.time - state.since < self.settings.settle_s:
            return state
        wrong = self.doubt(state.plan.grasp.closed, senses.motors[:3], senses.torque[:3], state.plan.grasp.torque)
        if wrong:
            return self._let_go(state, senses, f"nothing well held: {wrong}")
        X_EO = se3.inverse(self.around.arm.tool_pose(senses.q)) @ state.X_WO
        state = replace(state, grip=np.maximum(senses.torque[:3], 0.0), X_EO=X_EO)
        return go(state, senses, "lift", state.plan.lift)

    def doubt(self, taught: np.ndarray, closed: np.ndarray, torque: np.ndarray, limit: np.ndarray) -> str:
        """What speaks against the object being held, by finger angles (3,) [rad] and motor torques (3,) [N m]; empty if nothing does."""
        off = np.degrees(np.abs(closed - taught))
        if off.max() > self.settings.closed_within_deg:
            return f"finger {int(off.argmax()) + 1} stopped {off.max():.0f} deg from where it should"
        firm = torque >= self.settings.least_torque * limit
        if not firm[2] or not firm[:2].any():
            return "finger 3 bears no load" if not firm[2] else "fingers 1 and 2 bear no load"
        return ""

    def _lift(self, state, senses):
        if not self._arrived(state, senses):
            return state
        return look_for(stay(state, senses, "check"), senses, self._expected(state, senses))

    def _check(self, state, senses):
        X_CO = seen(state, self.settings)
        if X_CO is None:
            if senses.time - state.since <= self.settings.look_s:
                return state
            return go(state, senses, "carry", state.plan.carry, "carry, by feel: the object is not seen", "warning")
        if self._shift(state, senses, X_CO) > 1e-3 * self.settings.drop_mm:
            return self._let_go(state, senses, "it is seen not to be in the hand")
        X_EO = se3.inverse(self.around.arm.tool_pose(senses.q)) @ self.X_WC @ X_CO
        return go(replace(state, X_EO=X_EO), senses, "carry", state.plan.carry)

    def _carry(self, state, senses):
        return stay(state, senses, "hold") if self._arrived(state, senses) else state

    def _hold(self, state, senses):
        if senses.time - state.since < self.settings.hold_s:
            return state
        return look_for(stay(state, senses, "confirm"), senses, self._expected(state, senses))

    def _confirm(self, state, senses):
        X_CO = seen(state, self.settings)
        if X_CO is None:
            if senses.time - state.since <= self.settings.look_s:
                return state
            return end(state, senses, "held", "held, by feel: the object is not seen", "warning")
        slip = self._shift(state, senses, X_CO)
        state = replace(state, slip=slip)
        if slip > 1e-3 * self.settings.drop_mm:
            return self._let_go(state, senses, "it is seen not to be in the hand")
        slipped = slip > 1e-3 * self.settings.slip_mm
        text = f"held, but slipped by {1e3 * slip:.0f} mm" if slipped else "held"
        return end(state, senses, "held", text, "warning" if slipped else "info")

    def _release(self, state, senses):
        if senses.time - state.since < 0.8:
            return state
        return go(state, senses, "retreat", state.plan.approach.reversed() if state.low else None)

    def _retreat(self, state, senses):
        if state.path is not None and not self._arrived(state, senses):
            return state
        if state.path is not None:  # at the reference point: the way it came
            return go(state, senses, "home", state.plan.reach.reversed())
        try:
            path = free_path(senses.q, state.q_home, self.around, senses.motors)
        except InputError as error:
            return end(state, senses, "gave up", str(error))
        return go(state, senses, "home", path)

    def _home(self, state, senses):
        if not self._arrived(state, senses):
            return state
        if state.attempt >= self.settings.attempts:
            return end(state, senses, "gave up", f"no grasp held in {state.attempt} attempts")
        return look_for(stay(state, senses, "look"), senses, se3.inverse(self.X_WC) @ state.X_WO)

    # What the phases share.

    def _placed(self, X_WO: np.ndarray, covariance: np.ndarray) -> tuple[np.ndarray, float]:
        """X_WO of what is seen there, and its standard deviation [m]; with the support's help where there is one."""
        X_seen = X_WO if self.error_believed else self._spoilt(X_WO)
        X_WO, support = unrolled(self.table.symmetry, X_seen), self.around.support
        up = way_up(self.table, X_WO)
        if not self.settings.settle or support is None or up is None:
            return X_WO, float(np.sqrt(np.trace(covariance)))
        X_WO = settled(X_WO, up, support, self.X_WC)
        return X_WO, settled_doubt(X_WO, covariance, self.X_WC)

    def _spoilt(self, X_WO: np.ndarray) -> np.ndarray:
        """The pose with the error that is added to it for measuring."""
        w, v = self.error[:3], self.error[3:]
        return se3.pose(se3.exp_so3(w) @ X_WO[:3, :3], X_WO[:3, 3] + v)

    def _arrived(self, state, senses) -> bool:
        late = senses.time - state.since - state.path.duration
        return late > self.settings.settle_s and (np.abs(senses.q - state.path.end).max() < 2e-3 or late > 1.0)

    def _expected(self, state, senses) -> np.ndarray:
        """X_CO of the object if it is in the hand as believed."""
        return se3.inverse(self.X_WC) @ self.around.arm.tool_pose(senses.q) @ state.X_EO

    def _shift(self, state, senses, X_CO) -> float:
        """How far across the line of sight the object is seen from where the hand should have it [m]; along it little is seen."""
        shift, ray = X_CO[:3, 3] - self._expected(state, senses)[:3, 3], X_CO[:3, 3] / np.linalg.norm(X_CO[:3, 3])
        return float(np.linalg.norm(shift - ray * (ray @ shift)))

    def _feel(self, state, senses):
        """Watch the fingers while something is carried: let go of what is not there any more."""
        slack = senses.torque[:3] < self.settings.lost_torque * state.grip
        if not (slack[2] or slack[:2].all()):
            return replace(state, slack=float("nan")) if np.isfinite(state.slack) else state
        if not np.isfinite(state.slack):
            return replace(state, slack=senses.time)
        if senses.time - state.slack < self.settings.lost_s:
            return state
        return self._let_go(state, senses, "dropped: the fingers bear nothing any more")

    def _let_go(self, state, senses, why: str):
        """Open, and try again or give up."""
        low = state.phase in ("approach", "verify")
        command = np.append(state.plan.grasp.preshape, state.plan.grasp.spread)
        state = replace(stay(state, senses, "release", f"release: {why}", "warning"), command=command)
        return replace(state, limit=np.full(4, 1.8), low=low)
