"""What all parts of the tracking benchmark share: the lens, objects, one renderer a background, runs of the tracker, verdicts."""

import tempfile
import time
from collections.abc import Iterable
from dataclasses import dataclass, field
from functools import cache, cached_property
from pathlib import Path

import numpy as np

import vipr.models
from vipr.scenarios.bench.benchmark import Bench
from vipr.scenarios.sequences import trajectories
from vipr.scenarios.sequences.rendered import Conditions, sequence
from vipr.scenarios.sequences.renderer import SequenceRenderer
from vipr.scenarios.sequences.scenery import Mesh
from vipr.systems import se3
from vipr.systems.camera.lens import Lens
from vipr.systems.signals import CameraFrame
from vipr.systems.tracking.belief import Belief, start
from vipr.systems.tracking.cad_model import CadModel, load_model
from vipr.systems.tracking.evaluation import FOLLOWED_DEG, FOLLOWED_PX, corner_distances
from vipr.systems.tracking.model_tracking import step
from vipr.systems.tracking.settings import TrackerSettings
from vipr.systems.tracking.triangulation import cylinder_triangles

XC77 = Lens(640, 480, 1948.05, 1923.08, 319.5, 239.5)
BOXES = ("rice_box", "milk_carton")
UNPRINTED = " (unprinted)"  # the same object in one colour: no print beside its edges; a can truly round
OBJECTS = (*BOXES, *(name + UNPRINTED for name in (*BOXES, "can")))
ROUNDS = ("can", "mug", "bottle")  # as they are printed
RATE = 25.0  # images/s
WRONG_MM, WRONG_DEG = 20.0, 5.0  # of a start that is not right
OFF = 5.0  # px RMS of the corners: a pose that is wrong, if not lost
UPRIGHT = (
    se3.exp_so3(np.array([0.3, 0, 0])) @ se3.exp_so3(np.array([0, 0.6, 0])) @ se3.exp_so3(np.array([np.pi / 2, 0, 0]))
)
Frames = list[tuple[CameraFrame, np.ndarray]]


def wrong(X_CO: np.ndarray, centre_O: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    """The pose moved by WRONG_MM and turned by WRONG_DEG about its centre, each in a direction drawn at random."""
    shift, axis = (v / np.linalg.norm(v) for v in rng.normal(size=(2, 3)))
    return trajectories.displaced(X_CO, np.radians(WRONG_DEG) * axis, 1e-3 * WRONG_MM * shift, centre_O)


@dataclass
class Run:
    """What the tracker said of each frame, against the truth."""

    model: CadModel
    lens: Lens
    truth: list[np.ndarray] = field(default_factory=list)
    beliefs: list[Belief] = field(default_factory=list)
    arrived: list[bool] = field(default_factory=list)
    ms: list[float] = field(default_factory=list)  # of processor time: others on the machine do not count

    @cached_property
    def corner_px(self) -> np.ndarray:
        """(F,) RMS distance of the projected corners from where they truly are."""
        found = [
            corner_distances(self.model, self.lens, without_spin(self.model, b.X_CO, X), X)
            for b, X in zip(self.beliefs, self.truth, strict=True)
        ]
        return np.array([np.sqrt(np.mean(d**2)) for d in found])

    @cached_property
    def degrees(self) -> np.ndarray:
        """(F,) rotation errors."""
        pairs = zip(self.beliefs, self.truth, strict=True)
        return np.array([np.degrees(se3.angle_between(without_spin(self.model, b.X_CO, X), X)) for b, X in pairs])

    @cached_property
    def millimetres(self) -> np.ndarray:
        """(F, 3) errors of the object's centre in C."""
        c = self.model.centre
        pairs = zip(self.beliefs, self.truth, strict=True)
        return 1e3 * np.array([(b.X_CO - X)[:3, :3] @ c + (b.X_CO - X)[:3, 3] for b, X in pairs])

    @property
    def followed(self) -> np.ndarray:
        """(F,) whether the pose is right, as in `evaluation`."""
        return (self.corner_px <= FOLLOWED_PX) & (self.degrees <= FOLLOWED_DEG)

    @property
    def lost_at(self) -> int | None:
        """First frame that was not followed."""
        bad = np.flatnonzero(~self.followed)
        return int(bad[0]) if len(bad) else None

    @property
    def survived(self) -> bool:
        return self.lost_at is None

    @property
    def depth_told(self) -> np.ndarray:
        """(F,) mm, standard deviation of the depth of the object's centre as the tracker told it."""
        rows = []
        for b in self.beliefs:
            x, y, _ = b.X_CO[:3, :3] @ self.model.centre
            row = np.array([y, -x, 0.0, 0.0, 0.0, 1.0])  # depth of the centre by (w, v)
            rows.append(1e3 * np.sqrt(row @ b.covariance @ row))
        return np.array(rows)

    @property
    def off(self) -> np.ndarray:
        """(F,) whether the pose was said to be tracked while its corners were off by more than OFF px RMS."""
        return self.states("tracking") & ~(self.corner_px <= OFF)

    def states(self, state: str) -> np.ndarray:
        """(F,) whether that state was reported."""
        return np.array([b.state == state for b in self.beliefs])


def spin_axis(model: CadModel) -> np.ndarray | None:
    """(3,) unit axis in O of a solid of revolution, about which its pose cannot be seen; None for other objects."""
    if len(model.vertices) or not len(model.cylinders):
        return None
    along = model.cylinders[0][3:6] - model.cylinders[0][:3]
    return along / np.linalg.norm(along)


def without_spin(model: CadModel, X_CO: np.ndarray, X_true: np.ndarray) -> np.ndarray:
    """The pose turned about the axis of a solid of revolution so that it is nearest to the truth; other objects: the pose."""
    axis = spin_axis(model)
    if axis is None:
        return X_CO
    M = X_CO[:3, :3].T @ X_true[:3, :3]
    sin, cos = axis @ [M[2, 1] - M[1, 2], M[0, 2] - M[2, 0], M[1, 0] - M[0, 1]], np.trace(M) - axis @ M @ axis
    turn = se3.pose(se3.exp_so3(np.arctan2(sin, cos) * axis), np.zeros(3))
    shift = se3.pose(np.eye(3), model.cylinders[0][:3])
    return X_CO @ shift @ turn @ se3.inverse(shift)


class Workbench:
    """The benchmark's options, and what is costly to make, kept."""

    def __init__(self, bench: Bench):
        self.quick, self.data, self.seed, self.progress = bench.quick, bench.data, bench.seed, bench.progress
        self.lens = XC77
        self.renderer = cache(self._renderer)
        self.model = cache(lambda name: load_model(_folder() / name.removesuffix(UNPRINTED) / "model.yaml"))
        self.good_frames = [0, 0, 0]  # rightly followed frames of all runs; of those said to be uncertain; to be lost

    def _renderer(self, background: str, lens: Lens) -> SequenceRenderer:
        with tempfile.TemporaryDirectory() as folder:
            objects = {}
            for name in (*OBJECTS, *ROUNDS):
                objects[name] = _folder() / name / "visual.obj"
                if name.endswith(UNPRINTED):
                    model = self.model(name)
                    round_parts = [cylinder_triangles(c[:3], c[3:6], c[6], sides=256) for c in model.cylinders]
                    mesh = Mesh(
                        [*(model.vertices[t] for t in model.triangles), *(t for part in round_parts for t in part)]
                    )
                    objects[name] = mesh.write(Path(folder) / f"{model.name}.obj", colour=(0.9, 0.9, 0.9))
            return SequenceRenderer(objects, lens, background=background, seed=self.seed + 11)

    def render(self, name, trajectory, frames, conditions=None, *, background="clutter", seed=0, lens=None) -> Frames:
        """Frames of an object with their truth."""
        renderer = self.renderer(background, lens or self.lens)
        return list(
            sequence(renderer, name, trajectory, frames, conditions or Conditions(), seed=self.seed + seed, rate=RATE)
        )

    def at(self, name: str, *, turn=UPRIGHT, place=(0.0, 0.0, 2.0)) -> np.ndarray:
        """X_CO of an object with its centre at a place in C [m]."""
        return se3.pose(turn, np.asarray(place) - turn @ self.model(name).centre)

    def track(
        self,
        name: str,
        frames: Iterable,
        settings: TrackerSettings | None = None,
        *,
        lens=None,
        count=True,
        X_CO_start: np.ndarray | None = None,
    ) -> Run:
        """Run the tracker over frames from the true pose of the first, or from the one given."""
        model, lens = self.model(name), lens or self.lens
        settings = settings or TrackerSettings()
        run, belief = Run(model, lens), None
        for frame, X_CO in frames:
            if belief is None:
                belief = start(X_CO if X_CO_start is None else X_CO_start, frame.time)
            begin = time.process_time()
            belief = step(belief, frame.image, frame.time, model, lens, settings, number=frame.number)
            run.ms.append(1e3 * (time.process_time() - begin))
            run.truth.append(X_CO)
            run.beliefs.append(belief)
            run.arrived.append(frame.arrived)
        if count and settings == TrackerSettings():
            good = run.followed & (run.corner_px < OFF) & np.array(run.arrived) & (np.arange(len(run.truth)) > 1)
            self.good_frames[0] += int(good.sum())
            self.good_frames[1] += int((good & run.states("uncertain")).sum())
            self.good_frames[2] += int((good & run.states("lost")).sum())
        return run


def _folder() -> Path:
    return Path(vipr.models.__file__).parent
