"""What a pick holds between its ticks, what it senses and is told, and the steps from one phase to the next.

Frames: C camera, O object, E hand. Phases in the order of ``PHASES``; after ``release``, ``retreat`` and ``home`` it looks again.
"""

from dataclasses import dataclass, field, replace

import numpy as np

from vipr.systems import se3
from vipr.systems.arm.joint_path import JointPath
from vipr.systems.errors import InputError
from vipr.systems.grasping.planning import Errand, Plan
from vipr.systems.signals import ObjectPose, Signal

PHASES = (
    "look",
    "reach",
    "approach",
    "close",
    "verify",
    "lift",
    "check",
    "carry",
    "hold",
    "confirm",
    "release",
    "retreat",
    "home",
)
ENDS = ("held", "gave up")
WATCHING = ("look", "check", "confirm")  # phases in which the camera is needed
CARRYING = ("lift", "check", "carry", "hold", "confirm")  # the object should be in the hand


@dataclass(frozen=True)
class PickSettings:
    """How a pick is done and judged by the robot itself."""

    errand: Errand = Errand()
    hold_s: float = 5.0
    attempts: int = 3
    close_rate: float = 0.8  # rad/s of the fingers' command
    frames: int = 6  # sightings that a pose is made of
    still_mm: float = 2.0  # they differ by at most
    sure_mm: float = 3.0  # standard deviation of the place that a grasp is planned from, by the tracker
    settle: bool = True  # the object is known to stand on its support: place and tilt follow from that
    look_s: float = 1.5  # time for them
    settle_s: float = 0.2  # after a motion
    lost_s: float = 0.12  # so long without torque at a finger means that nothing is held
    lost_torque: float = 0.25  # of the torque after closing
    least_torque: float = 0.4  # of its limit, at a finger that holds something
    touch_torque: float = 0.35  # N m at a finger on the way to the object: it has met something
    ease_s: float = 0.5  # time to draw back from that
    short_mm: float = 15.0  # so far from the grasp the fingers may close nevertheless
    closed_within_deg: float = 16.0  # of the taught finger angles
    slip_mm: float = 12.0  # seen in the hand, half hidden by the fingers: reported
    drop_mm: float = 40.0  # seen: it is not in the hand any more
    gain: float = 4.0  # 1/s, of the loop around the joint paths

    def __post_init__(self):
        for name, value in vars(self).items():
            if name not in ("errand", "settle") and not value > 0:
                raise InputError(f"pick: {name} must be positive, got {value}")


@dataclass(frozen=True, eq=False)
class Senses:
    """What the robot knows at a tick."""

    time: float
    q: np.ndarray  # (6,) rad, encoders
    motors: np.ndarray  # (4,) rad, of the hand
    torque: np.ndarray  # (4,) N m, of its motors
    seen: ObjectPose


@dataclass(frozen=True, eq=False)
class PickState(Signal):
    """What the state machine holds between its ticks."""

    phase: str = "look"
    since: float = 0.0  # s, when the phase began
    attempt: int = 0
    tried: tuple[str, ...] = ()  # names of grasps
    plan: Plan | None = None
    path: JointPath | None = None  # walked since ``since``
    q_home: np.ndarray = field(
        default_factory=lambda: np.zeros(0)
    )  # (6,) rad, where the arm was at first: out of the camera's way
    q_hold: np.ndarray = field(default_factory=lambda: np.zeros(0))  # (6,) where the arm stands while it walks no path
    command: np.ndarray = field(default_factory=lambda: np.zeros(4))  # rad, to the hand
    limit: np.ndarray = field(default_factory=lambda: np.full(4, 1.8))  # N m
    motors: np.ndarray = field(default_factory=lambda: np.zeros(4))  # rad, when a finger last moved
    moved: float = 0.0  # s, when that was
    grip: np.ndarray = field(default_factory=lambda: np.zeros(3))  # N m, after closing
    low: bool = False  # it let go where it closed, so that the hand must back out
    slack: float = float("nan")  # s, since when the fingers bear nothing
    sightings: tuple[np.ndarray, ...] = ()  # X_CO
    covariance: np.ndarray = field(default_factory=lambda: np.eye(3))  # (3, 3) of the last one's position in C
    number: int = -1  # of the last frame among them
    initial: ObjectPose = ObjectPose()  # where the tracker shall look
    X_WO: np.ndarray = field(default_factory=lambda: np.eye(4))  # last seen before it was grasped
    X_EO: np.ndarray = field(default_factory=lambda: np.eye(4))  # believed, in the hand
    slip: float = float("nan")  # m, seen in the hand between lifting and the end
    text: str = "look"
    level: str = "info"

    @property
    def ended(self) -> bool:
        return self.phase in ENDS


def watch(state: PickState, senses: Senses) -> PickState:
    """Take in what the tracker has seen since the phase began."""
    seen = senses.seen
    if seen.number <= state.number or seen.time < state.since or seen.state == "lost":
        return state
    sightings = (*state.sightings, seen.X_CO) if seen.state == "tracking" else ()
    return replace(state, sightings=sightings, number=seen.number, covariance=seen.covariance[3:, 3:])


def seen(state: PickState, settings: PickSettings) -> np.ndarray | None:
    """X_CO from the newest sightings, once there are enough that agree."""
    last = np.array(state.sightings[-settings.frames :])
    if len(last) < settings.frames or np.ptp(last[:, :3, 3], axis=0).max() > 1e-3 * settings.still_mm:
        return None
    return se3.pose(last[-1][:3, :3], np.median(last[:, :3, 3], axis=0))


def hint(X_CO: np.ndarray, time: float) -> ObjectPose:
    return ObjectPose(X_CO=X_CO, state="uncertain", time=time)


def look_for(state: PickState, senses: Senses, X_CO: np.ndarray) -> PickState:
    """Begin a look: the tracker starts afresh from X_CO."""
    return replace(state, initial=hint(X_CO, senses.time), sightings=())


def go(state, senses, phase, path: JointPath | None, text: str = "", level: str = "info") -> PickState:
    q_hold = state.q_hold if path is None else path.end
    return replace(state, phase=phase, since=senses.time, path=path, q_hold=q_hold, text=text or phase, level=level)


def stay(state, senses, phase, text: str = "", level: str = "info") -> PickState:
    """The next phase where the arm is: at the end of its path, or where it was stopped."""
    q_hold = state.q_hold
    if state.path is not None and senses.time - state.since < state.path.duration:
        q_hold = senses.q
    return replace(state, phase=phase, since=senses.time, path=None, q_hold=q_hold, text=text or phase, level=level)


def end(state, senses, phase, text, level="info") -> PickState:
    level = "error" if phase == "gave up" else level
    text = f"gave up: {text}" if phase == "gave up" else text
    state = replace(stay(state, senses, phase, text, level))
    return state if phase == "held" else replace(state, command=np.append(np.zeros(3), state.command[3]))
