"""Sequences of camera frames with the true pose of each, under chosen conditions.

``for frame, X_CO in sequence(renderer, "box", trajectory, 100, Conditions(exposure=0.02), seed=3): ...``
"""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from vipr.scenarios.sequences.renderer import SAMPLES, SequenceRenderer
from vipr.scenarios.sequences.trajectories import Trajectory
from vipr.systems import se3
from vipr.systems.errors import InputError
from vipr.systems.signals import CameraFrame

HANDS = ("none", "half", "holding")
GREY = np.array([0.299, 0.587, 0.114], np.float32)  # of RGB


@dataclass(frozen=True)
class Conditions:
    """What the camera and the world do to the pictures."""

    noise: float = 2.0  # grey levels RMS
    exposure: float = 0.0  # s; the true pose is that of its middle
    hand: str = "none"  # none | half (a hand sweeps in and hides half of it) | holding (fingers before one side)
    light_change: float = 0.0  # share of the light that goes at 1/3 of the sequence and comes back at 2/3
    light_ramp: float = 0.12  # s, how long the change takes
    drop_every: int = 0  # each n-th frame does not arrive; 0: all arrive
    colour: bool = False  # BGR instead of the grey of the XC-77
    samples: int = SAMPLES  # sub-frames of a still picture
    finer: int = 1  # how many times finer they are rendered

    def __post_init__(self):
        if self.hand not in HANDS:
            raise InputError(f"rendered sequences: unknown hand {self.hand!r}, allowed are {', '.join(HANDS)}")
        if not 0 <= self.light_change <= 1:
            raise InputError(f"rendered sequences: light_change must be a share from 0 to 1, got {self.light_change}")
        if self.noise < 0 or self.exposure < 0:
            raise InputError("rendered sequences: noise and exposure must not be negative")


def sequence(
    renderer: SequenceRenderer,
    name: str,
    trajectory: Trajectory,
    frames: int,
    conditions: Conditions | None = None,
    *,
    rate: float = 25.0,
    seed: int = 0,
) -> Iterator[tuple[CameraFrame, np.ndarray]]:
    """Frames with the true X_CO at the middle of each exposure; a dropped frame has an empty image. Same seed, same bytes."""
    conditions = conditions or Conditions()
    rng = np.random.default_rng(seed)
    length = frames / rate
    hand = hand_motion(renderer, name, trajectory, conditions.hand, length)
    for k in range(frames):
        t = k / rate
        noise = rng.standard_normal(
            (renderer.lens.height, renderer.lens.width, 3 if conditions.colour else 1), np.float32
        )
        if conditions.drop_every and k % conditions.drop_every == conditions.drop_every - 1:
            yield CameraFrame(time=t, number=k), trajectory(t)
            continue
        clean = renderer.picture(
            name,
            lambda s, t=t: trajectory(t + s),
            (lambda s, t=t: hand(t + s)) if hand else None,
            exposure=conditions.exposure,
            samples=conditions.samples,
            finer=conditions.finer,
        )
        clean = clean[..., ::-1] if conditions.colour else (clean @ GREY)[..., None]
        seen = clean * _light(conditions, t, length) + conditions.noise * noise
        image = np.clip(np.rint(seen), 0, 255).astype(np.uint8)
        yield CameraFrame(image if conditions.colour else image[..., 0], t, k), trajectory(t)


def _light(conditions, t, length):
    away = np.clip((t - length / 3) / conditions.light_ramp, 0, 1) - np.clip(
        (t - 2 * length / 3) / conditions.light_ramp, 0, 1
    )
    return np.float32(1.0 - conditions.light_change * away)


def hand_motion(renderer, name, trajectory, kind, length):
    """X_CH(t) of a kind of hand (see `Conditions`) in a sequence of a length [s], or None where there is none."""
    if kind == "none":
        return None
    points_O = renderer.points(name)
    low, high = points_O.min(axis=0), points_O.max(axis=0)
    if kind == "holding":
        X_CO = trajectory(0.0)
        # Fingers over the side of the object that is on the right and near, carried along with it.
        p_C = points_O @ X_CO[:3, :3].T + X_CO[:3, 3]
        edge = np.array([p_C[:, 0].max() - 0.3 * np.ptp(p_C[:, 0]), p_C[:, 1].mean(), p_C[:, 2].min() - 0.014])
        X_OH = se3.inverse(X_CO) @ se3.pose(np.eye(3), edge)
        return lambda t: trajectory(t) @ X_OH

    half = 0.5 * np.linalg.norm(high - low)

    def hiding(t):
        X_CO = trajectory(t)
        centre_C = X_CO[:3, :3] @ (0.5 * (low + high)) + X_CO[:3, 3]
        height = np.ptp((points_O @ X_CO[:3, :3].T)[:, 1])
        # So near that the fingers look as high as the object, and their tips a little beyond its middle.
        depth = min(0.086 / max(height, 0.02) * centre_C[2], centre_C[2] - half - 0.03)
        come = np.clip((t - 0.2 * length) / (0.08 * length), 0.0, 1.0)  # sweeps in from the right
        tips = centre_C * depth / centre_C[2] - np.array([0.012, 0.0, 0.0])
        return se3.pose(np.eye(3), tips + np.array([0.4 * (1 - come), 0.0, 0.0]))

    return hiding


def hidden_share(renderer: SequenceRenderer, name: str, X_CO: np.ndarray, X_CH: np.ndarray) -> float:
    """Share of the object's visible area that the hand hides."""
    empty, alone, both = (
        renderer.picture(name, lambda s, X=X: X, lambda s, H=H: H, samples=1)
        for X, H in ((None, None), (X_CO, None), (X_CO, X_CH))
    )
    visible = (np.abs(alone - empty) > 1).any(axis=2)
    return float((visible & (np.abs(both - alone) > 1).any(axis=2)).sum() / max(visible.sum(), 1))
