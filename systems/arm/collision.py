"""How far an arm is from what it could hit: obstacles in the world, and itself.

Frames: B the arm's base, the world of the obstacles. Each link carries convex shapes (``shapes``); pairs that the mechanism keeps apart, or
that always touch, are left out. Distances are certified: never more than the true distance of the shapes.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from vipr.systems.arm.gaps import pair_gaps, smallest_gaps
from vipr.systems.arm.kinematics import SerialArm
from vipr.systems.arm.shapes import Shape, ShapeTable
from vipr.systems.errors import InputError


@dataclass(frozen=True, eq=False)
class ArmBody:
    """An arm of n joints as convex shapes, each in the frame of its link (0 the base ... n)."""

    arm: SerialArm
    shapes: tuple[Shape, ...]
    links: tuple[int, ...]  # of each shape
    ignored: tuple[tuple[int, int], ...] = ()  # links (outer, inner) that the mechanism keeps apart, besides neighbours

    def __post_init__(self):
        if len(self.shapes) != len(self.links):
            raise InputError(f"arm body: {len(self.shapes)} shapes but {len(self.links)} links")

    @cached_property
    def _own_pairs(self) -> np.ndarray:
        """(P, 2): the shapes of different links that may meet."""
        links = list(enumerate(self.links))
        found = [(i, j) for i, a in links for j, b in links if a - b >= 2 and (a, b) not in self.ignored]
        return np.array(found, int).reshape(-1, 2)

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
        arm, other = self.pairs_with(len(obstacles))
        if not len(arm):
            raise InputError("clearance: the arm's shapes and the obstacles make no pair that could meet")
        table = self.table + ShapeTable.of(obstacles)
        gaps, nearest = smallest_gaps(self._placed(q, table), table.half, table.disc, table.radius, arm, other)
        names = [*(s.name for s in self.shapes), *(s.name for s in obstacles)]
        pairs = [(names[arm[k]], names[other[k]]) for k in nearest]
        return (gaps, pairs) if q.ndim == 2 else (gaps[0], pairs[0])

    def gaps(self, q: np.ndarray, first: np.ndarray, second: np.ndarray, table: ShapeTable) -> np.ndarray:
        """(N, P) the gap [m] of each given pair (numbered as by ``pairs_with``, in the table of body and obstacles) at each q (N, n)."""
        return pair_gaps(self._placed(q, table), table.half, table.disc, table.radius, first, second)

    def pairs_with(self, obstacles: int) -> tuple[np.ndarray, np.ndarray]:
        """Numbers (P,) of the arm's shape and of the other one in each pair that may meet: own shapes first, then the obstacles.

        The base never moves: it meets no obstacle.
        """
        moving = np.flatnonzero(np.array(self.links) > 0)
        own = self._own_pairs
        first = np.concatenate([own[:, 0], np.repeat(moving, obstacles)])
        second = np.concatenate([own[:, 1], len(self.shapes) + np.tile(np.arange(obstacles), len(moving))])
        return first.astype(int), second.astype(int)

    @cached_property
    def table(self) -> ShapeTable:
        """The shapes in their links."""
        return ShapeTable.of(self.shapes)

    def _placed(self, q: np.ndarray, table: ShapeTable) -> np.ndarray:
        """(N, S, 4, 4) where all shapes of the table (of body and obstacles) are in B at each q."""
        X_BL, own = self.arm.link_poses(np.atleast_2d(q))[:, list(self.links)], len(self.shapes)
        X = np.empty((len(X_BL), len(table.disc), 4, 4))
        X[:, :own] = X_BL @ table.X[:own]
        X[:, own:] = table.X[own:]
        return X
