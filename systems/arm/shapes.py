"""Convex shapes and the gap between them, many pairs at once.

A shape is a core (a box of half lengths ``half``, or a disc of radius ``disc`` thickened by ``half[2]`` along z) rounded by ``radius``:
box, sphere, capsule and cylinder are all of this form, and so all have the same support function and the same projection.

The gap is a *certified lower bound* of the distance: for any unit vector n, the slab between the two support planes across n is free, so
the widest slab found is never wider than the distance. Candidates for n are the shapes' own axes (exact where a face is nearest), the
products of their axes (two edges) and the directions that alternating projections between the cores run through (exact in the limit).
Overlapping shapes have a negative gap.
"""

from dataclasses import dataclass, field

import numpy as np

from vipr.systems import se3
from vipr.systems.errors import InputError

PROJECTIONS = 4  # alternating projections; each yields one direction


@dataclass(frozen=True, eq=False)
class Shape:
    """One convex shape; ``X`` is its middle in the frame of whatever carries it."""

    name: str
    half: np.ndarray  # (3,) m
    disc: float = 0.0  # m
    radius: float = 0.0  # m
    X: np.ndarray = field(default_factory=lambda: np.eye(4))

    def __post_init__(self):
        sizes = np.array([*self.half, self.disc, self.radius], float)
        if not np.isfinite(sizes).all() or (sizes < 0).any() or not sizes.any():
            raise InputError(f"shape {self.name}: sizes must be positive, got {np.array2string(1e3 * sizes)} mm")
        if not se3.is_pose(self.X):
            raise InputError(
                f"shape {self.name}: its place must be a rigid 4x4 pose, got {np.asarray(self.X).tolist()}"
            )

    def moved(self, X: np.ndarray) -> "Shape":
        """The same shape carried by a frame at X."""
        return Shape(self.name, self.half, self.disc, self.radius, X @ self.X)


def box(name: str, size: tuple[float, float, float], X: np.ndarray) -> Shape:
    """A box of the full size [m], its middle at X."""
    return Shape(name, 0.5 * np.asarray(size, float), X=X)


def sphere(name: str, radius: float, centre: tuple[float, float, float]) -> Shape:
    """A ball [m]."""
    return Shape(name, np.zeros(3), radius=radius, X=se3.pose(np.eye(3), centre))


def capsule(name: str, radius: float, length: float, X: np.ndarray) -> Shape:
    """A capsule along z of X, its middle there; length between the centres of its round ends [m]."""
    return Shape(name, np.array([0.0, 0.0, 0.5 * length]), radius=radius, X=X)


def cylinder(name: str, radius: float, length: float, X: np.ndarray) -> Shape:
    """A cylinder along z of X, its middle there [m]."""
    return Shape(name, np.array([0.0, 0.0, 0.5 * length]), disc=radius, X=X)


@dataclass(frozen=True, eq=False)
class Placed:
    """M shapes, each in its place: arrays over the first axis."""

    X: np.ndarray  # (M, 4, 4)
    half: np.ndarray  # (M, 3)
    disc: np.ndarray  # (M,)
    radius: np.ndarray  # (M,)

    @classmethod
    def of(cls, shapes: list[Shape]) -> "Placed":
        """Shapes in the places that they name."""
        return cls(
            np.array([s.X for s in shapes]).reshape(-1, 4, 4),
            np.array([s.half for s in shapes]).reshape(-1, 3),
            np.array([s.disc for s in shapes]),
            np.array([s.radius for s in shapes]),
        )

    def __getitem__(self, chosen) -> "Placed":
        return Placed(self.X[chosen], self.half[chosen], self.disc[chosen], self.radius[chosen])

    @property
    def reach(self) -> np.ndarray:
        """(M,) radius of the ball about the middle that holds the shape [m]."""
        flat = np.maximum(np.hypot(self.half[:, 0], self.half[:, 1]), self.disc)
        return np.hypot(flat, self.half[:, 2]) + self.radius

    def support(self, n: np.ndarray) -> np.ndarray:
        """(M, K) how far each shape extends from its middle along the unit vectors n (M, K, 3)."""
        local = np.abs(n @ self.X[:, :3, :3])
        flat = self.disc[:, None] * np.sqrt(local[..., 0] ** 2 + local[..., 1] ** 2)
        return (local @ self.half[:, :, None])[..., 0] + flat + self.radius[:, None]

    def nearest(self, p: np.ndarray) -> np.ndarray:
        """(M, 3) the core's point nearest to each p (M, 3)."""
        R, middle = self.X[:, :3, :3], self.X[:, :3, 3]
        local = ((p - middle)[:, None] @ R)[:, 0]
        inside = np.minimum(np.maximum(local, -self.half), self.half)
        round_ = np.flatnonzero(self.disc)
        if len(round_):
            flat, disc = local[round_, :2], self.disc[round_, None]
            out = np.sqrt((flat**2).sum(axis=1, keepdims=True))
            inside[round_, :2] = flat * np.minimum(disc / np.maximum(out, 1e-12), 1.0)
        return (R @ inside[:, :, None])[..., 0] + middle


def centre_distance(a: Placed, b: Placed) -> np.ndarray:
    """(M,) distance [m] of the middle of each a from the shape b; 0 inside. Never less than the distance between the shapes."""
    middle = a.X[:, :3, 3]
    return np.maximum(np.linalg.norm(middle - b.nearest(middle), axis=1) - b.radius, 0.0)


def gap(a: Placed, b: Placed) -> np.ndarray:
    """(M,) gap [m] of each pair (a, b): a lower bound of their distance, negative where they overlap."""
    between = a.X[:, :3, 3] - b.X[:, :3, 3]
    own = np.concatenate([a.X[:, :3, :3], b.X[:, :3, :3]], axis=2).swapaxes(1, 2)  # (M, 6, 3)
    cross = _cross(own[:, :3, None], own[:, None, 3:]).reshape(len(own), 9, 3)
    points, directions = a.X[:, :3, 3], []
    for _ in range(PROJECTIONS):
        foot = b.nearest(points)
        points = a.nearest(foot)
        n = points - foot
        directions.append(n)
    axes = np.concatenate([own, cross, np.stack(directions, axis=1)], axis=1)
    axes /= np.maximum(np.sqrt((axes**2).sum(axis=2, keepdims=True)), 1e-9)
    along = (axes @ between[:, :, None])[..., 0]
    free = np.abs(along) - a.support(axes) - b.support(axes)
    return free.max(axis=1, where=(axes**2).sum(axis=2) > 0.5, initial=-np.inf)


def _cross(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Cross products over the last axis."""
    x, y = a[..., [1, 2, 0]], b[..., [1, 2, 0]]
    return x * b[..., [2, 0, 1]] - a[..., [2, 0, 1]] * y
