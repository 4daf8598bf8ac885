"""Grasps that could be tried on a box or a round object at rest: from above and from the side, pinched or wrapped.

Frames: W with z up and the support at z = 0, O object, E hand (z out of the palm, x across fingers 1 and 2, finger 3 at +y), G = E when the
fingers close. What comes out is geometry only; whether it holds is for the simulation to say.
"""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from vipr.systems import se3
from vipr.systems.errors import InputError
from vipr.systems.grasping.grasp import Grasp, Symmetry
from vipr.systems.hand import finger
from vipr.systems.tracking.cad_model import CadModel

GRASP_HEIGHT = 0.135  # m, of E above the mounting face
LEAST_BASE = 0.2  # of the height: narrower ones are not stood on
OPENING = 0.018  # m that each finger stands off the object on the way: what the pose may be wrong by, and some
PALM_GAP = 0.010  # m between palm and object
FLOOR_GAP = 0.004  # m between hand and support
DEPTHS = (0.035, 0.065)  # m of the tips below the top
PINCH = np.array([1.0, 1.0, 1.8])  # N m: finger 3 stands against two, and the clutches stay seated
WRAP = np.array([1.8, 1.8, 1.8])  # the clutches let go, the outer links wrap around


@dataclass(frozen=True, eq=False)
class Solid:
    """A model's shape as the hand sees it: a box, or rounds on one axis."""

    low: np.ndarray  # (3,) in O
    high: np.ndarray  # (3,) in O
    rounds: np.ndarray  # (K, 3) from z, to z, radius; empty for a box

    @staticmethod
    def of(model: CadModel) -> "Solid":
        rounds = np.array([[c[2], c[5], c[6]] for c in model.cylinders]).reshape(-1, 3)
        return Solid(model.corners.min(0), model.corners.max(0), rounds)


def symmetry(model: CadModel) -> Symmetry:
    """The turns that leave the model's shape as it is."""
    solid = Solid.of(model)
    points = np.concatenate([solid.rounds[:, [0, 2]], solid.rounds[:, [1, 2]]]) if len(solid.rounds) else model.vertices
    centre = 0.5 * (solid.low + solid.high)
    if len(solid.rounds):
        mirrored = points * [-1.0, 1.0] + [2.0 * centre[2], 0.0]
        return Symmetry(centre, "x" if _same(points, mirrored) else "", True)
    turned = {axis: (points - centre) * signs + centre for axis, signs in _HALF_TURNS.items()}
    return Symmetry(centre, "".join(axis for axis, other in turned.items() if _same(points, other)), False)


def rests(model: CadModel) -> list[np.ndarray]:
    """The axes of O (3,) that can point up while the object rests, one of each set that its symmetry makes alike.

    A lying round is not among them: it rolls away.
    """
    solid = Solid.of(model)
    size = solid.high - solid.low
    axes = (2,) if len(solid.rounds) else (2, 0, 1)
    return [np.eye(3)[a] for a in axes if min(np.delete(size, a)) >= LEAST_BASE * size[a]]


def resting_pose(solid: Solid, up: np.ndarray, yaw: float = 0.0) -> np.ndarray:
    """X_WO of the object at rest on z = 0 with ``up`` (3,), an axis of O, upwards; the middle of its box is over the origin."""
    R_WO = se3.exp_so3(np.array([0.0, 0.0, yaw])) @ _rotation_to_z(np.asarray(up, float))
    corners = np.array([[x, y, z] for x in _ends(solid, 0) for y in _ends(solid, 1) for z in _ends(solid, 2)]) @ R_WO.T
    low, high = corners.min(0), corners.max(0)
    middle = R_WO @ (0.5 * (solid.low + solid.high))
    return se3.pose(R_WO, [-middle[0], -middle[1], -low[2]]) if high[2] > low[2] else se3.pose(R_WO, np.zeros(3))


def candidates(solid: Solid, up: np.ndarray) -> Iterator[Grasp]:
    """Grasps of the object resting with ``up`` upwards, those the hand's fingers can reach around."""
    X_WO = resting_pose(solid, up)
    R_WO = X_WO[:3, :3]
    size = np.abs(R_WO) @ (solid.high - solid.low)
    lying_round = len(solid.rounds) and abs(up[2]) < 0.5
    for maker in (_from_above, _from_the_side):
        for name, X_WG, shape in maker(solid, size, X_WO, bool(lying_round)):
            yield Grasp(name=name, up=np.asarray(up, float), X_OG=se3.inverse(X_WO) @ X_WG, **shape)


def _from_above(solid, size, X_WO, lying_round):
    standing_round = len(solid.rounds) and not lying_round
    crossings = [("y", [1.0, 0.0, 0.0])] if standing_round else [("y", [1.0, 0.0, 0.0]), ("x", [0.0, 1.0, 0.0])]
    for label, x_E in crossings:
        R = _axes(np.array(x_E), np.array([0.0, 0.0, -1.0]))
        for flip in (False, True) if not standing_round else (False,):
            for spread in (0.0, np.radians(15.0)) if standing_round else (0.0,):
                for depth in DEPTHS:
                    depth = min(depth, size[2] - finger.RADIUS - FLOOR_GAP)
                    width = size[1] if label == "y" else size[0]
                    if standing_round:
                        width = 2.0 * _radius_at(solid, size[2] - depth, X_WO[2, 2] > 0)
                    try:
                        offset, reach, preshape = _fingers(width, spread, bool(standing_round))
                    except InputError:
                        continue
                    height = finger.tip(finger.closing(reach))[1]
                    R_flip = R @ np.diag([-1.0, -1.0, 1.0]) if flip else R
                    p = np.array([0.0, 0.0, size[2] - depth + height - GRASP_HEIGHT]) - offset * R_flip[:, 1]
                    if p[2] + GRASP_HEIGHT - finger.PALM_HEIGHT < size[2] + PALM_GAP:
                        continue
                    name = f"above {label} {'turned ' if flip else ''}{1e3 * depth:.0f} mm"
                    name += f" spread {np.degrees(spread):.0f}" if spread else ""
                    shape = {"spread": spread, "preshape": preshape, "torque": PINCH, "width": width}
                    yield name, se3.pose(R_flip, p), shape
                    if depth < DEPTHS[0]:
                        break


def _from_the_side(solid, size, X_WO, lying_round):
    standing_round = len(solid.rounds) and not lying_round
    least = finger.PALM_RADIUS + FLOOR_GAP
    heights = sorted({max(least, share * size[2]) for share in (0.5, 0.65)})
    for label, u, depth, width in (
        ("x", np.array([1.0, 0.0, 0.0]), size[0], size[1]),
        ("y", np.array([0.0, 1.0, 0.0]), size[1], size[0]),
    ):
        if label == "y" and standing_round:
            continue
        for z in heights:
            if z + finger.SPREAD_AXIS > size[2]:
                continue
            if standing_round:
                width = depth = 2.0 * _radius_at(solid, z, X_WO[2, 2] > 0)
            try:
                _, reach, preshape = _fingers(width, 0.0, False)
            except InputError:
                continue
            tips = finger.tip(finger.closing(reach))[1]
            R = _axes(np.array([0.0, 0.0, 1.0]), u)
            deepest = tips - finger.PALM_HEIGHT - PALM_GAP
            for grip, torque, inside in (("pinch", PINCH, 0.5 * depth), ("wrap", WRAP, deepest)):
                inside = min(inside, deepest)
                p = -(0.5 * depth - inside + tips - GRASP_HEIGHT) * u + [0.0, 0.0, z]
                for way in (1.0, -1.0):
                    R_way = R @ np.diag([way, way, 1.0])
                    shape = {"spread": 0.0, "preshape": preshape, "torque": torque, "width": width}
                    turned = "" if way > 0 else " turned"
                    yield f"side {label} {1e3 * z:.0f} mm up {grip}{turned}", se3.pose(R_way, p), shape


def _fingers(width: float, spread: float, round_: bool) -> tuple[float, float, np.ndarray]:
    """Offset of the object's middle towards finger 3, reach of the tips that touch it [m], and the preshape (3,) [rad]."""
    offset, reach = finger.centring(0.5 * width, spread) if round_ else (0.0, 0.5 * width + finger.RADIUS)
    return offset, reach, np.full(3, finger.closing(reach + OPENING))


def _radius_at(solid: Solid, height: float, upright: bool) -> float:
    """Radius [m] of a standing round where it is widest within a fingertip of the height [m]."""
    z = height if upright else solid.high[2] - height
    near = [r for low, high, r in solid.rounds if low - finger.RADIUS <= z <= high + finger.RADIUS]
    return float(max(near)) if near else float(solid.rounds[:, 2].max())


_HALF_TURNS = {"x": [1.0, -1.0, -1.0], "y": [-1.0, 1.0, -1.0], "z": [-1.0, -1.0, 1.0]}


def _same(points: np.ndarray, others: np.ndarray) -> bool:
    """Whether two sets of points are one, to half a millimetre."""
    return bool((np.linalg.norm(points[:, None] - others[None], axis=2).min(1) < 5e-4).all())


def _ends(solid: Solid, axis: int) -> tuple[float, float]:
    return float(solid.low[axis]), float(solid.high[axis])


def _axes(x: np.ndarray, z: np.ndarray) -> np.ndarray:
    return np.column_stack([x, np.cross(z, x), z])


def _rotation_to_z(up: np.ndarray) -> np.ndarray:
    """R_WO with ``up`` of O along z of W, by the shortest turn."""
    axis = np.cross(up, [0.0, 0.0, 1.0])
    sine = np.linalg.norm(axis)
    if sine < 1e-9:
        return np.eye(3) if up[2] > 0 else np.diag([1.0, -1.0, -1.0])
    return se3.exp_so3(axis / sine * np.arctan2(sine, up[2]))
