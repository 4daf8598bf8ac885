"""Motors and clutches of the Barrett Hand, one control period at a time.

A finger motor turns through a worm, so nothing turns it back: it advances at its own speed until its torque limit and stands there. Its
TorqueSwitch is a clutch between motor and inner link. When closing puts more than the break-away torque through the clutch, it lets go: the
inner link's worm holds it where it is and the outer link goes on, four times as fast. The clutch seats again when opening winds the motor
back to where it broke away. The spread motor has no worm: beyond its torque limit the fingers push it along.

Angles are those of :mod:`vipr.systems.hand.transmission`. Behaviour: Barrett's support pages for the BH8-262 and GraspIt's BreakAwayDOF.
"""

import math
from dataclasses import dataclass, field

import numpy as np

from vipr.systems.errors import InputError
from vipr.systems.hand import transmission
from vipr.systems.hand.transmission import DISTAL, PROXIMAL, SPREAD

# Torque limits [N m] for a pinch between the tips, below break-away: finger 3 stands against two.
PINCH = (0.8, 0.8, 1.6, 2.0)

_SPREAD_UPPER = float(transmission.MOTOR_UPPER[3])


@dataclass(frozen=True, kw_only=True)
class Drives:
    """What the four motors (fingers 1, 2, 3, spread), three clutches and eight joint servos can do."""

    speed: tuple[float, ...] = (2.4, 2.4, 2.4, 6.3)  # rad/s of finger and spread angle; a finger closes in 1.0 s
    torque_limit: tuple[float, ...] = (1.8, 1.8, 1.8, 2.0)  # N m per finger or spread angle: 15 N at a tip
    break_away_torque: float = 1.0  # N m through the clutch, set by the user of the hand; infinite: no TorqueSwitch
    stiffness: tuple[float, ...] = (100.0, 100.0, 60.0)  # N m/rad of spread, inner, outer joint: as in the model
    damping: tuple[float, ...] = (1.0, 1.0, 0.5)  # N m s/rad

    def __post_init__(self):
        for name, count in (("speed", 4), ("torque_limit", 4), ("stiffness", 3), ("damping", 3)):
            value = getattr(self, name)
            if len(value) != count or not all(v > 0 for v in value):
                raise InputError(f"Barrett Hand: {name} must be {count} positive numbers, got {value}")
        if not self.break_away_torque > 0:
            raise InputError(f"Barrett Hand: break-away torque must be positive, got {self.break_away_torque} N m")


# The clutches set so firmly that finger 3 stands against two others at a tip, and still lets go where an inner link is stopped.
GRASPING = Drives(break_away_torque=1.5)


@dataclass(frozen=True)
class Motors:
    """State at a control tick, and the rates until the next one."""

    angle: np.ndarray = field(default_factory=lambda: np.zeros(4))  # rad, finger and spread angles
    rate: np.ndarray = field(default_factory=lambda: np.zeros(4))  # rad/s
    break_away: np.ndarray = field(default_factory=lambda: transmission.SEATED)  # rad, infinite while seated

    def setpoints(self) -> np.ndarray:
        """[q; v] (16,) of the joints at the tick; they go on at the rates v until the next one."""
        v = transmission.joint_rates(self.rate, self.angle, self.break_away)
        return np.concatenate([transmission.joint_angles(self.angle, self.break_away), v])


@dataclass(frozen=True)
class Loads:
    """Torques that the drives bear [N m], without what the servos spend on catching up with their set-points."""

    motor: np.ndarray  # (4,) per finger or spread angle
    clutch: np.ndarray  # (3,)
    strain: np.ndarray  # (3,) about the fingers' last joints: what the strain gauges show

    @staticmethod
    def measure(drives: Drives, motors: Motors, joint_rate: np.ndarray, joint_torque: np.ndarray) -> "Loads":
        """From the rates [rad/s] and torques [N m] (8,) of the joints at the end of a control period."""
        wanted = transmission.joint_rates(motors.rate, motors.angle, motors.break_away)
        damping = np.empty(8)
        damping[SPREAD], damping[PROXIMAL], damping[DISTAL] = drives.damping
        static = joint_torque - damping * (wanted - joint_rate)
        motor = transmission.motor_torques(static, np.isinf(motors.break_away))
        return Loads(motor, transmission.clutch_torques(static), static[DISTAL])


def advance(
    drives: Drives,
    motors: Motors,
    command: np.ndarray,
    limit: np.ndarray,
    joint_rate: np.ndarray,
    loads: Loads,
    period: float,
) -> Motors:
    """The motors at the end of a control period [s], and their rates for the next one.

    command (4,): where the motors shall go [rad]; limit (4,): torques at which they stop [N m]; joint_rate (8,): measured [rad/s]. What
    happened between two ticks, a clutch that let go or a motor that stopped, is put where it happened: back along the way of that period.
    """
    turning = transmission.motor_angles(joint_rate)
    rows = zip(motors.angle, motors.rate, command, limit, turning, loads.motor, drives.speed, strict=True)
    rows = [tuple(map(float, row)) for row in rows]
    clutches = zip(motors.break_away.tolist(), loads.clutch.tolist(), strict=True)
    fingers = [_finger(drives, period, *row, *clutch) for row, clutch in zip(rows[:3], clutches, strict=True)]
    spread = _spread(drives, period, *rows[3])
    return Motors(
        np.array([finger[0] for finger in fingers] + [spread[0]]),
        np.array([finger[1] for finger in fingers] + [spread[1]]),
        np.array([finger[2] for finger in fingers]),
    )


def _finger(drives, period, angle, rate, command, limit, turning, torque, speed, break_away, clutch_torque):
    """Angle, rate and break-away angle of one finger's motor."""
    _, inner, outer = drives.stiffness
    clutch_stiffness = inner - outer / 3
    travel = rate * period
    angle += travel
    if travel < 0 and angle <= break_away:
        break_away = math.inf
    seated = break_away == math.inf
    stiffness = inner + outer / 9 if seated else 16 / 9 * outer
    spare = drives.break_away_torque - clutch_torque
    if seated and travel > 0 and spare <= 0:
        break_away, seated = angle - min(-spare / clutch_stiffness, travel), False
    elif torque * travel > 0 and abs(torque) > limit:
        overrun = math.copysign(min((abs(torque) - limit) / stiffness, abs(travel)), travel)
        angle -= overrun
        torque -= stiffness * overrun
    wanted = (min(max(command, 0.0), transmission.finger_upper(break_away)) - angle) / period
    way = math.copysign(1.0, wanted)
    # How far a finger will give way by moving on: slower than its motor means that it is being stopped, and will lose as much again.
    yielding = max(way * (2 * turning - rate), 0.0)
    room = max((limit - way * torque) / (stiffness * period) + yielding, 0.0)
    if seated and way > 0:  # close to the break-away torque a finger creeps, so that it passes it by little
        margin = 0.05 * drives.break_away_torque + spare
        room = min(room, max(margin / (clutch_stiffness * period) + yielding, 0.0))
    return angle, way * min(abs(wanted), speed, room), break_away


def _spread(drives, period, angle, rate, command, limit, turning, torque, speed):
    """Angle and rate of the spread's motor, which yields beyond its torque limit."""
    stiffness = 2 * drives.stiffness[0]
    angle += rate * period
    if abs(torque) > limit:
        angle = min(max(angle - math.copysign((abs(torque) - limit) / stiffness, torque), 0.0), _SPREAD_UPPER)
        torque = math.copysign(limit, torque)
    wanted = (min(max(command, 0.0), _SPREAD_UPPER) - angle) / period
    way = math.copysign(1.0, wanted)
    room = max((limit - way * torque) / (stiffness * period) + max(way * (2 * turning - rate), 0.0), 0.0)
    return angle, way * min(abs(wanted), speed, room)
