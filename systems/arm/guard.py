"""The collision guard: joint rates that can always be brought to rest before arm or hand touch anything.

A step is allowed only if braking straight to rest after it keeps every gap above the margin. Braking along the line that the last step was
tested on is then always possible, so the arm stops before contact from any speed and in any configuration. On the way, the speed of
approach falls with the gap, which makes the stop smooth; the whole rate vector is shortened, so that the tool keeps its direction. Where
the gap is already below the margin, every motion that does not narrow it is free.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from vipr.systems.arm.collision import ArmBody
from vipr.systems.arm.resolved_rate import JointLimits, step_towards, within_stops
from vipr.systems.arm.shapes import Shape, ShapeTable
from vipr.systems.errors import InputError

SPACING, PLACES = 0.05, 12  # m, at most, between the tested places of a braking path; how many there are at most
SLACK = 1e-6  # m, of numbers


@dataclass(frozen=True, eq=False)
class CollisionGuard:
    """What is to be kept apart and how: ``body`` from ``obstacles`` (in B) and from itself."""

    body: ArmBody
    obstacles: tuple[Shape, ...] = ()
    margin: float = 0.005  # m, the least gap
    approach: float = 8.0  # 1/s: the gap's excess over the margin shrinks at most at this rate
    # The body for the motor angles (4,) [rad] of its hand, and how far from the last link's frame [m] no finger ever reaches.
    with_hand: Callable[[np.ndarray], ArmBody] | None = None
    hand_extent: float = 0.0

    def __post_init__(self):
        if not 0 <= self.margin <= 0.5:
            raise InputError(f"collision guard: margin must be 0 to 500 mm, got {1e3 * self.margin:g} mm")
        if not 0 < self.approach <= 100:
            raise InputError(
                f"collision guard: approach must be above 0 and at most 100 1/s, got {self.approach:g} 1/s"
            )

    @cached_property
    def pairs(self) -> tuple[np.ndarray, np.ndarray]:
        """Numbers (P,) of the two shapes of each pair that is watched."""
        return self.body.pairs_with(len(self.obstacles))

    @cached_property
    def names(self) -> list[tuple[str, str]]:
        """The two shapes of each pair, the arm's first."""
        names = [s.name for s in (*self.body.shapes, *self.obstacles)]
        return [(names[i], names[j]) for i, j in zip(*self.pairs, strict=True)]

    @cached_property
    def reach(self) -> np.ndarray:
        """(P, n) [m]: the gap of a pair changes by at most ``reach @ |dq|`` for joint displacements dq."""
        arm, n, links = self.body.arm, len(self.body.arm.d), (*self.body.links, *(0,) * len(self.obstacles))
        lengths = np.hypot(arm.a, arm.d)
        reach = np.zeros((len(self.pairs[0]), n))
        for p, (i, j) in enumerate(zip(*self.pairs, strict=True)):
            for joint in range(links[j], links[i]):  # between the two links
                # From the joint's axis to its link's origin, on along the links between, and across the shape.
                reach[p, joint] = abs(arm.a[joint]) + lengths[joint + 1 : links[i]].sum() + self._extents[i]
        return reach

    @cached_property
    def _extents(self) -> list[float]:
        """How far each shape of the body reaches from its link's frame [m]; fingers wherever they are."""
        moved = self.body if self.with_hand is None else self.with_hand(np.full(4, 0.5))
        return [
            np.linalg.norm(s.X[:3, 3]) + np.linalg.norm(s.half) + s.disc + s.radius
            if np.array_equal(s.X, t.X)
            else self.hand_extent
            for s, t in zip(self.body.shapes, moved.shapes, strict=True)
        ]

    def table(self, motor: np.ndarray | None = None) -> ShapeTable:
        """All shapes, the fingers at the motor angles (4,) [rad] (None: as in ``body``)."""
        body = self.body if motor is None or self.with_hand is None else self.with_hand(motor)
        return body.table + self._obstacles

    @cached_property
    def _obstacles(self) -> ShapeTable:
        return ShapeTable.of(self.obstacles)

    def gaps(self, q: np.ndarray, chosen: np.ndarray, table: ShapeTable) -> np.ndarray:
        """(N, S) gaps [m] of the chosen pairs at q (N, n)."""
        first, second = self.pairs
        return self.body.gaps(q, first[chosen], second[chosen], table)


@dataclass(frozen=True)
class Guarded:
    """A step's rates; the gap (P,) [m] that is certain in each pair after it; which pair held it back (-1: none)."""

    rates: np.ndarray
    gaps: np.ndarray
    pair: int = -1


def guarded_rates(
    guard: CollisionGuard,
    rates: np.ndarray,
    q: np.ndarray,
    previous: np.ndarray,
    gaps: np.ndarray,
    limits: JointLimits,
    dt: float,
    motor: np.ndarray | None = None,
) -> Guarded:
    """The rates (n,) [rad/s], slowed down or braked where needed.

    Args:
        guard: what is to be kept apart.
        rates: that respect the joints' own limits.
        q: joint set-points [rad].
        previous: rates of the last period, as given by this function.
        gaps: (P,) [m] at most the true ones at q, as given by this function; -infinity: unknown. Only pairs whose known gap leaves the
            step in doubt are looked at.
        limits: of the joints; for braking.
        dt: period [s].
        motor: where the hand's motors are (4,) [rad], if it is known.
    """
    table = guard.table(motor)

    def towards(wanted):
        return within_stops(step_towards(wanted, previous, limits, dt), q, limits, dt)

    gaps, pair = np.array(gaps, float), -1
    share, nearest, touches = _inspect(guard, table, q, rates, gaps, limits, dt)
    if share < 1.0:
        pair, rates = nearest, towards(share * rates)
        _, nearest, touches = _inspect(guard, table, q, rates, gaps, limits, dt)
    if touches:
        pair, braked = nearest, towards(np.zeros_like(rates))
        rates = 0.5 * (rates + braked)
        if _inspect(guard, table, q, rates, gaps, limits, dt)[2]:
            rates = braked
    return Guarded(rates, gaps - dt * (guard.reach @ np.abs(rates)), pair)


def _inspect(
    guard: CollisionGuard,
    table: ShapeTable,
    q: np.ndarray,
    rates: np.ndarray,
    gaps: np.ndarray,
    limits: JointLimits,
    dt: float,
) -> tuple[float, int, bool]:
    """What a step at the rates and braking straight to rest after it would do; ``gaps`` are made exact where in doubt.

    Returns:
        the share of the rates at which no gap shrinks too fast, the pair that decides, and whether a gap would fall below the margin.
    """
    duration = dt + 0.5 * float(np.max(np.abs(rates) / limits.acceleration))  # at these rates: the whole way to rest
    fastest = guard.reach @ np.abs(rates)
    doubtful = (gaps - fastest * duration <= guard.margin) | (fastest > guard.approach * (gaps - guard.margin))
    chosen = np.flatnonzero(doubtful)
    if not len(chosen):
        return 1.0, -1, False
    count = min(1 + int(fastest[chosen].max() * duration / SPACING), PLACES)
    along = guard.gaps(q + np.linspace(0.0, duration, count + 1)[:, None] * rates, chosen, table)
    gaps[chosen] = now = along[0]
    closing = (now - along[1]) * count / duration
    allowed = guard.approach * np.maximum(now - guard.margin, 0.0)
    shares = np.where(closing > allowed + SLACK, allowed / np.maximum(closing, SLACK), 1.0)
    room = along.min(axis=0) - np.minimum(guard.margin, now) + SLACK
    decides = chosen[np.argmin(room) if room.min() < 0 else np.argmin(shares)]
    return float(shares.min()), int(decides), bool(room.min() < 0)
