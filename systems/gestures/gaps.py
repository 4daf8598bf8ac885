"""Gaps: stretches of a trajectory in which the hand was not seen.

Where it went is not known, but how long it took is: the observations in a gap are missing, and hidden Markov models integrate them out.
A trajectory here is a cleaned one (``trajectories.clean``), whose ``lost`` tells before which points the hand was not seen.
"""

import numpy as np

GAP = (0.05, 0.45)  # least and greatest share of a gesture that is not seen while training for that


def way(t) -> np.ndarray:
    """(T,) lengths of the ways to each point of a trajectory with gaps: a gap is as long as its time at the average speed elsewhere."""
    steps = np.r_[0.0, np.linalg.norm(np.diff(t.points, axis=0), axis=1)]
    times = np.r_[0.0, np.diff(t.times)]
    gap = np.r_[False, t.lost[1:]]
    speed = steps[~gap].sum() / max(times[~gap].sum(), 1e-300)
    return np.where(gap, np.maximum(steps, speed * times), steps)


def seen_points(trajectories, sampling: str, count: int) -> np.ndarray:
    """(N, count) bool: which of the points of ``trajectories.resample`` lie in no gap. A gap of less than two steps is none."""
    seen = np.ones((len(trajectories), count), bool)
    wanted = np.linspace(0.0, 1.0, count)
    for row, t in zip(seen, trajectories, strict=True):
        if t.lost is not None:
            progress = t.times - t.times[0] if sampling == "time" else np.cumsum(way(t))
            progress = progress / progress[-1]
            wide = np.flatnonzero(t.lost[1:] & (np.diff(progress) > 2.0 / (count - 1)))
            for a, b in zip(progress[wide], progress[wide + 1], strict=True):
                row[(wanted > a) & (wanted < b)] = False
    return seen


def lose(points: np.ndarray, seen: np.ndarray, rng: np.random.Generator, share: float) -> tuple[np.ndarray, np.ndarray]:
    """Points (N, T, d) of which ``share`` were not seen for a while, where they go straight, and which are ``seen`` (N, T)."""
    N, T, _ = points.shape
    some = np.flatnonzero(rng.random(N) < share)
    length = (rng.uniform(*GAP, len(some)) * T).astype(int)
    first = (rng.random(len(some)) * (T - length - 1)).astype(int)
    t = np.arange(T)
    inside = (t > first[:, None]) & (t <= (first + length)[:, None])
    along = ((t - first[:, None]) / (length + 1)[:, None])[..., None]
    n = np.arange(len(some))
    a, b = points[some][n, first][:, None], points[some][n, first + length + 1][:, None]
    points, seen = points.copy(), seen.copy()
    points[some] = np.where(inside[..., None], a + along * (b - a), points[some])
    seen[some] &= ~inside
    return points, seen
