"""Films hand paths in the living room and tracks them, fast and without building a diagram a film."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from vipr.diagrams.living_room import CameraPlace, LivingRoom, Look, random_look
from vipr.models.person.generate import BODIES
from vipr.scenarios.people.motion import SIDES, HandPaths, joint_positions, led_in, rest
from vipr.systems.camera.illumination import WHITE_KELVIN, illuminate
from vipr.systems.camera.imperfections import ImperfectCamera, Imperfection
from vipr.systems.hands.label_truth import tracks_from_labels
from vipr.systems.hands.pipeline import PeopleBelief, see_people
from vipr.systems.signals import HandTracks

PARTS = ("face", "left", "right")


@dataclass(frozen=True, eq=False)
class TrackTable:
    """Tracks as arrays over frames, parts in the order face, left hand, right hand."""

    time: np.ndarray  # (n,) s
    positions: np.ndarray  # (n, 3, 2) px
    velocities: np.ndarray  # (n, 3, 2) px/s
    seen: np.ndarray  # (n, 3) bool
    merged: np.ndarray  # (n, 3) bool
    areas: np.ndarray  # (n, 3) px^2, 0 where unseen

    @staticmethod
    def of(tracks: Sequence[HandTracks]) -> "TrackTable":
        """The table of a sequence of tracks."""
        return TrackTable(
            np.array([t.time for t in tracks]),
            np.array([[getattr(t, p) for p in PARTS] for t in tracks]),
            np.array([[getattr(t, f"{p}_velocity") for p in PARTS] for t in tracks]),
            np.array([[getattr(t, f"{p}_seen") for p in PARTS] for t in tracks], bool),
            np.array([[p in t.merged for p in PARTS] for t in tracks], bool),
            np.array([t.areas for t in tracks], float),
        )


@dataclass(frozen=True, eq=False)
class Film:
    """One filmed pair of hand paths: what was tracked beside what was there, frame by frame of the paths given."""

    tracks: TrackTable
    truth: TrackTable
    shoulder_px: float  # width of the shoulders in the image, px
    images: np.ndarray | None = None  # (n, h, w, 3) BGR where asked for


class Studio:
    """A living room that is built once for a body and a camera place, and films any number of paths.

    It holds one context; every film is a function of its arguments alone.
    """

    def __init__(self, body: str = "medium", place: CameraPlace | None = None):
        self.body, self.place = BODIES[body], place or CameraPlace()
        self._room = LivingRoom(body, place=self.place)
        self._context = self._room.CreateDefaultContext()
        self._look: Look | None = Look()
        self._positions = self._room.GetInputPort("person_positions")
        self._color = self._room.GetOutputPort("color_image")
        self._label = self._room.GetOutputPort("label_image")

    @property
    def shoulder_px(self) -> float:
        """Width of the person's shoulders in the image [px]."""
        focal = 0.5 * self.place.width / np.tan(0.5 * self.place.field_of_view)
        return 2 * self.body.shoulder_half_width * focal / self.place.distance

    def dress(self, look: Look) -> None:
        """Change clothes, skin and decor."""
        if look != self._look:
            self._room.dress(self._context, look)
            self._look = look

    def shoot(self, q: np.ndarray, truth: bool = True):
        """(image (h, w, 3) BGR, labels (h, w) or None) of the person at joint positions q (15,), at the camera's white light."""
        self._positions.FixValue(self._context, q)
        image = self._color.Eval(self._context).data[:, :, 2::-1].copy()
        return image, self._label.Eval(self._context).data[:, :, 0].copy() if truth else None


@lru_cache(maxsize=8)
def studio(body: str = "medium", place: CameraPlace | None = None) -> Studio:
    """The studio of this body and camera place, built at the first call."""
    return Studio(body, place)


def film_gestures(
    paths: Iterable[HandPaths],
    *,
    seed: int = 0,
    look: Look | None = None,
    body: str | None = None,
    place: CameraPlace | None = None,
    light: tuple[float, float] = (1.0, WHITE_KELVIN),
    imperfection: Imperfection | None = None,
    pause: int = 6,
    lead: int = 0,
    rate: float = 25.0,
    truth: bool = True,
    images: bool = False,
) -> Iterable[Film]:
    """Film each of the paths with one person in one room, track face and hands, and yield a :class:`Film` each.

    ``seed`` draws body, look, idle motion and noise (where not given). Between two paths the hands go from the end of the one to the
    beginning of the next and rest there for ``pause`` frames; that is filmed and tracked, but of it only the last ``lead`` frames are
    returned, before the path's. The tracker is told nothing of where a path begins. ``light`` is (intensity, colour temperature [K]).
    The same arguments give the same films.
    """
    rng = np.random.default_rng(seed)
    body_name, drawn = str(rng.choice(list(BODIES))), random_look(rng)
    stage = studio(body or body_name, place)
    camera = ImperfectCamera(imperfection or Imperfection(noise=1.5), stage.place.width, stage.place.height, seed)
    stage.dress(look or drawn)
    belief, number = PeopleBelief(), 0
    before = {side: rest(stage.body, side) for side in SIDES}
    for path in paths:
        whole = led_in(path, before, stage.body, pause)
        before = {s: rest(stage.body, s) if getattr(path, s) is None else getattr(path, s)[-1] for s in SIDES}
        tracks, truths, pictures = [], [], []
        for k, q in enumerate(joint_positions(whole, stage.body, rng, rate=rate)):
            image, labels = stage.shoot(q, truth)
            image = camera.expose(illuminate(image, *light), number)
            time = number / rate
            belief = see_people(image, time, number, belief)
            number += 1
            if k >= len(whole) - len(path) - lead:
                tracks.append(belief.tracks)
                truths.append(tracks_from_labels(labels, time, number - 1) if truth else HandTracks(time=time))
                if images:
                    pictures.append(image)
        yield Film(
            TrackTable.of(tracks), TrackTable.of(truths), stage.shoulder_px, np.array(pictures) if images else None
        )
