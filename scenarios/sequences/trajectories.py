"""Trajectories X_CO(t) of an object before a still camera C: turns, ramps, swings, and being carried and shaken by a hand.

A trajectory is a function of time [s] that returns a 4x4 pose; C has x right, y down, z forward. Rotations are about axes of C through
``centre_O``, a point of the object [m], so that a turning object stays where it is.
"""

from collections.abc import Callable

import numpy as np

from vipr.systems import se3
from vipr.systems.camera.lens import Lens
from vipr.systems.errors import InputError

Trajectory = Callable[[float], np.ndarray]
AXES = {"x": np.array([1.0, 0, 0]), "y": np.array([0, 1.0, 0]), "z": np.array([0, 0, 1.0])}


def displaced(X_CO: np.ndarray, w: np.ndarray, v: np.ndarray, centre_O: np.ndarray | None = None) -> np.ndarray:
    """The pose turned by the rotation vector w (in C, about the centre) and moved by v [m] (in C)."""
    centre_O = np.zeros(3) if centre_O is None else centre_O
    centre_C = X_CO[:3, :3] @ centre_O + X_CO[:3, 3]
    R = se3.exp_so3(np.asarray(w, float)) @ X_CO[:3, :3]
    return se3.pose(R, centre_C + v - R @ centre_O)


def travelled(t: float, still: float, ramp: float) -> float:
    """Seconds' worth of full speed covered by t [s]: still first, then up to speed along a half cosine of length ramp [s]."""
    s = t - still
    if s <= 0:
        return 0.0
    if s < ramp:
        return 0.5 * (s - ramp / np.pi * np.sin(np.pi * s / ramp))
    return s - 0.5 * ramp


def still(X_CO: np.ndarray) -> Trajectory:
    """Not moving."""
    return lambda t: X_CO


def turning(X_CO, axis: str | np.ndarray, degrees_per_s: float, *, centre_O=None, wait=0.2, ramp=0.24) -> Trajectory:
    """Turning at a steady speed about an axis of C (``x``, ``y``, ``z`` or a vector), after a wait and a ramp [s]."""
    axis = AXES[axis] if isinstance(axis, str) else np.asarray(axis, float) / np.linalg.norm(axis)
    return lambda t: displaced(X_CO, axis * np.radians(degrees_per_s) * travelled(t, wait, ramp), np.zeros(3), centre_O)


def gliding(X_CO, velocity_C, *, wait=0.2, ramp=0.24) -> Trajectory:
    """Moving straight at a velocity (3,) [m/s] in C, after a wait and a ramp [s]."""
    return lambda t: displaced(X_CO, np.zeros(3), np.asarray(velocity_C, float) * travelled(t, wait, ramp))


def swinging(X_CO, amplitude_C, top_speed: float, *, wait=0.2) -> Trajectory:
    """Swinging from side to side by the vector amplitude_C (3,) [m] as a sine whose top speed is given [m/s]."""
    amplitude_C = np.asarray(amplitude_C, float)
    rate = top_speed / np.linalg.norm(amplitude_C)
    return lambda t: displaced(X_CO, np.zeros(3), amplitude_C * np.sin(rate * travelled(t, wait, 0.24)))


def jumping(before: Trajectory, after: Trajectory, when: float) -> Trajectory:
    """One trajectory until ``when`` [s], another from then on: a teleport."""
    return lambda t: before(t) if t < when else after(t)


def hand_held(
    X_CO: np.ndarray,
    points_O: np.ndarray,
    lens: Lens,
    *,
    seed: int,
    pixels_per_frame: float = 18.0,
    duration: float = 4.0,
    rate: float = 25.0,
    centre_O: np.ndarray | None = None,
) -> Trajectory:
    """Carried about and shaken: band-limited noise in all six parameters, at rest at first.

    points_O (N, 3) are the object's corners: the noise is scaled until the fastest of them moves by pixels_per_frame between two frames of
    the duration, and kept within the picture. Carrying is 0.15 to 0.6 Hz and 60 mm (times the scale), shaking 0.8 to 2.2 Hz.
    """
    rng = np.random.default_rng(seed)
    slow, fast = rng.uniform(0.15, 0.6, (3, 6)), rng.uniform(0.8, 2.2, (4, 6))
    usual_slow = np.array([0.25, 0.25, 0.2, 0.06, 0.05, 0.05])
    usual_fast = np.array([0.12, 0.12, 0.12, 0.012, 0.012, 0.012])
    frequency = np.concatenate([slow, fast])
    amplitude = np.concatenate(
        [usual_slow / 3 * rng.uniform(0.5, 1.5, (3, 6)), usual_fast / 4 * rng.uniform(0.5, 1.5, (4, 6))]
    )
    phase = rng.uniform(0, 2 * np.pi, frequency.shape)

    def motion(t):
        s = travelled(t, 0.2, 1.0)
        return np.sum(amplitude * (np.sin(2 * np.pi * frequency * s + phase) - np.sin(phase)), axis=0)

    times = np.arange(0.0, duration + 0.5 / rate, 1.0 / rate)
    motions = np.array([motion(t) for t in times])
    # Keep the centre within the middle of the picture: the excursion of the position is squeezed, its speed hardly changes.
    room = 0.5 * np.array([lens.width / lens.fx, lens.height / lens.fy]) * X_CO[2, 3] - _reach(X_CO, points_O)
    squeeze = np.ones(6)
    most = np.maximum(np.abs(motions[:, 3:5]).max(axis=0), 1e-9)
    squeeze[3:5] = np.minimum(1.0, np.maximum(room, 0.01) * 0.8 / most)

    def at(t, scale):
        m = motion(t) * squeeze * scale
        return displaced(X_CO, m[:3], m[3:], centre_O)

    low, high = 0.0, 20.0
    for _ in range(40):
        scale = 0.5 * (low + high)
        poses = [at(t, scale) for t in times]
        speed = corner_speed(poses, points_O, lens)
        low, high = (scale, high) if speed < pixels_per_frame else (low, scale)
    if not np.isfinite(corner_speed([at(t, low) for t in times], points_O, lens)):
        raise InputError(f"hand-held motion: {pixels_per_frame} px a frame would take the object behind the camera")
    return lambda t: at(t, low)


def corner_speed(poses, points_O: np.ndarray, lens: Lens) -> float:
    """The longest way [px] that any of the points (N, 3) goes between two of the poses that follow each other."""
    p_C = np.array([points_O @ X[:3, :3].T + X[:3, 3] for X in poses])
    if (p_C[..., 2] < 0.05).any():
        return np.inf
    return float(np.linalg.norm(np.diff(lens.project(p_C), axis=0), axis=-1).max())


def _reach(X_CO, points_O):
    return np.abs((points_O - points_O.mean(axis=0)) @ X_CO[:2, :3].T).max(axis=0)
