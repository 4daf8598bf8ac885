"""The bodies of the Puma 560 and the Barrett Hand as convex shapes, for clearance. A test compares them with ``models/``.

What the models give no collision shape (the knuckles that carry fingers 1 and 2) is covered by a capsule here.
"""

from functools import lru_cache

import numpy as np

from vipr.systems import se3
from vipr.systems.arm.collision import ArmBody
from vipr.systems.arm.guard import CollisionGuard
from vipr.systems.arm.kinematics import SerialArm
from vipr.systems.arm.puma560 import FLANGE
from vipr.systems.arm.shapes import Shape, box, capsule, cylinder, sphere
from vipr.systems.errors import InputError
from vipr.systems.hand.transmission import JOINT_UPPER, JOINTS, MOTOR_UPPER, SEATED, joint_angles

OPEN = np.zeros(8)  # rad, the hand's joints with fingers open and spread 0
X_6P = se3.pose(np.eye(3), [0.0, 0.0, FLANGE])  # the hand's palm frame P on the flange
HAND_EXTENT = FLANGE + 0.34  # m, from the wrist centre: both knuckle offsets and both finger links in one line
FINGER_STEP = 0.02  # rad
STOP_PLAY = 0.05  # rad, by which a soft joint may stand beyond its stop

_SPREAD_AXES = {1: -0.025, 2: 0.025}  # m, along x of P; finger 1 spreads about -z, finger 2 about z
_KNUCKLE_HEIGHT, _KNUCKLE_LENGTH = 0.0754, 0.05  # m
_DISTAL = np.array([0.06994, 0.003, 0.0])  # m, joint 3 in the inner link
_BEND = np.radians(45.0)  # of the outer link at rest


def puma_shapes() -> tuple[tuple[int, Shape], ...]:
    """(link, shape) of the arm alone, each in its link's Denavit-Hartenberg frame."""
    return (
        (0, cylinder("column", 0.095, 0.58, _at(0, 0, 0.29))),
        (1, cylinder("trunk", 0.088, 0.30, _at(0, 0, 0.03))),
        (2, box("upper_arm", (0.66, 0.17, 0.095), _at(-0.25, 0, 0.2375))),
        (3, box("forearm", (0.12, 0.082, 0.40), _at(-0.0203, 0, 0.155))),
        (5, sphere("wrist", 0.045, (0, 0, 0))),
        (6, cylinder("flange", 0.032, 0.026, _at(0, 0, 0.043))),
    )


def hand_shapes(joints: np.ndarray = OPEN) -> tuple[Shape, ...]:
    """The hand's shapes in its palm frame P for joint angles (8,) [rad] in the order of ``transmission.JOINTS``."""
    joints = np.asarray(joints, float)
    if joints.shape != (8,) or not np.isfinite(joints).all():
        raise InputError(f"hand: needs the angles of its 8 joints ({', '.join(JOINTS)}), got {joints.tolist()}")
    outside = (joints < -STOP_PLAY) | (joints > JOINT_UPPER + STOP_PLAY)
    if outside.any():
        k = int(np.argmax(outside))
        raise InputError(
            f"hand: {JOINTS[k]} is at {np.rad2deg(joints[k]):.1f} deg, allowed are 0 to {np.rad2deg(JOINT_UPPER[k]):.0f} deg"
        )
    q = dict(zip(JOINTS, joints, strict=True))
    shapes = [cylinder("palm", 0.0445, 0.08, _at(0, 0, 0.04))]
    for k in (1, 2, 3):
        if k == 3:
            X_PI = se3.pose(_rz(np.pi / 2) @ _rx(np.pi / 2), [0.0, _KNUCKLE_LENGTH, _KNUCKLE_HEIGHT])
        else:
            turn = np.sign(_SPREAD_AXES[k]) * q[f"finger_{k}_spread"] - np.pi / 2
            X_PK = se3.pose(_rz(turn), [_SPREAD_AXES[k], 0.0, _KNUCKLE_HEIGHT])
            middle = se3.pose(_ry(np.pi / 2), [0.5 * _KNUCKLE_LENGTH, 0.0, -0.0113])
            shapes.append(capsule(f"finger_{k}_knuckle", 0.0135, _KNUCKLE_LENGTH, X_PK @ middle))
            X_PI = X_PK @ se3.pose(_rx(np.pi / 2), [_KNUCKLE_LENGTH, 0.0, 0.0])
        X_PI = X_PI @ se3.pose(_rz(q[f"finger_{k}_proximal"]), np.zeros(3))
        X_PO = X_PI @ se3.pose(_rz(_BEND + q[f"finger_{k}_distal"]), _DISTAL)
        along = np.radians(2.456)  # from one joint to the next
        inner = se3.pose(_rz(along) @ _ry(np.pi / 2), [0.038, 0.0016, 0.0])
        shapes.append(capsule(f"finger_{k}_inner", 0.0095, 0.046, X_PI @ inner))
        shapes.append(capsule(f"finger_{k}_outer", 0.0095, 0.0416, X_PO @ se3.pose(_ry(np.pi / 2), [0.0288, 0.0, 0.0])))
    return tuple(shapes)


def puma_with_hand_body(arm: SerialArm, hand: np.ndarray = OPEN, held: tuple[Shape, ...] = ()) -> ArmBody:
    """The Puma with the Barrett Hand at its flange.

    Args:
        arm: the Puma's kinematics.
        hand: the hand's joint angles (8,) [rad].
        held: what the hand holds, in the palm frame P: it moves with the hand and is kept off obstacles and arm like the hand itself.
    """
    carried = tuple(shape.moved(X_6P) for shape in (*hand_shapes(hand), *held))
    links, shapes = zip(*puma_shapes(), *((6, shape) for shape in carried), strict=True)
    return ArmBody(arm, shapes, links, ignored=((2, 0), (5, 3)))


def hand_guard(
    arm: SerialArm, obstacles: tuple[Shape, ...], hand: np.ndarray = OPEN, held: tuple[Shape, ...] = ()
) -> CollisionGuard:
    """The guard of the Puma with the Barrett Hand, which follows the hand's motors where they are told.

    Clutches count as seated. Fingers are placed in steps of ``FINGER_STEP``.
    """

    @lru_cache(maxsize=512)
    def body(steps: tuple[int, ...]) -> ArmBody:
        motor = np.clip(FINGER_STEP * np.array(steps), 0.0, MOTOR_UPPER)
        return puma_with_hand_body(arm, joint_angles(motor, SEATED), held)

    def with_hand(motor: np.ndarray) -> ArmBody:
        return body(tuple(int(step) for step in np.round(np.asarray(motor) / FINGER_STEP)))

    return CollisionGuard(puma_with_hand_body(arm, hand, held), obstacles, with_hand=with_hand, hand_extent=HAND_EXTENT)


def _at(x: float, y: float, z: float) -> np.ndarray:
    return se3.pose(np.eye(3), [x, y, z])


def _rx(angle: float) -> np.ndarray:
    return se3.exp_so3(np.array([angle, 0.0, 0.0]))


def _ry(angle: float) -> np.ndarray:
    return se3.exp_so3(np.array([0.0, angle, 0.0]))


def _rz(angle: float) -> np.ndarray:
    return se3.exp_so3(np.array([0.0, 0.0, angle]))
