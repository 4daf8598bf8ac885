"""How far an arm is from what it could hit: obstacles in the world, and itself.

Frames: B the arm's base, the world of the obstacles. Each link carries convex shapes (``shapes``); pairs that the mechanism keeps apart, or
that always touch, are left out. Distances are certified: never more than the true distance of the shapes.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from vipr.systems.arm.kinematics import SerialArm
from vipr.systems.arm.shapes import Placed, Shape, centre_distance, gap
from vipr.systems.errors import InputError

TOLERANCE = 1e-4  # m: pairs whose bound cannot beat the smallest known gap by more than this are not looked at closely


@dataclass(frozen=True, eq=False)
class ArmBody:
    """An arm of n joints as convex shapes, each in the frame of its link (0 the base ... n)."""

    arm: SerialArm
    shapes: tuple[Shape, ...]
    links: tuple[int, ...]  # of each shape
    ignored: tuple[
        tuple[int, int], ...
    ] = ()  # links (outer, inner), besides neighbours, that the mechanism keeps apart

    def __post_init__(self):
        if len(self.shapes) != len(self.links):
            raise InputError(f"arm body: {len(self.shapes)} shapes but {len(self.links)} links")

    @cached_property
    def _placed(self) -> Placed:
        return Placed.of(list(self.shapes))

    @cached_property
    def _own_pairs(self) -> np.ndarray:
        """(P, 2): the shapes of different links that may meet."""
        links = list(enumerate(self.links))
        found = [(i, j) for i, a in links for j, b in links if a - b >= 2 and (a, b) not in self.ignored]
        return np.array(found, int).reshape(-1, 2)

    def place(self, q: np.ndarray) -> Placed:
        """All shapes at q (n,) in B; for many q (N, n) the shapes of the first, of the second, and so on."""
        X_BL = self.arm.link_poses(np.atleast_2d(q))[:, list(self.links)]
        p, count = self._placed, len(X_BL)
        X = (X_BL @ p.X).reshape(-1, 4, 4)
        return Placed(X, np.tile(p.half, (count, 1)), np.tile(p.disc, count), np.tile(p.radius, count))

    def clearance(self, q: np.ndarray, obstacles: tuple[Shape, ...] = ()) -> tuple[np.ndarray, list[tuple[str, str]]]:
        """Smallest gap and its pair, for each of many configurations.

        Args:
            q: joint angles (n,) or (N, n) [rad].
            obstacles: shapes in B.

        Returns:
            gaps (N,) [m] (a number for a single q): at most the distance, negative where shapes overlap; and for each the names of the two
            shapes, the arm's first (one pair for a single q).
        """
        q = np.asarray(q, float)
        many = np.atleast_2d(q)
        count, size = len(many), len(self.shapes)
        mine = self.place(many)
        arm, other = self._all_pairs(len(obstacles))
        blocks = np.arange(count)[:, None]
        fixed = Placed.of(list(obstacles))
        all_shapes = Placed(*(np.concatenate(pair) for pair in zip(_fields(mine), _fields(fixed), strict=True)))
        first = (blocks * size + arm).ravel()
        second = np.where(other < size, blocks * size + other, count * size + other - size).ravel()
        distance = np.full(count * len(arm), np.inf)
        if len(distance):
            a, b = all_shapes[first], all_shapes[second]
            most = centre_distance(a, b)
            least = most - a.reach
            bound = most.reshape(count, -1).min(axis=1).repeat(len(arm))
            close = np.flatnonzero(least <= bound - TOLERANCE)
            distance[close] = gap(a[close], b[close])
        distance = distance.reshape(count, -1)
        nearest = distance.argmin(axis=1) if distance.shape[1] else np.zeros(count, int)
        names = [*(s.name for s in self.shapes), *(s.name for s in obstacles)]
        pairs = [(names[arm[k]], names[other[k]]) if len(arm) else ("", "") for k in nearest]
        gaps = distance.min(axis=1, initial=np.inf)
        return (gaps, pairs) if q.ndim == 2 else (gaps[0], pairs[0])

    def _all_pairs(self, obstacles: int) -> tuple[np.ndarray, np.ndarray]:
        """Numbers of the arm's shape and of the other one: its own shapes first, then the obstacles. Link 0 never moves."""
        moving = np.flatnonzero(np.array(self.links) > 0)
        own = self._own_pairs
        first = np.concatenate([own[:, 0], np.repeat(moving, obstacles)])
        second = np.concatenate([own[:, 1], len(self.shapes) + np.tile(np.arange(obstacles), len(moving))])
        return first.astype(int), second.astype(int)


def _fields(p: Placed) -> tuple[np.ndarray, ...]:
    return p.X, p.half, p.disc, p.radius
