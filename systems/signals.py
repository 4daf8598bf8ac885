"""Every value that crosses an abstract port: immutable, defaulted, empty when nothing is seen.

A signal is a frozen dataclass. Its arrays are made read-only when it is built and ``__deepcopy__`` returns the signal itself, so that
a reader cannot corrupt a cached output and a context clone copies no images. ``Value(Signal())`` is a port's model value.
"""

from dataclasses import dataclass, field, fields

import numpy as np


class Signal:
    """Base of all signals: read-only arrays, no copies."""

    def __post_init__(self):
        for f in fields(self):
            value = getattr(self, f.name)
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
