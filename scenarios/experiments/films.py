"""Drawings and gestures through the camera: rendered person, imperfect image, tracker of face and hands; kept on disk once made.

A film is what the tracker reported, frame by frame. A reel is the films of one person in one sitting, filmed together and cached as
one file, which belongs to the code and the models that made it: after a change in them everything is filmed anew.
"""

import hashlib
import os
import zipfile
from dataclasses import dataclass
from itertools import chain
from pathlib import Path

import numpy as np

from vipr.scenarios.workers import in_processes
from vipr.systems.errors import InputError
from vipr.systems.signals import HandTracks
from vipr.systems.sources import digest_of_modules

RATE = 25.0  # Hz
HOLD = 6  # frames that the hands stay where a gesture ended
MADE_BY = {  # camera: modules and packages that say what a film of it holds
    "stand-in": (__name__, "vipr.scenarios.people.motion", "vipr.models.person"),
    "rendered": (
        __name__, "vipr.scenarios.people.motion", "vipr.scenarios.people.film", "vipr.diagrams.living_room",
        "vipr.models.person", "vipr.models.living_room", "vipr.systems.camera", "vipr.systems.skin", "vipr.systems.hands",
    ),
}  # fmt: skip
COLUMNS = ("positions", "seen", "merged", "areas", "lengths")


@dataclass(frozen=True, eq=False)
class Reel:
    """N films of one person; tables of parts are in the order face, left hand, right hand."""

    labels: np.ndarray  # (N,) str
    positions: list[np.ndarray]  # of (n, 3, 2) px, NaN where a part has not been seen yet
    seen: list[np.ndarray]  # of (n, 3) bool
    merged: list[np.ndarray]  # of (n, 3) bool
    areas: list[np.ndarray]  # of (n, 3) px^2
    bounds: np.ndarray  # (N, 2) first and last frame of the gesture proper
    person: str
    targets: np.ndarray  # (N, 2) direction pointed to, unit vector in the image (x right, y up); NaN where none

    def tracks(self, film: int) -> list[HandTracks]:
        """The film as the tracker's signals, starting at time 0."""
        parts = ("face", "left", "right")
        return [
            HandTracks(
                **dict(zip(parts, positions, strict=True)),
                **{f"{p}_seen": bool(s) for p, s in zip(parts, seen, strict=True)},
                merged=tuple(p for p, m in zip(parts, merged, strict=True) if m),
                areas=areas,
                size=(160, 120),
                time=n / RATE,
                number=n,
            )
            for n, (positions, seen, merged, areas) in enumerate(
                zip(
                    self.positions[film].copy(),
                    self.seen[film],
                    self.merged[film],
                    self.areas[film].copy(),
                    strict=True,
                )
            )
        ]


def cache_folder(folder: Path | None = None) -> Path:
    """Where reels are kept: the folder given, ``VIPR_CACHE`` or ``~/.cache/vipr``."""
    base = folder or Path(os.environ.get("VIPR_CACHE") or Path.home() / ".cache" / "vipr")
    try:
        base.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InputError(f"cache {base}: cannot be made ({error.strerror})") from None
    return base


@dataclass(frozen=True, eq=False)
class Sitting:
    """What one person is to do before the camera, film by film."""

    name: str  # of its file in the cache
    person: str
    paths: list  # of HandPaths
    labels: list[str]
    bounds: list[tuple[int, int]]  # first and last frame of the gesture proper
    camera: str  # rendered (living room and tracker) | stand-in (projection with 1 px of noise)
    seed: int  # draws body, look, idle motion, noise
    targets: np.ndarray | None = None  # (N, 2) directions pointed to
    lead: int = 0  # frames of the rest before a path that its film begins with; ``bounds`` count them
    greets: bool = True  # before the paths, in a film that is not kept; False: the paths begin with a greeting

    @property
    def file(self) -> str:
        """Name of the file, with a hash of the paths, the person, the seed, and the camera with all that it is made of."""
        made_by = digest_of_modules(*MADE_BY[self.camera])
        digest = hashlib.sha256(f"{made_by} {self.camera} {self.person} {self.seed} {self.lead} {self.greets}".encode())
        for path in self.paths:
            for hand in (path.right, path.left):
                digest.update(b"-" if hand is None else np.round(hand, 6).tobytes())
        return f"{self.name}-{digest.hexdigest()[:16]}.npz"


def film(sittings: list[Sitting], folder: Path, jobs: int = 1, tick=lambda n: None) -> list[Reel]:
    """The reels of all sittings, filmed or read from the cache, ``jobs`` at a time; ``tick(films)`` is told how many more are there.

    A sitting that is filmed is kept at once: what was interrupted goes on from there.
    """
    there = [_read(folder / s.file) for s in sittings]
    tick(sum(len(s.labels) for s, table in zip(sittings, there, strict=True) if table is not None))
    missing = [k for k, table in enumerate(there) if table is None]
    here = [k for k in missing if sittings[k].camera == "stand-in"]  # a moment's work
    apart = [k for k in missing if sittings[k].camera == "rendered"]
    made = in_processes(_make, [(sittings[k], folder) for k in apart], jobs)
    for k, table in chain(((k, _make(sittings[k], folder)) for k in here), zip(apart, made, strict=True)):
        there[k] = table
        tick(len(sittings[k].labels))
    return [_reel(s, table) for s, table in zip(sittings, there, strict=True)]


def _make(sitting, folder):
    films = (_rendered if sitting.camera == "rendered" else _stand_in)(sitting)
    table = {name: np.concatenate([f[k] for f in films]) for k, name in enumerate(COLUMNS[:-1])}
    table["lengths"] = np.array([len(f[0]) for f in films])
    file = folder / sitting.file
    part = file.with_suffix(f".{os.getpid()}.part")
    with part.open("wb") as out:
        np.savez_compressed(out, **table)
    part.replace(file)
    return table


def _reel(sitting, table):
    cuts = np.cumsum(table["lengths"])[:-1]
    columns = [np.split(table[name], cuts) for name in COLUMNS[:-1]]
    targets = np.full((len(sitting.labels), 2), np.nan) if sitting.targets is None else sitting.targets
    return Reel(
        np.asarray(sitting.labels), *columns, np.asarray(sitting.bounds), sitting.person, np.asarray(targets, float)
    )


def _read(file):
    try:
        with np.load(file, allow_pickle=False) as table:
            return {name: table[name] for name in COLUMNS}
    except (OSError, KeyError, ValueError, EOFError, zipfile.BadZipFile):
        return None


def _rendered(sitting):
    os.environ.setdefault("LP_NUM_THREADS", "1")  # of the software renderer: pictures are small, films run side by side
    from vipr.scenarios.people.film import film_gestures
    from vipr.scenarios.people.motion import greeting

    films, before = [], [greeting()] if sitting.greets else []
    for film in film_gestures([*before, *sitting.paths], seed=sitting.seed, truth=False, lead=sitting.lead):
        t = film.tracks
        films.append((t.positions, t.seen, t.merged, t.areas))
    return films[len(before) :]


def _stand_in(sitting):
    """A camera in name only: hands projected from 2.1 m, each seen with 1 px of noise, nothing hidden."""
    from vipr.models.person.generate import BODIES
    from vipr.scenarios.people.motion import rest

    rng, lead = np.random.default_rng(sitting.seed), sitting.lead
    body = BODIES[str(rng.choice(list(BODIES)))]
    films = []
    for path in sitting.paths:
        n = lead + len(path)
        hands = [
            np.repeat(rest(body, side)[None], n, 0) if p is None else np.concatenate([np.repeat(p[:1], lead, 0), p])
            for side, p in (("left", path.left), ("right", path.right))
        ]
        parts = [np.tile([0.1, 0.0, 0.25], (n, 1)), *hands]
        pixels = [
            np.column_stack([79.5 + 184.0 * p[:, 1] / (2.1 - p[:, 0]), 60.0 - 184.0 * p[:, 2] / (2.1 - p[:, 0])])
            for p in parts
        ]
        seen = np.ones((n, 3), bool)
        noise = rng.normal(0.0, 1.0, (n, 3, 2))
        films.append((np.stack(pixels, axis=1) + noise, seen, ~seen, np.tile([170.0, 80.0, 80.0], (n, 1))))
    return films
