"""The Puma 560 in closed form: geometry, limits, drives, friction, and the eight solutions of its inverse kinematics.

Frames are those of the standard Denavit-Hartenberg convention, ``X_{i-1,i} = Rz(q_i) Tz(d_i) Tx(a_i) Rx(alpha_i)``: frame 0 is the bottom
of the pedestal, frame 6 the wrist centre, the flange face lies 56.25 mm along z6. Angles in rad, lengths in m, everything else SI.
The same figures are in ``models/puma560/puma560.sdf``; a test compares the two. Sources: ``models/puma560/README.md``.
"""

import numpy as np

from vipr.systems.arm.kinematics import SerialArm
from vipr.systems.errors import InputError
from vipr.systems.se3 import pose

D = np.array([0.67183, 0.0, 0.15005, 0.4318, 0.0, 0.0])  # m
A = np.array([0.0, 0.4318, 0.0203, 0.0, 0.0, 0.0])  # m
ALPHA = np.radians([90.0, 0.0, -90.0, 90.0, -90.0, 0.0])
FLANGE = 0.05625  # m, wrist centre to flange face along z6

POSITION_LOWER = np.radians([-160.0, -45.0, -225.0, -110.0, -100.0, -266.0])
POSITION_UPPER = np.radians([160.0, 225.0, 45.0, 170.0, 100.0, 266.0])
VELOCITY_LIMIT = np.array([1.92, 1.51, 2.40, 5.34, 5.09, 5.74])  # rad/s, where the motors saturate
EFFORT_LIMIT = np.array([97.6, 186.4, 89.4, 24.2, 20.1, 21.3])  # N m at the joint

GEAR_RATIO = np.array([-62.6111, 107.815, -53.7063, 76.0364, 71.923, 76.686])
ROTOR_INERTIA = np.array([200e-6, 200e-6, 200e-6, 33e-6, 33e-6, 33e-6])  # kg m2, at the motor
VISCOUS_FRICTION = np.array([1.48e-3, 0.817e-3, 1.38e-3, 71.2e-6, 82.6e-6, 36.7e-6])  # N m s/rad, at the motor
# N m at the motor: while the joint turns forwards, backwards.
COULOMB_FRICTION = np.array(
    [[0.395, -0.435], [0.126, -0.071], [0.132, -0.105], [11.2e-3, -16.9e-3], [9.26e-3, -14.5e-3], [3.96e-3, -10.5e-3]]
)
REFLECTED_INERTIA = GEAR_RATIO**2 * ROTOR_INERTIA  # kg m2, at the joint
DAMPING = GEAR_RATIO**2 * VISCOUS_FRICTION  # N m s/rad, at the joint

# Links 2 to 6, as published: mass, centre of mass and central moments of inertia (xx, yy, zz) in the link's frame. Link 1 counts by its
# moment about the joint axis alone (y of frame 1).
MASS = np.array([17.4, 4.8, 0.82, 0.34, 0.09])
COM = np.array([[-0.3638, 0.006, 0.2275], [-0.0203, -0.0141, 0.070], [0, -0.019, 0], [0, 0, 0], [0, 0, 0.032]])
INERTIA = np.array(
    [
        [0.13, 0.524, 0.539],
        [0.066, 0.086, 0.0125],
        [1.8e-3, 1.3e-3, 1.8e-3],
        [0.3e-3, 0.4e-3, 0.3e-3],
        [0.15e-3, 0.15e-3, 0.04e-3],
    ]
)
LINK_1_AXIAL_INERTIA = 0.35

NAMED = {
    "zero": np.zeros(6),
    "ready": np.array([0, np.pi / 2, -np.pi / 2, 0, 0, 0]),  # straight up
    "stretch": np.array([0, 0, -np.pi / 2, 0, 0, 0]),  # straight out
    "nominal": np.array([0, np.pi / 4, -np.pi, 0, np.pi / 4, 0]),  # dextrous, hand down
}

# left or right arm (the wrist behind or before the waist), elbow up or down, wrist not flipped (q5 <= 0) or flipped (q5 >= 0)
BRANCHES = ("lun", "luf", "ldn", "ldf", "run", "ruf", "rdn", "rdf")


WRIST = SerialArm(D, A, ALPHA)  # its tool frame is frame 6


def forward(q: np.ndarray) -> np.ndarray:
    """Pose X_06 (4, 4) of the wrist frame for joint angles q (6,)."""
    return WRIST.tool_pose(q)


def wrist_from_flange(X_0F: np.ndarray) -> np.ndarray:
    """X_06 that puts the flange frame at X_0F."""
    return X_0F @ pose(np.eye(3), [0, 0, -FLANGE])


def friction_torque(qd: np.ndarray) -> np.ndarray:
    """Torque (6,) [N m] that the joints take to turn at qd (6,) [rad/s]: viscous and Coulomb friction, seen at the joint."""
    return DAMPING * qd + coulomb_torque(qd)


def coulomb_torque(qd: np.ndarray) -> np.ndarray:
    """The Coulomb part of :func:`friction_torque`: zero at rest, different forwards and backwards."""
    qd = np.asarray(qd, float)
    forwards, backwards = np.abs(GEAR_RATIO)[:, None].T * COULOMB_FRICTION.T
    return np.where(qd > 0, forwards, np.where(qd < 0, backwards, 0.0))


def inverse(X_06: np.ndarray) -> dict[str, np.ndarray]:
    """All joint angles that reach X_06, by branch name, whether or not within the limits; empty where out of reach.

    Where the wrist is singular (q5 = 0) the turn is given to q6 and q4 is zero.
    """
    x, y, z = X_06[:3, 3] - [0, 0, D[0]]
    rho = np.hypot(x, y)
    forearm, bend = np.hypot(A[2], D[3]), np.arctan2(D[3], A[2])
    if rho < abs(D[2]):
        return {}
    along = np.sqrt(rho**2 - D[2] ** 2)
    cos_elbow = (along**2 + z**2 - A[1] ** 2 - forearm**2) / (2 * A[1] * forearm)
    if abs(cos_elbow) > 1 + 1e-12:
        return {}
    elbow = np.arccos(np.clip(cos_elbow, -1, 1))
    solutions = {}
    for arm, side in (("l", -1), ("r", 1)):
        offset = np.arctan2(D[2], along)
        q1 = np.arctan2(y, x) + (offset if arm == "r" else np.pi - offset)
        for height, sign in (("u", -side), ("d", side)):
            q3 = sign * elbow - bend
            q2 = np.arctan2(z, side * along) - np.arctan2(
                forearm * np.sin(sign * elbow), A[1] + forearm * np.cos(sign * elbow)
            )
            R_36 = _elbow_rotation(q1, q2 + q3).T @ X_06[:3, :3]
            s5 = np.hypot(R_36[0, 2], R_36[1, 2])
            for flip, sign5 in (("n", -1), ("f", 1)):
                if s5 > 1e-12:
                    q4 = np.arctan2(-sign5 * R_36[1, 2], -sign5 * R_36[0, 2])
                    q6 = np.arctan2(-sign5 * R_36[2, 1], sign5 * R_36[2, 0])
                else:
                    q4, q6 = 0.0, np.arctan2(R_36[1, 0], R_36[0, 0])
                q = np.array([q1, q2, q3, q4, sign5 * np.arctan2(s5, R_36[2, 2]), q6])
                solutions[arm + height + flip] = (q + np.pi) % (2 * np.pi) - np.pi
    return solutions


def _elbow_rotation(q1: float, q23: float) -> np.ndarray:
    """R_03: the forearm's frame depends on q1 and q2 + q3."""
    c1, s1, c, s = np.cos(q1), np.sin(q1), np.cos(q23), np.sin(q23)
    return np.array([[c1 * c, -s1, -c1 * s], [s1 * c, c1, -s1 * s], [s, 0, c]])


def inverse_near(X_06: np.ndarray, q_near: np.ndarray, margin: float = 0.0) -> np.ndarray:
    """The solution within the joint limits that lies closest to q_near (6,): smallest largest joint displacement.

    Turns of 2 pi count as different solutions where the range allows them. margin [rad] narrows every range at both ends. Raises
    InputError when no solution reaches the pose within the limits.
    """
    best, best_distance = None, np.inf
    for q in inverse(X_06).values():
        q = nearest_turn(q, q_near, margin)
        distance = np.max(np.abs(q - q_near))
        if distance < best_distance:
            best, best_distance = q, distance
    if best is None or not np.isfinite(best_distance):
        p = ", ".join(f"{1e3 * v:.0f}" for v in X_06[:3, 3])
        raise InputError(f"Puma 560: wrist pose at ({p}) mm from the base is out of reach within the joint limits")
    return best


def nearest_turn(q: np.ndarray, q_near: np.ndarray, margin: float = 0.0) -> np.ndarray:
    """Joint angles q (6,) plus the turns of 2 pi that bring each closest to q_near within its limits; NaN where no turn does."""
    turns = q[:, None] + 2 * np.pi * np.arange(-2, 3)
    allowed = (turns >= POSITION_LOWER[:, None] + margin) & (turns <= POSITION_UPPER[:, None] - margin)
    distance = np.where(allowed, np.abs(turns - q_near[:, None]), np.inf)
    choice = np.argmin(distance, axis=1)
    rows = np.arange(6)
    return np.where(np.isfinite(distance[rows, choice]), turns[rows, choice], np.nan)
