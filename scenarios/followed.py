"""One object that is followed through recorded images: its tracker, and what has been found so far."""

import time
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from vipr.diagrams.stages import Stages
from vipr.scenarios.playback import Playback
from vipr.scenarios.replacements import load_stages
from vipr.systems.camera.lens import Lens
from vipr.systems.signals import CameraFrame
from vipr.systems.tracking.cad_model import CadModel
from vipr.systems.tracking.evaluation import COLUMNS, compare
from vipr.systems.tracking.overlay import draw_overlay
from vipr.systems.tracking.settings import TrackerSettings
from vipr.systems.tracking.tracker import ModelTracker

STATES = ("tracking", "uncertain", "lost")
FIELDS = ("frame", "time_s", *COLUMNS, "state", "nodes", "residual_px", "ms")


@dataclass(frozen=True, eq=False)
class Target:
    """What is to be followed: a CAD model, its pose (4, 4) in the first image, and poses by frame to compare with, if there are any."""

    model: CadModel
    X_CO: np.ndarray
    reference: dict[int, np.ndarray] | None = None


def names_of(targets: list[Target]) -> list[str]:
    """The models' names, told apart by a number where a name comes again."""
    names: list[str] = []
    for target in targets:
        same = sum(other.model.name == target.model.name for other in targets[: len(names)])
        names.append(target.model.name + (f"-{same + 1}" if same else ""))
    return names


class Followed:
    """A target, its tracker (or the one that ``stages`` name in its place), and its poses and states by frame."""

    def __init__(self, target: Target, lens: Lens, settings: TrackerSettings, stages: Mapping[str, str], period: float):
        self.target, self._lens, self._period = target, lens, period
        tracker = Stages({"tracker": ModelTracker}, load_stages(stages)).make(
            "tracker",
            target.model,
            lens,
            X_CO_initial=target.X_CO,
            settings=settings,
            period=period,
            offset=0.5 * period,
        )
        self._eye = Playback(tracker, ("object_pose",), period)
        self.poses: dict[int, np.ndarray] = {}
        self.states: dict[int, str] = {}
        self._spent: list[float] = []  # ms

    def see(self, frame: CameraFrame) -> str:
        """Track it in one more frame; its row of the table, in the order of FIELDS."""
        begin = time.perf_counter()
        belief = self._eye.show(frame)["object_pose"]
        ms = 1e3 * (time.perf_counter() - begin)
        self.poses[frame.number], self.states[frame.number] = belief.X_CO, belief.state
        self._spent.append(ms)
        numbers = ",".join(f"{v:.9g}" for v in belief.X_CO.ravel())
        seen = f"{belief.state},{belief.nodes},{belief.residual_px:.4f},{ms:.3f}"
        return f"{frame.number},{frame.time:.6f},{numbers},{seen}\n"

    def draw(self, image: np.ndarray, text: str, line: int = 0) -> np.ndarray:
        """The image with the model where it was last seen, and the text and its state in a line of the corner."""
        frame = next(reversed(self.states))
        return draw_overlay(
            image, self.target.model, self._lens, self.poses[frame], self.states[frame], text, line=line
        )

    def summary(self) -> dict:
        """Plain values for JSON."""
        spent, states = self._spent, self.states
        result = {
            "model": self.target.model.name,
            "frames": len(states),
            **{state: sum(s == state for s in states.values()) for state in STATES},
            "first_lost": next((f for f, s in states.items() if s == "lost"), None),
            "median_ms": round(float(np.median(spent)), 3) if spent else None,
            "p90_ms": round(float(np.percentile(spent, 90)), 3) if spent else None,
        }
        if self.target.reference is not None and self.poses:
            compared = compare(self.target.model, self._lens, self.poses, self.target.reference, states)
            result["agreement"] = compared.as_dict()
        return result
