"""Trajectories of a hand or a pen made comparable: cleaned, resampled, normalised, described (paper, II-A.3).

A trajectory is an array (T, d) of positions at equal time steps or a ``Trajectory`` with time stamps. Coordinates come in pairs
(x, y), one pair a hand; any unit will do, y may point up or down as long as it always does. Everything here works on many
trajectories at once: raw ones lie end to end, resampled ones are (N, T, d).
"""

from dataclasses import dataclass

import numpy as np

from vipr.systems.errors import InputError
from vipr.systems.gestures.gaps import way
from vipr.systems.gestures.ink import ink


@dataclass(frozen=True, eq=False)
class Trajectory:
    """Positions (T, d) with their times (T,) in seconds; NaN where not seen.

    ``lost`` (T,), where known: it was not seen between the point before and this one. ``clean`` makes it of the NaNs.
    """

    points: np.ndarray
    times: np.ndarray
    lost: np.ndarray | None = None

    def __len__(self):
        return len(self.points)


@dataclass(frozen=True)
class Stream:
    """One description of a trajectory, the observations of one family of HMMs."""

    features: tuple[str, ...] = ("position", "direction")  # of FEATURES, or one of PICTURES
    sampling: str = "arc"  # arc: equal steps of arc length; time: equal steps of time
    points: int = 32
    smoothing: int = 1  # passes of a (1 2 1)/4 filter over the resampled points
    scale: str = "spread"  # spread: unit RMS distance from the centroid; box: unit longer side; none: as given, not centred either

    def __post_init__(self):
        for name, value, allowed in (
            ("sampling", self.sampling, ("arc", "time")),
            ("scale", self.scale, ("spread", "box", "none")),
        ):
            if value not in allowed:
                raise InputError(f"gesture stream: {name} is one of {', '.join(allowed)}, got {value!r}")
        known = (*FEATURES, *PICTURES)
        unknown = [f for f in self.features if f not in known]
        if unknown or not self.features or self.points < 4 or self.smoothing < 0:
            raise InputError(
                f"gesture stream: features are among {', '.join(known)}, at least 4 points, smoothing not negative; "
                f"got {self.features}, {self.points} points, smoothing {self.smoothing}"
            )
        if self.picture and len(self.features) > 1:
            raise InputError(
                f"gesture stream: rows or columns of a picture go with no other feature, got {self.features}"
            )

    @property
    def picture(self) -> bool:
        """Whether the observations are lines of a picture, which do not show in what order it was drawn."""
        return bool(PICTURES.keys() & set(self.features))


def clean(trajectory) -> Trajectory | None:
    """The finite points in order of time, or None if fewer than two different positions remain.

    A point that is not finite, or not later than all before it, is dropped; where it was not finite, the next one says so (``lost``).
    """
    lost = None
    if isinstance(trajectory, Trajectory):
        points, times = np.asarray(trajectory.points, float), np.asarray(trajectory.times, float)
        lost = trajectory.lost
    else:
        points = np.asarray(trajectory, float)
        times = np.arange(len(points), dtype=float) if points.ndim else np.zeros(0)
    if points.ndim != 2 or len(points) < 2 or times.shape != (len(points),):
        return None
    finite = np.isfinite(points).all(axis=1) & np.isfinite(times)
    if not finite.all():
        points, times = points[finite], times[finite]
        gap = np.diff(np.flatnonzero(finite), prepend=-1) > 1
        lost = gap if lost is None else gap | lost[finite]
    if len(times) < 2:
        return None
    later = np.r_[True, times[1:] > np.maximum.accumulate(times)[:-1]]
    if not later.all():
        points, times, lost = points[later], times[later], None if lost is None else lost[later]
    if len(points) < 2 or not (np.ptp(points, axis=0).max() > 1e-9 * (1.0 + np.abs(points).max())):
        return None
    return Trajectory(points, times, lost)


def resample(trajectories: list[Trajectory], sampling: str, count: int) -> np.ndarray:
    """(N, count, d): cleaned trajectories at equal steps of time or of arc length, first and last point kept.

    Where one was not seen it is taken to have gone straight, and as far as it would at its average speed: ``seen_points`` tells where.
    """
    lengths = np.array([len(t) for t in trajectories])
    points = np.concatenate([t.points for t in trajectories])
    first = np.r_[0, np.cumsum(lengths)[:-1]]
    if sampling == "time":
        progress = np.concatenate([t.times for t in trajectories])
        progress = progress - np.repeat(progress[first], lengths)
    else:
        steps = np.r_[0.0, np.linalg.norm(np.diff(points, axis=0), axis=1)]
        steps[first] = 0.0
        for n in np.flatnonzero([t.lost is not None for t in trajectories]):
            steps[first[n] : first[n] + lengths[n]] = way(trajectories[n])
        progress = _running(steps, lengths, first)
    total = progress[first + lengths - 1]
    return _interpolate(points, progress / np.repeat(total, lengths), lengths, count)


def even(points: np.ndarray) -> np.ndarray:
    """(N, T, d) resampled at equal steps of arc length."""
    N, T, d = points.shape
    steps = np.linalg.norm(np.diff(points, axis=1), axis=2)
    progress = np.zeros((N, T))
    np.cumsum(steps, axis=1, out=progress[:, 1:])
    progress /= np.maximum(progress[:, -1:], 1e-300)
    return _interpolate(points.reshape(-1, d), progress.ravel(), np.full(N, T), T)


def _running(steps, lengths, first):
    total = np.cumsum(steps)
    return total - np.repeat(total[first] - steps[first], lengths)


def _interpolate(points, progress, lengths, count):
    """One call for all: the progress 0..1 of the n-th trajectory is moved to 2n..2n+1."""
    n = np.arange(len(lengths))
    known = progress + 2.0 * np.repeat(n, lengths)
    wanted = (np.linspace(0.0, 1.0, count) + 2.0 * n[:, None]).ravel()
    return np.stack([np.interp(wanted, known, c) for c in points.T], axis=-1).reshape(len(lengths), count, -1)


def smooth(points: np.ndarray, passes: int) -> np.ndarray:
    """(1 2 1)/4 along time, ends kept."""
    for _ in range(passes):
        new = points.copy()
        new[:, 1:-1] = 0.5 * points[:, 1:-1] + 0.25 * (points[:, :-2] + points[:, 2:])
        points = new
    return points


def normalise(points: np.ndarray, scale: str = "spread") -> np.ndarray:
    """Independent of position and size: centroid at zero, unit spread or unit box."""
    if scale == "none":
        return points
    centred = points - points.mean(axis=1, keepdims=True)
    if scale == "box":
        size = np.ptp(centred, axis=1).max(axis=1)
    else:
        size = np.sqrt((centred**2).sum(axis=2).mean(axis=1) * (2.0 / points.shape[2]))
    return centred / np.maximum(size, 1e-12)[:, None, None]


def _velocity(points):
    """Central differences per unit of the whole duration (time) or length (arc), a tenth of it as unit."""
    return np.gradient(points, axis=1) * (0.1 * (points.shape[1] - 1))


def _direction(points):
    v = np.gradient(points, axis=1)
    return v / np.maximum(np.linalg.norm(v, axis=2, keepdims=True), 1e-9)


def _turning(points):
    """Sine and cosine of the turn from the direction before to the direction after a point, for each pair of coordinates."""
    D = _direction(points)
    before, after = D[:, :-2], D[:, 2:]
    pairs = points.shape[2] // 2
    if pairs == 0:
        return np.zeros((*points.shape[:2], 0))
    bx, by, ax, ay = before[..., 0::2], before[..., 1::2], after[..., 0::2], after[..., 1::2]
    turn = np.concatenate(
        [bx[..., :pairs] * ay - by * ax[..., :pairs], bx[..., :pairs] * ax[..., :pairs] + by * ay], axis=-1
    )
    return np.concatenate([turn[:, :1], turn, turn[:, -1:]], axis=1)


def _box(points):
    """Each axis from -1/2 to 1/2, but no axis stretched more than the longest over 0.3."""
    low, high = points.min(axis=1, keepdims=True), points.max(axis=1, keepdims=True)
    size = high - low
    size = np.maximum(size, 0.3 * size.max(axis=2, keepdims=True))
    return (points - 0.5 * (low + high)) / np.maximum(size, 1e-12)


def _picture(points, axis):
    """Ink of each pair of coordinates; a single coordinate is drawn over time."""
    N, T, d = points.shape
    if d == 1:
        points = np.concatenate([np.broadcast_to(np.linspace(0.0, 1.0, T)[:, None], (N, T, 1)), points], axis=-1)
    pairs = [ink(_box(points[..., k : k + 2]), axis) for k in range(0, max(d - 1, 1), 2)]
    return np.concatenate(pairs, axis=-1)


FEATURES = {
    "position": lambda points: points,
    "velocity": _velocity,
    "direction": _direction,
    "turning": _turning,
    "box": _box,
}
PICTURES = {"rows": 1, "columns": 0}  # axis that the lines run along


def describe(points: np.ndarray, stream: Stream, seen: np.ndarray | None = None) -> np.ndarray:
    """Observations (N, T, D) of resampled points (N, T, d); NaN in gaps, at those that were not ``seen`` (N, T).

    Where a velocity or direction would lean on a point in a gap, that is missing too. In pictures a gap is drawn straight.
    """
    points = normalise(smooth(points, stream.smoothing), stream.scale)
    if stream.picture:
        return _picture(points, PICTURES[stream.features[0]])
    x = np.concatenate([FEATURES[f](points) for f in stream.features], axis=-1)
    if seen is not None and not seen.all():
        if set(stream.features) - {"position", "box"}:
            seen = (
                seen
                & np.pad(seen, ((0, 0), (1, 0)), mode="edge")[:, :-1]
                & np.pad(seen, ((0, 0), (0, 1)), mode="edge")[:, 1:]
            )
        x[~seen] = np.nan
    return x


@dataclass(frozen=True)
class Distortion:
    """How far another hand's version of a gesture may differ: standard deviations."""

    rotation: float = 0.12  # rad
    slant: float = 0.25  # shear, x per y
    aspect: float = 0.15  # log of the stretch in x, its inverse in y
    bend: float = 0.05  # slow displacement along the stroke, in units of the gesture's spread
    size: float = 0.15  # log of the unit in which positions are measured, where a stream's scale is none; without effect elsewhere


def distort(points: np.ndarray, stream: Stream, rng: np.random.Generator, how: Distortion) -> np.ndarray:
    """Another writer's version of each trajectory (N, T, d), for a stream: an affine change and a smooth bend.

    Odd last coordinates only bend.
    """
    N, T, d = points.shape
    centre = points.mean(axis=1, keepdims=True)
    centred = points - centre
    spread = np.sqrt((centred**2).sum(axis=2).mean(axis=1) * (2.0 / d))
    angle, slant, stretch = rng.normal(0.0, 1.0, (3, N)) * np.array([how.rotation, how.slant, how.aspect])[:, None]
    c, s, e = np.cos(angle), np.sin(angle), np.exp(stretch)
    A = np.stack([np.stack([c * e, c * slant - s / e], -1), np.stack([s * e, s * slant + c / e], -1)], -2)
    pairs = d // 2
    out = centred.copy()
    out[..., : 2 * pairs] = np.einsum("nij,ntpj->ntpi", A, centred[..., : 2 * pairs].reshape(N, T, pairs, 2)).reshape(
        N, T, -1
    )
    wave = np.arange(1, 5)
    amplitude = rng.normal(0.0, 1.0, (N, d, 4)) * (how.bend * spread[:, None, None] / np.sqrt(wave))
    phase = rng.uniform(0.0, 2.0 * np.pi, (N, d, 4))
    arc = np.pi * wave[:, None] * np.linspace(0.0, 1.0, T)
    bend = np.concatenate([amplitude * np.cos(phase), -amplitude * np.sin(phase)], -1) @ np.concatenate(
        [np.cos(arc), np.sin(arc)]
    )
    out += np.swapaxes(bend, 1, 2)
    out += centre
    if stream.scale == "none":
        out *= np.exp(rng.normal(0.0, how.size, (N, 1, 1)))
    return even(out) if stream.sampling == "arc" else out


def fill_up(labels: np.ndarray, enough: int) -> np.ndarray:
    """Indices of examples to copy so that every class of labels (N,) has ``enough``."""
    source = []
    for c in np.unique(labels):
        members = np.flatnonzero(labels == c)
        if len(members) < enough:
            source.append(members[np.arange(enough - len(members)) % len(members)])
    return np.concatenate(source) if source else np.zeros(0, int)
