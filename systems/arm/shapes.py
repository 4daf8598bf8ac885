"""Convex shapes for clearance.

A shape is a core (a box of half lengths ``half``, or a disc of radius ``disc`` thickened by ``half[2]`` along z) rounded by ``radius``:
box, sphere, capsule and cylinder are all of this form, and so all have the same support function and the same projection (see ``gaps``).
"""

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from vipr.systems import se3
from vipr.systems.arm.gaps import pair_gaps, smallest_gaps
from vipr.systems.errors import InputError


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
class ShapeTable:
    """S shapes as arrays."""

    X: np.ndarray  # (S, 4, 4)
    half: np.ndarray  # (S, 3)
    disc: np.ndarray  # (S,)
    radius: np.ndarray  # (S,)

    @classmethod
    def of(cls, shapes: Sequence[Shape]) -> "ShapeTable":
        """The shapes in the places that they name."""
        return cls(
            np.array([s.X for s in shapes], float).reshape(-1, 4, 4),
            np.array([s.half for s in shapes], float).reshape(-1, 3),
            np.array([s.disc for s in shapes], float),
            np.array([s.radius for s in shapes], float),
        )

    def __add__(self, other: "ShapeTable") -> "ShapeTable":
        return ShapeTable(
            np.concatenate([self.X, other.X]),
            np.concatenate([self.half, other.half]),
            np.concatenate([self.disc, other.disc]),
            np.concatenate([self.radius, other.radius]),
        )


def gap(a: Shape, b: Shape) -> float:
    """Gap [m] of two shapes in one frame: at most their distance, negative where they overlap."""
    table, first, second = ShapeTable.of([a, b]), np.array([0]), np.array([1])
    return float(pair_gaps(table.X[None], table.half, table.disc, table.radius, first, second)[0, 0])


def compile_gaps() -> None:
    """Compile what clearance and guard call, with a pair of balls."""
    table = ShapeTable.of([sphere("a", 0.1, (0, 0, 0)), sphere("b", 0.1, (0, 0, 1))])
    for function in (pair_gaps, smallest_gaps):
        function(table.X[None], table.half, table.disc, table.radius, np.array([0]), np.array([1]))
