"""From an estimated pose to a grasp and its whole motion: reference point, approach, lift, carry; checked before anything moves.

Frames: W world = the arm's base, O object, E hand, G = E when the fingers close, 6 the wrist. A plan keeps within the joint limits, away
from singularities of the wrist, and clear of what stands around (paper III-E: reference points from which the grasp is begun).
"""

from collections import Counter
from dataclasses import dataclass, replace

import numpy as np

from vipr.systems import se3
from vipr.systems.arm import puma560
from vipr.systems.arm.collision import ArmBody
from vipr.systems.arm.joint_path import JointPath, joint_path
from vipr.systems.arm.kinematics import SerialArm
from vipr.systems.arm.puma_body import X_6P, puma_with_hand_body
from vipr.systems.arm.resolved_rate import JointLimits
from vipr.systems.arm.shapes import Shape, box
from vipr.systems.errors import InputError
from vipr.systems.grasping.grasp import Grasp, GraspTable
from vipr.systems.grasping.options import suitable
from vipr.systems.grasping.support import Support
from vipr.systems.hand import transmission

MARGIN = np.radians(3.0)  # kept from every joint's stop
WRIST_MARGIN = 0.10  # rad, kept from the wrist's singularity
LEAST_CLEARANCE = 0.004  # m, between arm or hand and what they must not touch
CLOSED_CLEARANCE = 0.002  # m, of the fingers where they have closed: they feel what they meet
STEP = 0.03  # m between the points of a straight line
LARGEST_TURN = 0.35  # rad of one joint between them
RAISE = 0.12  # m, of the way around by above
BACK_OFF = 0.004  # m back from where a finger has met something
REACH_SPEED = 0.4  # m/s, of the hand on the way to the reference point
REACH_CLEARANCE = 0.010  # m, on that way
REACH_STEP = 0.05  # s between the places of it that are looked at


@dataclass(frozen=True, eq=False)
class Surroundings:
    """The arm, its limits, and what it must not touch."""

    arm: SerialArm
    limits: JointLimits
    obstacles: tuple[Shape, ...] = ()  # in W
    support: Support | None = None  # what the object rests on, and its box


@dataclass(frozen=True)
class Errand:
    """What shall be done with the object once it is held."""

    lift: float = 0.15  # m, up
    carry: float = 0.30  # m, sideways
    # deg from x of W: which way; the one that ends nearer the arm's middle comes first.
    ways: tuple[float, ...] = (90.0, -90.0)
    speed: float = 0.3  # m/s
    approach_speed: float = 0.2  # m/s


@dataclass(frozen=True, eq=False)
class Plan:
    """A grasp and the paths that carry it out."""

    grasp: Grasp
    X_WG: np.ndarray
    reach: JointPath  # to the reference point
    approach: JointPath
    lift: JointPath
    carry: JointPath
    clearance: float  # m, the least on all of it

    def __deepcopy__(self, memo):
        return self  # immutable

    def stopped(self, q: np.ndarray, arm: SerialArm) -> "Plan":
        """The plan with an approach that ends ``BACK_OFF`` before the hand is where it is at q (6,), and the rest from there."""
        shares = np.linspace(0.0, 1.0, 101)
        points = np.array([arm.tool_pose(point)[:3, 3] for point in self.approach.curve(shares)])
        gone = np.linalg.norm(points - points[0], axis=1)
        here = float(np.linalg.norm(arm.tool_pose(q)[:3, 3] - points[0]))
        approach = self.approach.part(float(np.interp(here - BACK_OFF, gone, shares)))
        aside = approach.end - self.approach.end
        return replace(self, approach=approach, lift=self.lift.shifted(aside), carry=self.carry.shifted(aside))

    def short(self, arm: SerialArm) -> float:
        """How far from the grasp its approach ends [m]."""
        return float(np.linalg.norm(arm.tool_pose(self.approach.end)[:3, 3] - self.X_WG[:3, 3]))


def plan_grasp(
    table: GraspTable,
    X_WO: np.ndarray,
    q_now: np.ndarray,
    around: Surroundings,
    errand: Errand = Errand(),
    hand_now: np.ndarray = np.zeros(4),
    tried: tuple[str, ...] = (),
) -> Plan:
    """The best grasp that can be carried out from q_now (6,) with the hand's motors at ``hand_now`` (4,), but none of the ``tried`` names.

    Raises:
        InputError: saying what stands against every grasp.
    """
    options = [grasp for grasp in suitable(table, X_WO) if grasp.name not in tried]
    if not options:
        up = X_WO[:3, :3].T @ [0.0, 0.0, 1.0]
        raise InputError(
            f"grasp of {table.object}: no {'other ' if tried else ''}grasp is known for an object that lies like this "
            f"(up is ({up[0]:.2f}, {up[1]:.2f}, {up[2]:.2f}) of its frame)"
        )
    against: Counter[str] = Counter()
    for grasp in options:
        found = _plan(grasp, X_WO, np.asarray(q_now, float), around, errand, hand_now)
        if isinstance(found, Plan):
            return found
        against[found] += 1
    reasons = ", ".join(f"{count} {reason}" for reason, count in against.most_common(3))
    p = ", ".join(f"{1e3 * v:.0f}" for v in X_WO[:3, 3])
    raise InputError(
        f"grasp of {table.object} at ({p}) mm: of {len(options)} ways to grasp it none can be done: {reasons}"
    )


def _plan(grasp: Grasp, X_WO, q_now, around: Surroundings, errand: Errand, hand_now) -> Plan | str:
    """The plan for one grasp, or why there is none."""
    X_WG = X_WO @ grasp.X_OG
    X_WR = X_WG @ se3.pose(np.eye(3), [0.0, 0.0, -grasp.approach])
    reason = "out of reach"
    for q_ref in _arrivals(X_WR, q_now, around.arm):
        down = _line(X_WR, X_WG, q_ref, around.arm)
        if down is None:
            continue
        X_WL = _shifted(X_WG, [0.0, 0.0, errand.lift])
        up = _line(X_WG, X_WL, down[-1], around.arm)
        if up is None:
            continue
        away = _carry(X_WL, up[-1], around.arm, errand)
        if away is None:
            continue
        reason = "too close to something"
        open_hand = _hand(grasp, grasp.preshape)
        clearances = [_clearance(around, open_hand, down), _clearance(around, _hand(grasp, grasp.closed), up)]
        if clearances[0] < LEAST_CLEARANCE or clearances[1] < CLOSED_CLEARANCE:
            continue
        held = _object_shape(around, X_WO)
        X_WP = around.arm.tool_pose(down[-1]) @ se3.inverse(around.arm.X_6E) @ X_6P
        in_hand = () if held is None else (held.moved(se3.inverse(X_WP)),)
        clearances.append(_clearance(around, _hand(grasp, grasp.closed), away, carried=in_hand))
        before = transmission.joint_angles(hand_now, transmission.SEATED)
        hands = (np.clip(before, 0.0, transmission.JOINT_UPPER), open_hand)
        reach = _reach(q_now, q_ref, X_WR, around, hands, () if held is None else (held,))
        if clearances[-1] < LEAST_CLEARANCE or reach is None:
            continue
        lengths = (grasp.approach, errand.lift, errand.carry)
        paths = [
            joint_path(points, around.limits, length, errand.approach_speed if i == 0 else errand.speed)
            for i, (points, length) in enumerate(zip((down, up, away), lengths, strict=True))
        ]
        return Plan(grasp, X_WG, reach[0], *paths, clearance=min(*clearances, reach[1]))
    return reason


def _arrivals(X_WE: np.ndarray, q_now: np.ndarray, arm: SerialArm) -> list[np.ndarray]:
    """Joint angles (6,) within the limits that put the hand at X_WE, the nearest first."""
    branches = puma560.inverse(X_WE @ se3.inverse(arm.X_6E)).values()
    turned = [puma560.nearest_turn(q, q_now, MARGIN) for q in branches]
    good = [q for q in turned if np.isfinite(q).all() and abs(q[4]) > WRIST_MARGIN]
    return sorted(good, key=lambda q: float(np.abs(q - q_now).max()))


def _line(X_WA: np.ndarray, X_WB: np.ndarray, q: np.ndarray, arm: SerialArm) -> np.ndarray | None:
    """Joint angles (m, 6) along the straight line from A to B, both of one orientation, on one branch; None where there is none."""
    count = max(2, int(np.ceil(np.linalg.norm(X_WB[:3, 3] - X_WA[:3, 3]) / STEP)))
    points = [q]
    for share in np.arange(1, count + 1) / count:
        X = se3.pose(X_WA[:3, :3], (1.0 - share) * X_WA[:3, 3] + share * X_WB[:3, 3])
        try:
            q = puma560.inverse_near(X @ se3.inverse(arm.X_6E), points[-1], MARGIN)
        except InputError:
            return None
        if np.abs(q - points[-1]).max() > LARGEST_TURN or abs(q[4]) < WRIST_MARGIN:
            return None
        points.append(q)
    return np.array(points)


def _carry(X_WL: np.ndarray, q: np.ndarray, arm: SerialArm, errand: Errand) -> np.ndarray | None:
    """The way sideways, in the first of the errand's directions that can be gone."""
    angles = np.radians(errand.ways)
    ends = [_shifted(X_WL, errand.carry * np.array([np.cos(angle), np.sin(angle), 0.0])) for angle in angles]
    for X_WN in sorted(ends, key=lambda X: abs(X[1, 3])):
        points = _line(X_WL, X_WN, q, arm)
        if points is not None:
            return points
    return None


def _reach(q_now, q_ref, X_WR, around: Surroundings, hands, objects) -> tuple[JointPath, float] | None:
    """A free path through joint space to the reference point, straight or around by above, and its clearance [m]."""
    X_WE, vias = around.arm.tool_pose(q_now), []
    for X_WV, near in ((_shifted(X_WR, [0.0, 0.0, RAISE]), q_ref), (_shifted(X_WE, [0.0, 0.0, RAISE]), q_now)):
        try:
            vias.append(puma560.inverse_near(X_WV @ se3.inverse(around.arm.X_6E), near, MARGIN))
        except InputError:
            continue
    length = float(np.linalg.norm(X_WR[:3, 3] - X_WE[:3, 3]))
    for between in ([], *([via] for via in vias), vias[::-1]):
        path = joint_path(np.array([q_now, *between, q_ref]), around.limits, length, REACH_SPEED)
        walked = path.curve(np.linspace(0.0, 1.0, int(np.ceil(path.duration / REACH_STEP)) + 1))
        if not ((walked > around.limits.lower) & (walked < around.limits.upper)).all():
            continue
        # Where it starts is where it is: only the way counts.
        clearance = min(_clearance(around, hand, walked[1:], objects) for hand in hands)
        if clearance >= REACH_CLEARANCE:
            return path, clearance
    return None


def free_path(q_now: np.ndarray, q_goal: np.ndarray, around: Surroundings, hand_now: np.ndarray) -> JointPath:
    """A path from q_now to q_goal (6,) for the hand with its motors at hand_now (4,); InputError if none is found."""
    hand = transmission.joint_angles(hand_now, transmission.SEATED)
    found = _reach(
        q_now, q_goal, around.arm.tool_pose(q_goal), around, (np.clip(hand, 0.0, transmission.JOINT_UPPER),), ()
    )
    if found is None:
        raise InputError("arm: no free way back was found")
    return found[0]


def _clearance(around: Surroundings, hand: np.ndarray, points: np.ndarray, objects=(), carried=()) -> float:
    """The least gap [m] of arm and hand, with what it carries, to the surroundings at joint angles (m, 6)."""
    body: ArmBody = puma_with_hand_body(around.arm, hand, carried)
    return float(np.min(body.clearance(points, (*around.obstacles, *objects))[0]))


def _hand(grasp: Grasp, fingers: np.ndarray) -> np.ndarray:
    """The hand's joint angles (8,) with the grasp's spread; where clutches let go the inner links are as far as the motors."""
    q = transmission.joint_angles(np.append(fingers, grasp.spread), transmission.SEATED)
    return np.clip(q, 0.0, transmission.JOINT_UPPER)


def _object_shape(around: Surroundings, X_WO: np.ndarray) -> Shape | None:
    """The object's box in W."""
    if around.support is None:
        return None
    low, high = around.support.low, around.support.high
    size, middle = high - low, 0.5 * (low + high)
    return box("object", tuple(size), X_WO @ se3.pose(np.eye(3), middle))


def _shifted(X: np.ndarray, shift) -> np.ndarray:
    return se3.pose(X[:3, :3], X[:3, 3] + shift)
