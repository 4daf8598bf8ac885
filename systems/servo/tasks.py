"""What the servo is to do: which body is moved, where its goal is, and how its twist becomes the hand's.

Frames: W world, C camera, O object that the tracker sees, E hand, B the body that is moved, G its goal.
"""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from vipr.systems import se3
from vipr.systems.errors import InputError
from vipr.systems.servo.situation import Situation
from vipr.systems.servo.target_filter import TargetBelief, predict_pose


@dataclass(frozen=True, eq=False)
class Hand:
    """The hand by its encoders: pose X_WE (4, 4), twist V_WE_W (6,) and time [s]."""

    X_WE: np.ndarray
    V_WE: np.ndarray
    time: float

    def pose_at(self, time: float) -> np.ndarray:
        """X_WE at a time [s] near the present, by the present twist."""
        dt = time - self.time
        return se3.pose(se3.exp_so3(dt * self.V_WE[:3]) @ self.X_WE[:3, :3], self.X_WE[:3, 3] + dt * self.V_WE[3:])


@dataclass(frozen=True, eq=False)
class Task:
    """Base of the tasks.

    A task says in which frame the seen object is (nearly) still, so that one Kalman filter serves all: the world for an object that stands
    or drives by itself, the hand for one that is held.
    """

    held: ClassVar[bool] = False  # the seen object is in the hand
    # The camera is on the hand: the body that is seen moves by the opposite of the camera's twist.
    moves_camera: ClassVar[bool] = False

    def X_WC_at(self, X_WE: np.ndarray) -> np.ndarray:
        """Where the camera is believed to be (4, 4)."""
        raise NotImplementedError

    @property
    def points_B(self) -> np.ndarray:
        """(n, 3) the features [m], fixed to B."""
        raise NotImplementedError

    def situation(self, target: TargetBelief, seen_hand: TargetBelief, hand: Hand) -> Situation:
        """What the law sees; target is X_WO or X_EO, seen_hand is the hand in E as the encoders have it (known only if it is seen)."""
        raise NotImplementedError

    def camera_in_still_frame(self, hand: Hand, time: float) -> np.ndarray:
        """X_WC or, where the object is held, X_EC (4, 4) when a picture was taken."""
        X_WE = hand.pose_at(time)
        return se3.inverse(X_WE) @ self.X_WC_at(X_WE) if self.held else self.X_WC_at(X_WE)

    def hand_twist(self, V_B: np.ndarray, hand: Hand) -> np.ndarray:
        """V_WE_W of the hand that makes the body move by V_B, given at C's origin in C."""
        X_WC = self.X_WC_at(hand.X_WE)
        V = se3.rotate(X_WC[:3, :3], -V_B if self.moves_camera else V_B)
        return se3.shift(V, hand.X_WE[:3, 3] - X_WC[:3, 3])

    def body_twist(self, hand: Hand) -> np.ndarray:
        """V_B at C's origin in C, of the hand's present motion: the inverse of ``hand_twist``."""
        X_WC = self.X_WC_at(hand.X_WE)
        V = se3.rotate(X_WC[:3, :3].T, se3.shift(hand.V_WE, X_WC[:3, 3] - hand.X_WE[:3, 3]))
        return -V if self.moves_camera else V

    def goal_of_hand(self, situation: Situation, hand: Hand) -> np.ndarray:
        """X_WE (4, 4) that ends the task, by the present belief."""
        X_WC, move = self.X_WC_at(hand.X_WE), situation.X_CG @ se3.inverse(situation.X_CB)
        return X_WC @ (se3.inverse(move) if self.moves_camera else move) @ se3.inverse(X_WC) @ hand.X_WE


@dataclass(frozen=True, eq=False)
class Reach(Task):
    """The hand goes to X_OG relative to an object that stands or moves by itself, before a fixed camera believed at X_WC.

    Endpoint open-loop: the hand's place in the camera comes from its encoders and X_WC. Closed-loop, when the hand is seen too: from what
    the camera sees of it. The features are the object's corners points_O (n, 3) [m], and where the hand would want them.
    """

    X_WC: np.ndarray
    X_OG: np.ndarray
    points_O: np.ndarray

    def __post_init__(self):
        _require_poses(X_WC=self.X_WC, X_OG=self.X_OG)

    def X_WC_at(self, X_WE: np.ndarray) -> np.ndarray:
        return self.X_WC

    @property
    def points_B(self) -> np.ndarray:
        X_GO = se3.inverse(self.X_OG)
        return self.points_O @ X_GO[:3, :3].T + X_GO[:3, 3]

    def situation(self, target: TargetBelief, seen_hand: TargetBelief, hand: Hand) -> Situation:
        X_CW, X_WO = se3.inverse(self.X_WC), predict_pose(target, hand.time)
        X_CE = X_CW @ hand.X_WE
        if seen_hand.known:
            X_CE = X_CE @ predict_pose(seen_hand, hand.time)
        V_G = se3.rotate(X_CW[:3, :3], se3.shift(target.V_WO, self.X_WC[:3, 3] - X_WO[:3, 3]))
        return Situation(X_CE, X_CW @ X_WO @ self.X_OG, self.points_B, self.body_twist(hand), V_G, time=hand.time)


@dataclass(frozen=True, eq=False)
class Place(Task):
    """A held object goes to where it was shown, before a fixed camera believed at X_WC. Endpoint closed-loop: the object is what is seen.

    shown (n, 2): normalised image points of points_O (n, 3) [m] at the shown place; X_CO_shown is the pose that they give.
    """

    held: ClassVar[bool] = True
    X_WC: np.ndarray
    X_CO_shown: np.ndarray
    points_O: np.ndarray
    shown: np.ndarray

    def __post_init__(self):
        _require_poses(X_WC=self.X_WC, X_CO_shown=self.X_CO_shown)

    def X_WC_at(self, X_WE: np.ndarray) -> np.ndarray:
        return self.X_WC

    @property
    def points_B(self) -> np.ndarray:
        return self.points_O

    def situation(self, target: TargetBelief, seen_hand: TargetBelief, hand: Hand) -> Situation:
        X_CO = se3.inverse(self.X_WC) @ hand.X_WE @ predict_pose(target, hand.time)
        V_B = self.body_twist(hand)
        return Situation(X_CO, self.X_CO_shown, self.points_O, V_B, np.zeros(6), self.shown, hand.time)


@dataclass(frozen=True, eq=False)
class Look(Task):
    """A camera in the hand, believed at X_EC, goes to where the object looks as it was shown (eye-in-hand)."""

    moves_camera: ClassVar[bool] = True
    X_EC: np.ndarray
    X_CO_shown: np.ndarray
    points_O: np.ndarray
    shown: np.ndarray | None = None  # (n, 2) normalised image points; None: where X_CO_shown puts them

    def __post_init__(self):
        _require_poses(X_EC=self.X_EC, X_CO_shown=self.X_CO_shown)

    def X_WC_at(self, X_WE: np.ndarray) -> np.ndarray:
        return X_WE @ self.X_EC

    @property
    def points_B(self) -> np.ndarray:
        return self.points_O

    def situation(self, target: TargetBelief, seen_hand: TargetBelief, hand: Hand) -> Situation:
        X_WC, X_WO = self.X_WC_at(hand.X_WE), predict_pose(target, hand.time)
        X_CW = se3.inverse(X_WC)
        V_CO = se3.rotate(X_CW[:3, :3], se3.shift(target.V_WO, X_WC[:3, 3] - X_WO[:3, 3]))
        V_B = self.body_twist(hand)  # V_G is -V_CO: the camera that moves with the object sees it stand still
        return Situation(X_CW @ X_WO, self.X_CO_shown, self.points_O, V_B, -V_CO, self.shown, hand.time)


def _require_poses(**poses: np.ndarray) -> None:
    for name, X in poses.items():
        if not se3.is_pose(X):
            raise InputError(
                f"servo: {name} must be a rigid 4x4 pose, got {np.array2string(np.asarray(X), precision=3)}"
            )
