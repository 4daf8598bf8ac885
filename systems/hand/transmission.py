"""The Barrett Hand's gear trains: motor angles to joint angles, with the TorqueSwitch seated or broken away.

Four motors: fingers 1, 2, 3 and the spread. A finger motor's angle m turns the inner link by J2 = m / 125 and the outer link, seen from the
palm, by J2 + J3 = m / 93.75. Once the inner link's clutch has broken away at J2 = b it holds there while the second relation goes on.
This module speaks of a motor by its *finger angle* c = m / 125, the angle that the inner link would have with its clutch seated [rad],
and of the spread motor by the spread angle m / 17.5. ``break_away`` is b, or infinite while the clutch is seated. Gear ratios, limits and
encoders: Barrett's support pages for the BH8-262 (gear teeth: 40/16 x 50 = 125, 30/16 x 50 = 93.75) and libbarrett.
"""

import numpy as np

from vipr.systems.errors import InputError

JOINTS = (
    "finger_1_spread",
    "finger_1_proximal",
    "finger_1_distal",
    "finger_2_spread",
    "finger_2_proximal",
    "finger_2_distal",
    "finger_3_proximal",
    "finger_3_distal",
)
MOTORS = ("finger_1", "finger_2", "finger_3", "spread")
SPREAD, PROXIMAL, DISTAL = np.array([0, 3]), np.array([1, 4, 6]), np.array([2, 5, 7])  # places in JOINTS

FINGER_RATIO = 125.0  # motor : J2
OUTER_RATIO = 93.75  # motor : J2 + J3
SPREAD_RATIO = 17.5  # motor : spread
COUNTS_PER_TURN = 360  # encoder of the BH8-262's motors

MOTOR_UPPER = np.radians([140.0, 140.0, 140.0, 180.0])
JOINT_UPPER = np.radians([180.0, 140.0, 48.0, 180.0, 140.0, 48.0, 140.0, 48.0])
DISTAL_UPPER = float(np.radians(48.0))
SEATED = np.full(3, np.inf)

_OUTER_PER_FINGER = (
    FINGER_RATIO / OUTER_RATIO
)  # 4/3: how far the outer link turns, seen from the palm, per finger angle


def joint_angles(motor: np.ndarray, break_away: np.ndarray) -> np.ndarray:
    """Angles (8,) [rad] of JOINTS for motor angles (4,) and break-away angles (3,); the stops are not considered."""
    finger, spread = np.asarray(motor[:3], float), motor[3]
    inner = np.minimum(finger, break_away)
    q = np.empty(8)
    q[SPREAD] = spread
    q[PROXIMAL] = inner
    q[DISTAL] = _OUTER_PER_FINGER * finger - inner
    return q


def joint_rates(motor_rate: np.ndarray, motor: np.ndarray, break_away: np.ndarray) -> np.ndarray:
    """Rates (8,) [rad/s] of JOINTS for motor rates (4,): the outer link is four times as fast once its inner link holds."""
    rate = np.asarray(motor_rate[:3], float)
    inner = np.where(is_seated(motor, break_away), rate, 0.0)
    v = np.empty(8)
    v[SPREAD] = motor_rate[3]
    v[PROXIMAL] = inner
    v[DISTAL] = _OUTER_PER_FINGER * rate - inner
    return v


def is_seated(motor: np.ndarray, break_away: np.ndarray) -> np.ndarray:
    """Whether each finger's clutch (3,) is seated: it has not broken away, or the motor is back before the place where it did."""
    return np.asarray(motor[:3]) < break_away


def motor_angles(joints: np.ndarray) -> np.ndarray:
    """Motor angles (4,) for joint angles (8,), from the relation that always holds; the spread is the mean of both fingers'."""
    finger = (joints[PROXIMAL] + joints[DISTAL]) / _OUTER_PER_FINGER
    return np.append(finger, joints[SPREAD].mean())


def finger_upper(break_away: float) -> float:
    """Largest angle of a finger: 140 degrees, or less where the outer link of a broken-away finger meets its stop at 48 degrees."""
    upper = float(MOTOR_UPPER[0])
    return min(upper, (DISTAL_UPPER + min(break_away, upper)) / _OUTER_PER_FINGER)


def motor_torques(joint_torque: np.ndarray, seated: np.ndarray) -> np.ndarray:
    """Torques (4,) [N m] that the motors bear, per finger or spread angle, for joint torques (8,): virtual work on the relations above."""
    inner, outer = joint_torque[PROXIMAL], joint_torque[DISTAL]
    finger = _OUTER_PER_FINGER * outer + np.where(seated, inner - outer, 0.0)
    return np.append(finger, joint_torque[SPREAD].sum())


def clutch_torques(joint_torque: np.ndarray) -> np.ndarray:
    """Torques (3,) [N m] through the clutches to the inner links' worms: the outer link is driven from the palm, past the inner one."""
    return joint_torque[PROXIMAL] - joint_torque[DISTAL]


def counts(motor: np.ndarray) -> np.ndarray:
    """Encoder counts (4,) of motor angles: 0 to 17,500 over a finger's 140 degrees, 0 to 3,150 over the spread's 180."""
    ratios = np.array([FINGER_RATIO] * 3 + [SPREAD_RATIO])
    return np.rint(np.asarray(motor) * ratios * COUNTS_PER_TURN / (2 * np.pi)).astype(int)


def from_counts(count: np.ndarray) -> np.ndarray:
    """Motor angles (4,) of encoder counts."""
    ratios = np.array([FINGER_RATIO] * 3 + [SPREAD_RATIO])
    return np.asarray(count) * 2 * np.pi / (ratios * COUNTS_PER_TURN)


def check_command(motor: np.ndarray) -> np.ndarray:
    """The command (4,), or InputError naming the motor that is sent past its stop."""
    motor = np.asarray(motor, float)
    if motor.shape != (4,):
        raise InputError(f"Barrett Hand: a command has 4 angles (fingers 1, 2, 3, spread), got shape {motor.shape}")
    for name, angle, upper in zip(MOTORS, motor, MOTOR_UPPER, strict=True):
        if not 0 <= angle <= upper + 1e-9:
            raise InputError(
                f"Barrett Hand: {name} commanded to {np.degrees(angle):.1f} deg, allowed 0 to {np.degrees(upper):.0f} deg"
            )
    return motor
