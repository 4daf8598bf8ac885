"""Cutting a stream of hand positions into movements at its pauses (paper, II-A.3), one frame at a time.

Hands at rest begin to move when one of them leaves its resting place by more than trembling and noise would; they rest again when
they stay in one place for a short while. Two different conditions, so that a slow corner does not cut a gesture and
trembling does not start one. Lengths are in faces (the square root of a face's area in the image), times in seconds.
"""

from dataclasses import dataclass, field

import numpy as np

from vipr.systems.errors import InputError
from vipr.systems.gestures.trajectories import Trajectory


@dataclass(frozen=True)
class PauseSettings:
    """When hands move and when they rest."""

    leave: float = 0.4  # faces from the resting place: the hands move
    memory: float = 0.5  # s, the resting place is the median over this time
    window: float = 0.2  # s over which stillness is judged
    still: float = 0.3  # faces: the hands rest again if nothing moved further within the window
    shift: float = 0.1  # faces: and if its later half lies no further from its earlier half
    turn: float = 0.15  # faces: nor its ends further to one side of its middle, as where a hand turns back
    near: float = 0.15  # faces: frames at either end that are so near the resting place are cut off
    least_time: float = 0.2  # s, shortest movement
    least_extent: float = 0.8  # faces, smallest movement
    longest: float = 6.0  # s after which a movement is cut
    unseen: float = 1.0  # s for which moving hands may be out of sight and are still in the same movement

    def __post_init__(self):
        positive = all(v > 0 for v in self.__dict__.values())
        if not (positive and self.near < self.leave and self.window <= self.memory and self.least_time < self.longest):
            raise InputError(
                "pauses: all settings must be positive, near below leave, window not above memory, least_time below longest; got "
                + ", ".join(f"{k} {v:g}" for k, v in self.__dict__.items())
            )


@dataclass(frozen=True, eq=False)
class MotionBelief:
    """What the segmenter knows: the frames since shortly before the hands last rested."""

    times: tuple[float, ...] = ()
    points: tuple[np.ndarray, ...] = field(default_factory=tuple)  # of (d,)
    moving: bool = False


def advance(
    belief: MotionBelief, time: float, point: np.ndarray, settings: PauseSettings
) -> tuple[MotionBelief, Trajectory | None]:
    """Take in the positions (d,) of all hands, (x, y) each; returns the new belief and the movement that ended with this frame, if any.

    A frame that is not later than the last one or not finite is passed over; after a gap of more than ``memory``, or ``unseen`` if the
    hands were moving, it starts afresh.
    """
    point = np.asarray(point, float)
    if not np.isfinite(time) or not np.isfinite(point).all() or (belief.times and time <= belief.times[-1]):
        return belief, None
    if belief.times and time - belief.times[-1] > (settings.unseen if belief.moving else settings.memory):
        belief = MotionBelief()
    times, points = (*belief.times, float(time)), (*belief.points, point)
    if not belief.moving:
        since = int(np.searchsorted(times, time - settings.memory))
        times, points = times[since:], points[since:]
        away = np.abs(point - np.median(points, axis=0)).max()
        return MotionBelief(times, points, bool(away > settings.leave and len(times) > 2)), None
    if not _resting(times, points, settings) and time - times[0] < settings.longest:
        return MotionBelief(times, points, True), None
    since = int(np.searchsorted(times, time - settings.window - 1e-6))
    rest = MotionBelief(times[since:], points[since:], False)
    movement = _trim(Trajectory(np.array(points), np.array(times)), settings)
    long_enough = movement.times[-1] - movement.times[0] >= settings.least_time
    return rest, movement if long_enough and np.ptp(movement.points, axis=0).max() >= settings.least_extent else None


def _resting(times, points, settings) -> bool:
    """Whether the hands kept to one place during the window: nothing moved far, nor from its earlier to its later half, nor turned back."""
    since = int(np.searchsorted(times, times[-1] - settings.window - 1e-6))
    if len(times) - since < 4 or times[-1] - times[since] < 0.75 * settings.window:
        return False
    recent = np.asarray(points[since:])
    half = len(recent) // 2
    shift = np.abs(recent[half:].mean(axis=0) - recent[:half].mean(axis=0)).max()
    if not (shift < settings.shift and np.ptp(recent, axis=0).max() < settings.still):
        return False
    time = np.asarray(times[since:])
    turn = np.polyfit((2.0 * time - time[0] - time[-1]) / (time[-1] - time[0]), recent, 2)[0]
    return bool(np.abs(turn).max() < settings.turn)


def _trim(movement: Trajectory, settings: PauseSettings) -> Trajectory:
    """Without the frames at either end during which the hands are still, or already, in place.

    If they never were in place, as when a recording begins in the middle of a movement, nothing is cut off there.
    """
    head = movement.points[movement.times <= movement.times[0] + settings.window]
    tail = movement.points[movement.times >= movement.times[-1] - settings.window - 1e-6]
    first = _departure(movement.points, head, settings)
    last = len(movement) - 1 - _departure(movement.points[::-1], tail, settings)
    if last <= first:
        return movement
    return Trajectory(movement.points[first : last + 1], movement.times[first : last + 1])


def _departure(points, resting, settings) -> int:
    """The last frame in place, which is the middle of the ``resting`` points, before the hands are clearly away from it."""
    if np.ptp(resting, axis=0).max() > settings.still:
        return 0
    away = np.abs(points - np.median(resting, axis=0)).max(axis=1)
    gone = int((away > settings.leave).argmax())
    inside = np.flatnonzero(away[: gone + 1] < settings.near)
    return int(inside[-1]) if len(inside) else 0


def segment(times: np.ndarray, points: np.ndarray, settings: PauseSettings | None = None) -> list[Trajectory]:
    """All movements of a recording: times (T,), points (T, d) in faces. A movement still going on at the end is not one."""
    settings = settings or PauseSettings()
    belief, found = MotionBelief(), []
    for time, point in zip(times, points, strict=True):
        belief, movement = advance(belief, time, point, settings)
        if movement is not None:
            found.append(movement)
    return found
