"""``instruct``: a person gestures in the living room, and the robot names the gestures (paper II-A)."""

from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from pydrake.systems.framework import Diagram
from pydrake.systems.primitives import ConstantVectorSource, TrajectorySource

from vipr.diagrams.gesture_robot import GestureRobot
from vipr.diagrams.living_room import CameraPlace, LivingRoom, random_look
from vipr.models import model_path
from vipr.models.person.generate import BODIES
from vipr.scenarios.experiments.instructions import GARBAGE, LANGUAGE, Person
from vipr.scenarios.people.performance import drawn_names, performance
from vipr.scenarios.replacements import load_stages
from vipr.scenarios.scenario import Outcome, Scenario
from vipr.scenarios.settings import require_one_of, require_within
from vipr.systems.camera.illumination import WHITE_KELVIN
from vipr.systems.camera.imperfections import ImperfectCamera, Imperfection
from vipr.systems.gestures.announcer import ANSWER, ANSWER_UNITS
from vipr.systems.gestures.model_file import load_model
from vipr.systems.hands.parts import PARTS
from vipr.systems.hands.track_points import POINTS
from vipr.systems.recording.channels import ImageChannel, StatusChannel, VectorChannel
from vipr.systems.recording.history import History
from vipr.systems.recording.plots import Line, Plot

NAMES = (*LANGUAGE, GARBAGE)
AFTER = 0.8  # s of rest at the end
FAR = 10.0  # px: farther off is lost, not inaccurate
STRANGER = 500_000  # people drawn from here on are in no training
BOOTSTRAP = 1.0  # s in which the robot finds its person


@dataclass(frozen=True, kw_only=True)
class InstructSettings:
    """What can be set with ``--set`` or in ``instruct.yaml``."""

    gestures: int = 6
    idle: int = 2  # movements among them that mean nothing
    body: str = "any"  # small, medium, large, any: the seed chooses
    intensity: float = 1.0  # of the light
    kelvin: float = WHITE_KELVIN  # its colour temperature
    camera: Imperfection = Imperfection(noise=1.5)
    model: str = ""  # a file of `vipr experiment instructions --model`; empty: the one that is shipped
    stages: dict[str, str] = field(
        default_factory=dict
    )  # others in the place of skin, hands or gestures: FILE.py:CLASS
    min_recognised_percent: float = 75.0
    max_false_instructions: int = 0  # movements that are taken for a gesture and are none

    def __post_init__(self):
        require_one_of("body", self.body, ("any", *BODIES))
        require_within(self, gestures=(1, 100), idle=(0, 100), intensity=(0.1, 4.0), kelvin=(2000, 12000))
        require_within(self, min_recognised_percent=(0, 100), max_false_instructions=(0, 1000))


class Instruct(Scenario):
    """The seed chooses the person, whom no model was trained on, clothes, room, the gestures and their order."""

    name = "instruct"
    summary = "a person gestures in the living room and the robot names the gestures (paper II-A)"
    settings_type = InstructSettings

    def __init__(self, settings: InstructSettings, seed: int):
        super().__init__(settings, seed)
        rng = np.random.default_rng([seed, 21])
        body = str(rng.choice(list(BODIES)))
        self._body = body if settings.body == "any" else settings.body
        self._look = random_look(rng)
        names = drawn_names(list(LANGUAGE), settings.gestures, settings.idle, rng)
        self.performance = performance(Person.drawn(STRANGER + seed), BODIES[self._body], names, rng)
        path = Path(settings.model) if settings.model else model_path("gestures/instructions.npz")
        self._classifier = load_model(path)

    @property
    def duration(self) -> float:
        return float(self.performance.q.end_time()) + AFTER

    def build(self) -> Diagram:
        s, place = self.settings, CameraPlace()
        electronics = ImperfectCamera(s.camera, place.width, place.height, self.seed)
        room = LivingRoom(self._body, self._look, place, electronics=electronics)
        robot = GestureRobot(room, self._classifier, NAMES, stages=load_stages(s.stages))
        sources = {
            "person_positions": TrajectorySource(self.performance.q),
            "light": ConstantVectorSource([s.intensity, s.kelvin]),
        }
        return self.fed(robot, sources)

    def channels(self):
        px = ("px",) * len(POINTS)
        return [
            ImageChannel("picture", video=True),
            StatusChannel("understood"),
            VectorChannel("answer", names=ANSWER, units=ANSWER_UNITS),
            VectorChannel("hand_points", names=POINTS, units=px),
            VectorChannel("hand_points_true", names=POINTS, units=px),
        ]

    def plots(self):
        return [
            Plot(
                f"{what} in the image", "position", "px",
                tuple(Line(f"hand_points.{part}_{axis}", axis) for axis in "xy")
                + tuple(Line(f"hand_points_true.{part}_{axis}", f"{axis}, truth", truth=True) for axis in "xy"),
            )
            for part, what in (("face", "Face"), ("left", "Left hand"), ("right", "Right hand"))
        ]  # fmt: skip

    def limits(self):
        return {"false_instructions_count": float(self.settings.max_false_instructions)}

    def judge(self, history: History) -> Outcome:
        figures = judge_names(self.performance, answers(history)) | judge_tracks(history)
        right, false = figures["recognised_percent"], figures["false_instructions_count"]
        s = self.settings
        failed = []
        if right < s.min_recognised_percent:
            failed.append(f"{right:.0f} % of the gestures recognised, {s.min_recognised_percent:g} % wanted")
        if false > s.max_false_instructions:
            failed.append(f"{false} movements taken for a gesture that were none, allowed {s.max_false_instructions}")
        return Outcome(not failed, "; ".join(failed) or f"{right:.0f} % of the gestures recognised", figures)


def answers(history: History) -> list[dict]:
    """The movements that the robot told of, one dictionary of ``ANSWER`` each."""
    table = {name: history.numbers(f"answer.{name}") for name in ANSWER}
    first = np.flatnonzero((np.diff(table["number"], prepend=-1) != 0) & (table["number"] >= 0))
    return [{name: float(column[k]) for name, column in table.items()} for k in first]


def judge_names(performance, told: list[dict]) -> dict[str, float]:
    """Figures of the names: each gesture is answered by the movement told of that overlaps it most.

    A gesture is recognised if that movement was accepted and has its name; an accepted movement that answers no gesture is a false
    instruction.
    """
    main, recognised, delays, angles, shown = set(), 0, [], [], 0
    for name, (start, end), target in zip(performance.names, performance.spans, performance.targets, strict=True):
        if name == GARBAGE:
            continue
        shown += 1
        overlap = [min(end, m["end"]) - max(start, m["start"]) for m in told]
        if not told or max(overlap) <= 0:
            continue
        k = int(np.argmax(overlap))
        main.add(k)
        if told[k]["accepted"] and NAMES[int(told[k]["name"])] == name:
            recognised += 1
            delays.append(told[k]["named"] - end)
            direction = np.array([told[k]["direction_x"], told[k]["direction_y"]])
            if np.isfinite(target).all() and np.isfinite(direction).all():
                angles.append(np.rad2deg(np.arccos(np.clip(direction @ target, -1.0, 1.0))))
    figures = {
        "recognised_percent": 100.0 * recognised / shown,
        "false_instructions_count": sum(bool(m["accepted"]) for k, m in enumerate(told) if k not in main),
    }
    if delays:
        figures["named_after_end_ms"] = 1e3 * float(np.median(delays))
    if angles:
        figures["pointing_error_deg"] = float(np.median(angles))
    return figures


def judge_tracks(history: History) -> dict[str, float]:
    """Figures of the tracks against the truth, after the first second: how much of what could be seen was found, and how well."""
    late = history.times > BOOTSTRAP
    figures = {}
    for part in PARTS:
        seen, true = (
            np.stack([history.numbers(f"{channel}.{part}_{axis}")[late] for axis in "xy"], axis=1)
            for channel in ("hand_points", "hand_points_true")
        )
        there = np.isfinite(true).all(axis=1)
        error = np.linalg.norm(seen - true, axis=1)[there]
        found = error < FAR
        if there.any():
            figures[f"{part}_tracked_percent"] = 100.0 * float(found.mean())
        if found.any():
            figures[f"{part}_rms_px"] = float(np.sqrt(np.mean(error[found] ** 2)))
    return figures
