"""What a user of the hand tells it, in the words of its controller box: open, close, spread, go to a position, grasp with so much force.

A command is the pair (motor angles (4,) [rad], torque limits (4,) [N m]) of fingers 1, 2, 3 and the spread, for the driver's ports. A
finger goes on until it is there or bears its torque limit, whichever comes first.
"""

import numpy as np

from vipr.systems.errors import InputError
from vipr.systems.hand import transmission
from vipr.systems.hand.torque_switch import Drives

TIP_LEVER = 0.12  # m, from a finger's base joint to its tip: N m of torque limit for 1 N there

Command = tuple[np.ndarray, np.ndarray]


def go_to(angles: np.ndarray, drives: Drives = Drives()) -> Command:
    """All four motors to these angles [rad]; InputError for one beyond its stop."""
    return transmission.check_command(angles), np.array(drives.torque_limit)


def go_to_counts(counts: np.ndarray, drives: Drives = Drives()) -> Command:
    """All four motors to these encoder counts: 0 to 17,500 for a finger, 0 to 3,150 for the spread."""
    return go_to(transmission.from_counts(counts), drives)


def open_fingers(now: np.ndarray, drives: Drives = Drives()) -> Command:
    """All fingers open, the spread as it is now (4,)."""
    return go_to(np.append(np.zeros(3), now[3]), drives)


def close_fingers(now: np.ndarray, drives: Drives = Drives()) -> Command:
    """All fingers to their stops or to what they meet, at full torque."""
    return go_to(np.append(transmission.MOTOR_UPPER[:3], now[3]), drives)


def spread_to(now: np.ndarray, angle: float, drives: Drives = Drives()) -> Command:
    """Fingers 1 and 2 spread to an angle [rad], the fingers as they are now (4,)."""
    return go_to(np.append(now[:3], angle), drives)


def grasp(now: np.ndarray, force: float, drives: Drives = Drives()) -> Command:
    """Close until fingers 1 and 2 each press with ``force`` [N] at the tip, and finger 3 with as much as both, if it can."""
    most = drives.torque_limit[0] / TIP_LEVER
    if not 0 < force <= most:
        raise InputError(
            f"Barrett Hand: grasp force must be above 0 and at most {most:.0f} N at a tip, got {force:g} N"
        )
    angles, limit = close_fingers(now, drives)
    each = force * TIP_LEVER
    return angles, np.array([each, each, min(2.0 * each, drives.torque_limit[2]), limit[3]])


def stop(now: np.ndarray, drives: Drives = Drives()) -> Command:
    """Stay where the motors are now (4,): what is held stays held, the worms see to that."""
    return go_to(np.clip(now, 0.0, transmission.MOTOR_UPPER), drives)
