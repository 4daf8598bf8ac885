"""Every value that crosses an abstract port: immutable, defaulted, empty when nothing is seen.

A signal is a frozen dataclass. Its arrays are made read-only when it is built and ``__deepcopy__`` returns the signal itself, so that
a reader cannot corrupt a cached output and a context clone copies no images. ``Value(Signal())`` is a port's model value.
"""

from dataclasses import dataclass, field

import numpy as np


class Signal:
    """Base of all signals: read-only arrays, no copies."""

    def __post_init__(self):
        for value in vars(self).values():
            if isinstance(value, np.ndarray) and value.flags.writeable:
                value.setflags(write=False)

    def __copy__(self):
        return self

    def __deepcopy__(self, memo):
        return self


def empty(*shape: int, dtype=float):
    """Default of an array field: an array of the given shape, usually with a zero in it."""
    return field(default_factory=lambda: np.zeros(shape, dtype))


@dataclass(frozen=True, eq=False)
class CameraFrame(Signal):
    """One exposure. An image with no pixels means that nothing arrived: no exposure yet, or a dropped frame."""

    image: np.ndarray = empty(0, 0, 3, dtype=np.uint8)  # (h, w, 3) BGR or (h, w) grey, uint8
    time: float = 0.0  # s, middle of the exposure
    number: int = -1  # counts camera ticks, dropped ones too; -1 before the first

    @property
    def arrived(self) -> bool:
        return self.image.size > 0


@dataclass(frozen=True, eq=False)
class ObjectPose(Signal):
    """Where a tracker believes an object O to be in the camera frame C (x right, y down, z forward)."""

    X_CO: np.ndarray = field(default_factory=lambda: np.eye(4))  # (4, 4)
    V_CO: np.ndarray = empty(6)  # (w, v) of O in C, at the origin of O, expressed in C, rad/s and m/s
    covariance: np.ndarray = empty(6, 6)  # of (rotation, translation) in C, rad^2, rad m, m^2
    state: str = "lost"  # tracking | uncertain | lost; lost before the first frame, and then X_CO means nothing
    time: float = 0.0  # s, exposure of the frame it was seen in
    number: int = -1  # that frame's number
    nodes: int = 0  # edge nodes used
    residual_px: float = float("nan")  # robust RMS distance of the used nodes from the model's edges
    score: float = 0.0  # 0 to 1, calibrated confidence behind `state`


@dataclass(frozen=True, eq=False)
class Occluders(Signal):
    """Known bodies that may stand between the camera and what is tracked (the hand, other objects)."""

    triangles_C: np.ndarray = empty(0, 3, 3)  # (S, 3, 3) corners of triangles in the camera frame C, m
    time: float = 0.0  # s


@dataclass(frozen=True, eq=False)
class Status(Signal):
    """What a stage says of itself, in a few words; a recorder writes it down when it changes. Empty: nothing to say yet."""

    text: str = ""
    level: str = "info"  # info | warning | error


@dataclass(frozen=True, eq=False)
class SkinRegions(Signal):
    """Connected regions of skin colour in one frame, largest evidence first; no rows when there are none. Pixels of the frame."""

    centres: np.ndarray = empty(0, 2)  # (n, 2) px, centre of gravity
    areas: np.ndarray = empty(0)  # (n,) px^2
    boxes: np.ndarray = empty(0, 4)  # (n, 4) px: x, y, width, height
    person: np.ndarray = empty(0)  # (n,) 0 to 1: moves, differs from what always stood there
    faceness: np.ndarray = empty(0)  # (n,) 0 to 1: the marks of a face on the region's thickest part
    moving: np.ndarray = empty(0)  # (n,) 0 to 1, share of its pixels that move
    cores: np.ndarray = empty(
        0, 3
    )  # (n, 3) px: x, y, radius of the largest disc inside, on the palm or the face rather than the arm
    labels: np.ndarray = empty(
        0, 0, dtype=np.uint8
    )  # (h', w') at working resolution: row + 1 of the region, 0 elsewhere
    motion: np.ndarray = empty(0, 0, dtype=np.uint8)  # (h', w'), 255 where something moves, fading within a second
    scale: float = 1.0  # pixels of the frame in one pixel of ``labels``
    size: tuple[int, int] = (0, 0)  # (width, height) of the frame, px; (0, 0) before the first
    cut: bool = True  # another scene than the frame before, or seen under a light that is believed to be another: nothing goes on
    time: float = 0.0  # s, middle of the exposure
    number: int = -1  # of the camera frame


@dataclass(frozen=True, eq=False)
class HandTracks(Signal):
    """Face and hands of one person in pixels of the frame; ``left`` is the person's left hand (on the image's right, unmirrored).

    Where ``*_seen`` is false the position is a prediction, or NaN if that part was never seen.
    """

    face: np.ndarray = field(default_factory=lambda: np.full(2, np.nan))  # (2,) px
    left: np.ndarray = field(default_factory=lambda: np.full(2, np.nan))  # (2,) px
    right: np.ndarray = field(default_factory=lambda: np.full(2, np.nan))  # (2,) px
    face_velocity: np.ndarray = empty(2)  # px/s
    left_velocity: np.ndarray = empty(2)  # px/s
    right_velocity: np.ndarray = empty(2)  # px/s
    face_seen: bool = False
    left_seen: bool = False
    right_seen: bool = False
    merged: tuple[str, ...] = ()  # the parts that share a region with another part now
    areas: np.ndarray = empty(3)  # (3,) px^2 of skin of face, left, right; 0 where unseen
    size: tuple[int, int] = (0, 0)  # (width, height) of the frame, px
    time: float = 0.0  # s, exposure of the frame
    number: int = -1  # of the camera frame; -1 before the first


@dataclass(frozen=True, eq=False)
class Gesture(Signal):
    """The last movement of the hands that ended, and what it was taken for; nothing yet while number is -1."""

    name: str = ""  # of the most likely gesture, of rejected movements too
    probability: float = 0.0  # of that gesture among those known
    rejected: bool = True  # it is taken for no gesture at all
    start: float = 0.0  # s, when the movement began
    end: float = 0.0  # s, when it ended
    named: float = 0.0  # s, exposure of the frame after which it was named
    direction: np.ndarray = field(
        default_factory=lambda: np.full(2, np.nan)
    )  # (2,) pointed to in the image, x right, y up; NaN where none
    number: int = -1  # counts movements
