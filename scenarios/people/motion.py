"""From hand paths to joint positions of the person: analytic inverse kinematics of both arms, idle sway and head motion.

Frames: W the floor below the person, x towards the camera, y to the person's left, z up; S the same axes with its origin midway between
the shoulders (of a person that does not sway). Hand paths are in S [m].
"""

from dataclasses import dataclass

import numpy as np

from vipr.models.person.generate import JOINTS, Body
from vipr.systems.errors import InputError

SIDES = ("right", "left")
STRIDE = 0.05  # m a frame, the pace of a hand between two gestures


@dataclass(frozen=True, eq=False)
class HandPaths:
    """Paths of the middle of both hands in S [m], one row a frame; None rests at the side. Both of one length."""

    right: np.ndarray | None = None  # (n, 3)
    left: np.ndarray | None = None  # (n, 3)

    def __post_init__(self):
        for name in ("right", "left"):
            path = getattr(self, name)
            if path is None:
                continue
            path = np.asarray(path, float)
            if path.ndim != 2 or path.shape[1] != 3 or len(path) == 0 or not np.isfinite(path).all():
                raise InputError(
                    f"hand paths: {name} must be finite with shape (n, 3) in metres, got shape {path.shape}"
                )
            object.__setattr__(self, name, path)
        if self.right is None and self.left is None:
            raise InputError("hand paths: at least one hand needs a path")
        if self.right is not None and self.left is not None and len(self.right) != len(self.left):
            raise InputError(f"hand paths: both need one length, got {len(self.right)} and {len(self.left)} frames")

    def __len__(self):
        return len(self.right if self.right is not None else self.left)


def rest(body: Body, side: str) -> np.ndarray:
    """(3,) where a hanging hand is in S [m]."""
    sign = 1.0 if side == "left" else -1.0
    return np.array([0.06, sign * (body.shoulder_half_width + 0.09), -0.975 * (body.upper_arm + body.reach_to_palm)])


def plane_path(
    points: np.ndarray, side: str = "right", size: float = 0.35, forward: float = 0.38, centre=None
) -> np.ndarray:
    """A drawing as a hand path (n, 3) in S [m]: points (n, 2) are x to the image's right and y up, in units of ``size`` about 0.

    The plane faces the camera ``forward`` m before the shoulders; ``centre`` (y, z) [m] is where the drawing's 0 lies, by default a little
    to the side of the drawing hand at chest height.
    """
    points = np.asarray(points, float)
    y, z = centre if centre is not None else (0.2 if side == "left" else -0.2, -0.15)
    return np.column_stack([np.full(len(points), forward), y + size * points[:, 0], z + size * points[:, 1]])


def arm_angles(path: np.ndarray, body: Body, side: str) -> np.ndarray:
    """(n, 5) joint angles [rad] of one arm (shoulder z, y, x, elbow, wrist roll) that bring the hand along path (n, 3) in S [m].

    The elbow hangs down and outwards; the palm turns to the camera. Targets out of reach are met at the end of the straight arm.
    """
    sign = 1.0 if side == "left" else -1.0
    p = np.atleast_2d(path) - (0.0, sign * body.shoulder_half_width, 0.0)
    l1, l2 = body.upper_arm, body.reach_to_palm
    distance = np.linalg.norm(p, axis=1)
    n = p / np.maximum(distance, 1e-9)[:, None]
    d = np.clip(distance, abs(l1 - l2) + 0.03, l1 + l2 - 0.003)
    along = (l1**2 - l2**2 + d**2) / (2 * d)
    out = np.sqrt(np.maximum(l1**2 - along**2, 0.0))
    hint = np.array([-0.25, 0.45 * sign, -1.0])
    m = hint - (n @ hint)[:, None] * n
    m /= np.maximum(np.linalg.norm(m, axis=1), 1e-6)[:, None]
    upper = (along[:, None] * n + out[:, None] * m) / l1
    fore = (d[:, None] * n - l1 * upper) / l2
    z = -upper
    x = -m + np.einsum("ij,ij->i", m, upper)[:, None] * upper
    x /= np.linalg.norm(x, axis=1)[:, None]
    y = np.cross(z, x)
    flexion = np.arctan2(np.einsum("ij,ij->i", fore, x), np.einsum("ij,ij->i", fore, upper))
    a_z, a_y = np.arctan2(x[:, 1], x[:, 0]), np.arcsin(np.clip(-x[:, 2], -1, 1))
    a_x = np.arctan2(y[:, 2], z[:, 2])
    # Palm (x of the hand) towards the camera (x of S), about the forearm's axis.
    x_f = np.cross(y, -fore)
    roll = np.arctan2(y[:, 0], x_f[:, 0])
    return np.unwrap(np.column_stack([a_z, a_y, a_x, -flexion, roll]), axis=0)


def smooth_noise(rng: np.random.Generator, n: int, period: float, rate: float = 25.0) -> np.ndarray:
    """(n,) smooth noise of unit size that changes over about ``period`` s."""
    t = np.arange(n) / rate
    frequency = rng.uniform(0.5, 1.6, 4) / period
    return np.sin(2 * np.pi * (np.outer(t, frequency) + rng.uniform(0, 1, 4))).sum(1) / 2.0


def joint_positions(
    paths: HandPaths, body: Body, rng: np.random.Generator, idle: float = 1.0, rate: float = 25.0
) -> np.ndarray:
    """(n, 15) positions of :data:`~vipr.models.person.generate.JOINTS` (m, rad): arms by inverse kinematics, idle motion by rng."""
    n = len(paths)
    q = np.zeros((n, len(JOINTS)))
    sizes = (0.012, 0.015, 0.02, 0.09, 0.05)
    for column, size in enumerate(sizes):
        q[:, column] = idle * size * smooth_noise(rng, n, 2.5, rate)
    for side, start in (("left", 5), ("right", 10)):
        path = getattr(paths, side)
        if path is None:
            path = rest(body, side) + 0.006 * idle * np.column_stack(
                [smooth_noise(rng, n, 1.5, rate) for _ in range(3)]
            )
        q[:, start : start + 5] = arm_angles(path, body, side)
    return q


def led_in(path: HandPaths, before: dict[str, np.ndarray], body: Body, pause: int) -> HandPaths:
    """The path after the way to its beginning from ``before``, at most ``STRIDE`` a frame on average, and a pause."""
    start = {s: rest(body, s) if getattr(path, s) is None else getattr(path, s)[0] for s in SIDES}
    furthest = max(np.linalg.norm(start[s] - before[s]) for s in SIDES)
    share = 0.5 - 0.5 * np.cos(np.pi * np.linspace(0.0, 1.0, max(4, int(np.ceil(furthest / STRIDE)))))[:, None]
    hands = {}
    for side in SIDES:
        own = getattr(path, side)
        if own is None and np.array_equal(before[side], start[side]):
            hands[side] = None
            continue
        there = np.repeat(start[side][None], pause + (len(path) if own is None else 0), axis=0)
        way = before[side] + share * (start[side] - before[side])
        hands[side] = np.concatenate([way, there, *([] if own is None else [own])])
    return HandPaths(**hands)


def greeting() -> HandPaths:
    """Both hands move about for 2.4 s at 25 Hz: who watches learns skin, room and hands."""
    turn = np.linspace(0.0, 4.0 * np.pi, 60)
    wave = np.column_stack([np.full(60, 0.36), 0.12 * np.sin(turn), 0.1 * np.cos(turn) - 0.2])
    return HandPaths(right=wave + (0.0, -0.34, 0.0), left=wave * (1.0, -1.0, 1.0) + (0.0, 0.34, 0.0))
