"""``pick_and_place``: an object is grasped as it was taught and, held by friction alone, brought by sight to where it was shown."""

from dataclasses import dataclass
from functools import partial
from typing import Annotated

import numpy as np
from pydrake.systems.framework import Context, Diagram

from vipr.diagrams.pick_then_place import PickThenPlace
from vipr.diagrams.workcell_layout import JOINT_LIMITS, puma_with_hand
from vipr.scenarios.pick import Pick, PickScenarioSettings, farthest_in_hand
from vipr.scenarios.place_by_showing import PlaceByShowing, PlaceSettings, in_view
from vipr.scenarios.placements import Placement, around
from vipr.scenarios.scenario import Outcome
from vipr.scenarios.servoing import WORKSPACE, joints_for
from vipr.scenarios.settings import ONE_OF, require_within
from vipr.systems import se3
from vipr.systems.errors import InputError
from vipr.systems.grasping.hand_over import ENDS, Arrival
from vipr.systems.grasping.planning import plan_grasp
from vipr.systems.recording.history import History
from vipr.systems.servo.laws import ServoLaw
from vipr.systems.servo.position_based import PositionBased
from vipr.systems.servo.target_filter import TargetMotion
from vipr.systems.tracking.tracker import ModelTracker

FARTHEST_TURN = 1.5  # rad, of any joint from where the object is carried to its place
MOST_TURN = np.deg2rad(60.0)  # of the object on its way


@dataclass(frozen=True, kw_only=True)
class PickAndPlaceSettings(PickScenarioSettings):
    """What can be set with ``--set`` or in ``pick_and_place.yaml``."""

    place: int = 1  # number of the shown place
    shown: str = ""  # file of ``vipr teach``; empty: the place is shown before the run
    supersampling: int = 2
    servo: Annotated[ServoLaw, ONE_OF] = PositionBased()
    target: TargetMotion = TargetMotion()
    arrival: Arrival = Arrival()
    max_error_mm: float = 2.0  # allowed at the end
    max_error_deg: float = 0.5

    def __post_init__(self):
        super().__post_init__()
        require_within(self, place=(0, 10**6), max_error_mm=(0, 1000), max_error_deg=(0, 180))


class PickAndPlace(Pick):
    """The seed chooses where the object stands, the number of the place where it shall go (see ``place_by_showing``).

    The place is shown with the object on a mount; here it is held as it was grasped. The servo knows neither how: it sees the object.
    """

    name = "pick_and_place"
    summary = "grasp an object as taught and bring it by sight to where it was shown (paper III-E, III-F)"
    settings_type = PickAndPlaceSettings

    def __init__(self, settings: PickAndPlaceSettings, seed: int):
        s = settings
        showing = PlaceSettings(
            object=s.object,
            place=s.place,
            shown=s.shown,
            camera=s.camera,
            supersampling=s.supersampling,
            tracker=s.tracker,
            calibration=s.calibration,
        )
        self.showing = PlaceByShowing(showing, seed)
        super().__init__(settings, seed)

    def _place(self, rng: np.random.Generator) -> Placement:
        for _ in range(1 if self.place_given else 60):
            placement = super()._place(rng)
            if self._can_go(placement):
                return placement
        raise InputError(
            f"{self.name}: no place on the stage was found from which the {self.settings.object} can go to its place"
        )

    def _can_go(self, placement: Placement) -> bool:
        """Whether the hand, with the grasp that it would take, can bring the object to its place, in the camera's view from the start."""
        X_WO_goal, config = self.showing.X_WO_shown, self.showing.config
        if se3.angle_between(placement.X_WO, X_WO_goal) > MOST_TURN:
            return False
        surroundings = around(placement.stage, JOINT_LIMITS, self._cad)
        plan = plan_grasp(self._table, placement.X_WO, placement.q, surroundings, self.settings.pick.errand)
        q, X_OG = plan.carry.end, plan.grasp.X_OG
        X_CO = se3.inverse(config.X_WC) @ puma_with_hand().tool_pose(q) @ se3.inverse(X_OG)
        if not in_view(self._cad.corners @ X_CO[:3, :3].T + X_CO[:3, 3], config.lens):
            return False
        try:
            return bool(np.abs(joints_for(X_WO_goal @ X_OG, q) - q).max() < FARTHEST_TURN)
        except InputError:
            return False

    def over(self, robot: Diagram, context: Context) -> bool:
        return robot.GetOutputPort("phase").Eval(context).text.startswith(ENDS)

    def stages(self):
        s = self.settings
        task = partial(
            PickThenPlace,
            place=self.showing.task(),
            law=s.servo,
            motion=s.target,
            workspace=WORKSPACE,
            arrival=s.arrival,
        )
        return {"task": task, "tracker": partial(ModelTracker, views=self.showing.views()), **super().stages()}

    def judge(self, history: History) -> Outcome:
        phases = [(event.time, event.text) for event in history.events if event.source == "phase"]
        return judge_place(
            history.times,
            history.poses("X_WO_true"),
            history.poses("X_WE_true"),
            phases,
            self.showing.X_WO_shown,
            self.limits(),
        )

    def limits(self) -> dict[str, float]:
        s = self.settings
        return {"final_translation_error_mm": s.max_error_mm, "final_rotation_error_deg": s.max_error_deg}


def judge_place(
    times: np.ndarray,
    X_WO: np.ndarray,
    X_WE: np.ndarray,
    phases: list[tuple[float, str]],
    X_WO_shown: np.ndarray,
    limits: dict[str, float],
) -> Outcome:
    """How far the object ends from its place, the worst of the last half second, and how far it slipped in the hand, against truth.

    X_WO, X_WE (n, 4, 4) true poses at ``times`` (n,) [s]; phases: (time, text) of the task's status as it changed.
    """
    said = phases[-1][1] if phases else "nothing was done"
    error = np.array([se3.difference(X, X_WO_shown) for X in X_WO[times > times[-1] - 0.5]])
    placing = [time for time, text in phases if text.startswith("place") and not text.startswith(ENDS)]
    figures = {
        "attempts": sum(text.startswith("reach") for _, text in phases),
        "time_s": phases[-1][0] if phases else np.nan,
        "final_translation_error_mm": 1e3 * float(np.linalg.norm(error[:, 3:], axis=1).max()),
        "final_rotation_error_deg": float(np.rad2deg(np.linalg.norm(error[:, :3], axis=1).max())),
    }
    if placing:
        X_EO = np.linalg.inv(X_WE) @ X_WO
        figures["placing_s"] = float(times[-1] - placing[0])
        figures["slip_mm"] = 1e3 * farthest_in_hand(X_EO[times >= placing[0]])
    over = [
        f"{name} {figures[name]:.2f}, allowed {limit:g}" for name, limit in limits.items() if not figures[name] <= limit
    ]
    if not said.startswith("placed"):
        over.insert(0, said)
    return Outcome(not over, "; ".join(over) or "the object is where it was shown", figures)
