"""The three parts that are followed, and the track of one of them. Positions are pixels of the region labels."""

import math
from dataclasses import dataclass

import numpy as np

from vipr.systems.hands import kalman
from vipr.systems.hands.arms import FOREARM, SHOULDER, Body
from vipr.systems.hands.candidates import Candidate
from vipr.systems.hands.kalman import Kalman

PARTS = ("face", "left", "right")
# Lengths in px at a working size of 160 x 120 (they grow with the size), times in s.
SIGMA_N = 0.8  # noise of a region's centre
SIGMA_W = {"face": 500.0, "left": 2600.0, "right": 2600.0}  # acceleration noise, px/s^2
SIGMA_V = {"face": 20.0, "left": 60.0, "right": 60.0}  # velocity of a new track, px/s
LOST_AFTER = 0.7  # s unseen, after which a part may come back anywhere
SMALLEST_HEAD = 2.2  # px at 160 x 120, the radius of the core of the smallest region that may become the face
BEYOND = 0.4  # heights of the head, from where an arm goes before the face to the middle of its hand
BARE = 0.4  # share of the frames in which an arm was seen, from which sleeves are short
USUAL_HEAD = 8.0  # px, half the width of a head at 160 x 120, for which the noises of the parts are set
HEAD = 0.48  # headlike from which a region can become the face


@dataclass(frozen=True)
class Track:
    """One part."""

    filter: Kalman
    area: float  # px^2, smoothed
    unseen: float = 0.0  # s since it was seen
    hits: int = 1
    headlike: float = 0.0  # smoothed
    life: float = 0.0  # 0 to 1: how much it moved in the last seconds
    shared: bool = False
    met: bool = False  # has it shared a region with the other hand
    elbow: float | None = None  # px, x of the other end of a bare arm
    bare: float = 0.0  # 0 to 1, how often its arm has been seen bare of late
    crowded: float = 0.0  # s in a region shared that is too small for all, or is a face's in which nothing moves

    @property
    def position(self) -> np.ndarray:
        """(2,) px."""
        return np.array([self.filter.x, self.filter.y])

    @property
    def head_radius(self) -> float:
        """Half the width [px] of a head of this area; heads are 1.3 times as high as wide."""
        return math.sqrt(self.area / math.pi / 1.3)

    @property
    def head_height(self) -> float:
        """Height [px] of a head of this area."""
        return 2.6 * self.head_radius


def anew(name: str, centre, u: float) -> Kalman:
    """A filter that starts at a place, with no velocity; ``u`` is the size of a pixel of 160 x 120."""
    return kalman.start(*(float(c) for c in centre), SIGMA_N * u, SIGMA_V[name] * u)


def born(name: str, centre, area: float, r: Candidate, u: float) -> Track:
    """The track of a part that was found in a region."""
    return Track(anew(name, centre, u), max(area, 1.0), headlike=r.headlike, life=r.moving)


def hand_before_face(r: Candidate, head: float) -> np.ndarray | None:
    """(2,) where a hand is, of whose bare arm a region is what is seen beside the head; None where it is no such arm.

    It lies beyond the end of the arm, among the pixels of the face, no farther from the elbow than hands are; ``head`` is its height, px.
    """
    if r.arm is None:
        return None
    tip, elbow = r.arm
    length = max(float(np.hypot(*(tip - elbow))), 1.0)
    return elbow + min(length + BEYOND * head, FOREARM * head) * (tip - elbow) / length


def in_neck(r: Candidate, face: Track, still: float) -> bool:
    """Whether a region is where the neck and collar of the face are, and less than ``still`` of it moves."""
    dx, dy = (r.centre - face.position) / face.head_radius
    return bool(abs(dx) < 1.0 and 0.0 < dy < 3.6 and r.moving < still)


def smallest_hand(face: Track, share: float, u: float) -> float:
    """The area [px^2] from which a region can be a hand: a share of the face, but little beside a face that fills the picture."""
    return min(share * face.area, 600.0 * share * u * u)


def closeness(face: Track | None, u: float) -> float:
    """How many times nearer a person is than one whose hands move as the constants say: near the camera all moves by more pixels."""
    return 1.0 if face is None else min(max(face.head_radius / (USUAL_HEAD * u), 1.0), 2.5)


def body_of(tracks: dict, name: str) -> Body | None:
    """What the face says of the arm of a hand; None without a face."""
    face = tracks.get("face")
    if face is None or face.unseen > LOST_AFTER:
        return None
    head = face.head_height
    across = (SHOULDER[0] if name == "left" else -SHOULDER[0]) * head
    x, y = face.filter.x, face.filter.y + SHOULDER[1] * head
    return Body(np.array([x + across, y]), np.array([x - across, y]), head, face.area)
