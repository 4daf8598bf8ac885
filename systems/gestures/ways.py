"""Hands on their way from where one gesture ended to where another begins: what a recogniser sees all day, and must not take for a gesture.

Nobody needs to film them: the ends and the beginnings of a person's gestures say where such ways go, and hands that are brought somewhere
go straight, from rest to rest.
"""

import numpy as np

from vipr.systems.gestures.trajectories import Trajectory

PACE = (4.0, 10.0)  # faces/s on average, of the hand that has the longest way: 0.6 to 1.5 m/s
LEAST_WAY, LEAST_TIME = 1.0, 0.2  # faces, s
SWING = 0.04  # of the way, by which an arm's path sags or rises midway
NOISE = 0.03  # faces, of a tracked position
RATE = 25.0  # Hz


def ways(gestures: list[Trajectory], people: np.ndarray, count: int, rng: np.random.Generator) -> list[Trajectory]:
    """``count`` ways between gestures (in faces) of one person each, ``people`` (N,) says whose they are.

    Fewer, down to none, if the gestures end where they begin.
    """
    people = np.unique(people, return_inverse=True)[1]
    groups = [np.flatnonzero(people == p) for p in range(people.max(initial=-1) + 1)]
    found: list[Trajectory] = []
    for _ in range(10 * count if groups else 0):
        group = groups[rng.integers(len(groups))]
        a, b = rng.choice(group, 2)
        start, end = gestures[a].points[-1], gestures[b].points[0]
        distance = np.linalg.norm((end - start).reshape(-1, 2), axis=1).max()
        if distance > LEAST_WAY:
            found.append(_way(start, end, distance, rng))
        if len(found) == count:
            break
    return found


def _way(start, end, distance, rng):
    frames = int(np.ceil(RATE * max(distance / rng.uniform(*PACE), LEAST_TIME)))
    share = np.linspace(0.0, 1.0, frames + 1)[:, None]
    points = start + 0.5 * (1.0 - np.cos(np.pi * share)) * (end - start)
    points[:, 1::2] += np.sin(np.pi * share) * rng.normal(0.0, SWING * distance, points.shape[1] // 2)
    return Trajectory(points + rng.normal(0.0, NOISE, points.shape), share[:, 0] * frames / RATE)
