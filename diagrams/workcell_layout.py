"""What stands where in the workcell, the arm in it, and its limits: what the robot knows before it looks."""

import numpy as np

from vipr.systems import se3
from vipr.systems.arm import puma560
from vipr.systems.arm.guard import CollisionGuard
from vipr.systems.arm.kinematics import SerialArm
from vipr.systems.arm.puma_body import hand_guard
from vipr.systems.arm.resolved_rate import JointLimits
from vipr.systems.arm.shapes import Shape, box, cylinder
from vipr.systems.hand.finger import GRASP_HEIGHT

STAGE = np.array([0.55, 0.0, 0.52])  # m, middle of the stage's plate at its zero
STAGE_TRAVEL = np.array([0.20, 0.15, np.pi])  # m, m, rad: each way

# rad/s^2, of the set-points. All joints at once at these and at the servo's speeds take 53 % of a joint's effort limit at most, anywhere.
ACCELERATION = np.array([5.0, 5.0, 7.5, 15.0, 15.0, 15.0])
JOINT_LIMITS = JointLimits(puma560.POSITION_LOWER, puma560.POSITION_UPPER, puma560.VELOCITY_LIMIT, ACCELERATION)


def fixed_camera(distance: float = 2.0) -> np.ndarray:
    """X_WC of the camera on its tripod: before the stage, to its right, looking a little down, at the given distance [m]."""
    target, direction = STAGE + [0, 0, 0.16], np.array([0.80, -0.50, 0.33])
    z = -direction / np.linalg.norm(direction)
    x = np.cross(z, [0.0, 0.0, 1.0])
    x /= np.linalg.norm(x)
    return se3.pose(np.column_stack([x, np.cross(z, x), z]), target - distance * z)


def puma_with_hand() -> SerialArm:
    """The arm's kinematics with the hand's grasp centre as tool E."""
    X_6E = se3.pose(np.eye(3), [0.0, 0.0, puma560.FLANGE + GRASP_HEIGHT])
    return SerialArm(puma560.D, puma560.A, puma560.ALPHA, X_6E)


def obstacles(stage: np.ndarray | None = None) -> tuple[Shape, ...]:
    """What the arm must not touch, in W: floor, table, and the stage with its plate at x, y [m], yaw [rad].

    Without ``stage`` the plate counts as wherever it can go. A test compares the shapes with ``models/``.
    """
    if stage is None:
        plate = box("stage", (0.58, 0.48, 0.02), se3.pose(np.eye(3), STAGE - [0, 0, 0.01]))
    else:
        plate = cylinder("stage", 0.09, 0.008, se3.pose(np.eye(3), STAGE + [stage[0], stage[1], -0.004]))
    return (
        box("floor", (5.8, 5.2, 0.1), se3.pose(np.eye(3), [1.3, 0.0, -0.05])),
        box("table", (0.8, 1.2, 0.03), se3.pose(np.eye(3), [0.75, 0.0, 0.485])),
        box("stage_foot", (0.48, 0.36, 0.012), se3.pose(np.eye(3), STAGE - [0, 0, 0.014])),
        plate,
    )


def collision_guard(held: tuple[Shape, ...] = ()) -> CollisionGuard:
    """Keeps arm and hand from the workcell and from themselves."""
    return hand_guard(puma_with_hand(), obstacles(), held=held)


def standing(stage: np.ndarray) -> np.ndarray:
    """X_WO of an object that stands in the middle of the plate of the stage at x, y [m], yaw [rad]."""
    return se3.pose(se3.exp_so3(np.array([0.0, 0.0, stage[2]])), STAGE + [stage[0], stage[1], 0.0])
