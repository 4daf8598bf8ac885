"""All that a tracker knows between frames, and with what it begins.

Frames: O object, C camera.
"""

from dataclasses import dataclass, field

import numpy as np

from vipr.systems import se3
from vipr.systems.errors import InputError
from vipr.systems.tracking.keyframes import Keyframe
from vipr.systems.tracking.motion_filter import Motion, at_rest


@dataclass(frozen=True, eq=False)
class Sure:
    """The motion when the image last left nothing in doubt."""

    motion: Motion
    time: float  # s
    agility: float  # as in ``Belief``


@dataclass(frozen=True, eq=False)
class Belief:
    """All that a tracker knows between frames."""

    motion: Motion = field(default_factory=Motion)
    state: str = "lost"  # tracking | uncertain | lost
    score: float = 0.0  # 0 to 1, probability that the pose is right
    nodes: int = 0  # edge nodes that support the pose
    residual_px: float = float("nan")  # robust RMS
    time: float = 0.0  # s, of the last frame
    number: int = -1  # of the last frame
    keyframes: tuple[Keyframe, ...] = ()
    X_CO_given: np.ndarray | None = None  # a pose from outside that no frame has been compared with yet
    X_CO_good: np.ndarray | None = None  # the last pose that was tracked
    doubtful: int = 0  # frames in a row that were not tracked
    started: bool = False  # whether an initial pose was ever given
    # 0.08 to 1, how unsteadily it has moved lately, as a share of the accelerations of the settings.
    agility: float = 1.0
    # (6, 6) of the pose, what is the same from frame to frame and does not average out in the motion's covariance.
    shared: np.ndarray = field(default_factory=lambda: np.zeros((6, 6)))
    closeness: float = 0.75  # 0 to 1, how closely its edges have fitted of late; at first, how closely they might
    sure: Sure | None = None  # None: never yet

    def __deepcopy__(self, memo):
        return self  # immutable: a context clone copies nothing

    @property
    def X_CO(self) -> np.ndarray:
        return self.motion.X_CO

    @property
    def V_CO(self) -> np.ndarray:
        return self.motion.V_CO

    @property
    def covariance(self) -> np.ndarray:
        """(6, 6) of (rotation, translation) in C."""
        return self.motion.covariance[:6, :6] + self.shared


def start(X_CO: np.ndarray, time: float = 0.0, number: int = -1, keyframes: tuple[Keyframe, ...] = ()) -> Belief:
    """Belief in an object at rest at a pose given from outside, with keyframes that are known already (see ``known_view``).

    Raises InputError for what is no pose before the camera.
    """
    X_CO = np.asarray(X_CO, float)
    if not se3.is_pose(X_CO):
        raise InputError("initial pose: X_CO must be a finite 4x4 rigid motion (rotation orthonormal to 1e-3)")
    if X_CO[2, 3] <= 0:
        raise InputError(f"initial pose: the object must be in front of the camera (z > 0), got z = {X_CO[2, 3]:.4g} m")
    U, _, Vt = np.linalg.svd(X_CO[:3, :3])
    X_CO = se3.pose(U @ Vt, X_CO[:3, 3])
    return Belief(
        at_rest(X_CO), "uncertain", time=time, number=number, keyframes=keyframes, X_CO_given=X_CO, started=True
    )
