"""Grasps that could be tried on a box or a round object at rest: from above and from the side, pinched or wrapped.

Frames: W with z up and the support at z = 0, O object, E hand (z out of the palm, x across fingers 1 and 2, finger 3 at +y), G = E when the
fingers close. What comes out is geometry only; whether it holds is for the simulation to say.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import product

import numpy as np

from vipr.systems import se3
from vipr.systems.errors import InputError
from vipr.systems.grasping.grasp import Grasp, Symmetry
from vipr.systems.hand import finger
from vipr.systems.hand.finger import GRASP_HEIGHT
from vipr.systems.tracking.cad_model import CadModel

LEAST_BASE = 0.2  # of the height: narrower ones are not stood on
OPENING = 0.018  # m that each finger stands off the object on the way: what the pose may be wrong by, and some
PALM_GAP = 0.010  # m between palm and object
FLOOR_GAP = 0.004  # m between hand and support
ROUND_SPREADS = (0.0, float(np.radians(15.0)))  # rad, tried from above on rounds
HEIGHTS = (0.5, 0.65)  # of the object's, of the hand at its side
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
    """The axes of O (3,) that can point up while the object rests, one of each set that its symmetry makes alike: of rounds z and x."""
    solid = Solid.of(model)
    size = solid.high - solid.low
    axes = (2, 0) if len(solid.rounds) else (2, 0, 1)
    return [np.eye(3)[a] for a in axes if min(np.delete(size, a)) >= LEAST_BASE * size[a]]


def resting_pose(solid: Solid, up: np.ndarray, yaw: float = 0.0) -> np.ndarray:
    """X_WO of the object at rest on z = 0 with ``up`` (3,), an axis of O, upwards; the middle of its box is over the origin."""
    R_WO = se3.exp_so3(np.array([0.0, 0.0, yaw])) @ _rotation_to_z(np.asarray(up, float))
    middle = R_WO @ (0.5 * (solid.low + solid.high))
    half = 0.5 * float(np.abs(R_WO[2]) @ (solid.high - solid.low))
    return se3.pose(R_WO, [-middle[0], -middle[1], half - middle[2]])


def candidates(solid: Solid, up: np.ndarray, mass_centre: np.ndarray | None = None) -> Iterator[Grasp]:
    """Grasps of the object resting with ``up`` (one of its ``rests``) upwards, those that the hand's fingers can reach around.

    From above fingers 1 and 2 go to either side of ``mass_centre`` (3,) in O, so that little turns the object in the hand; of its middle
    if that is not known.
    """
    X_WO = resting_pose(solid, up)
    size = np.abs(X_WO[:3, :3]) @ (solid.high - solid.low)
    upright_round = len(solid.rounds) > 0 and abs(up[2]) > 0.5
    aside = np.zeros(3) if mass_centre is None else X_WO[:3, :3] @ mass_centre + X_WO[:3, 3]
    above = ((name, _over(aside, size, X_WG), shape) for name, X_WG, shape in _from_above(solid, size, upright_round))
    for name, X_WG, shape in (*above, *_from_the_side(solid, size, upright_round)):
        yield Grasp(name=name, up=np.asarray(up, float), X_OG=se3.inverse(X_WO) @ X_WG, **shape)


def _over(aside: np.ndarray, size: np.ndarray, X_WG: np.ndarray) -> np.ndarray:
    """X_WG moved along the row of fingers 1 and 2 until ``aside`` (3,) is between them, as far as both stay on the object."""
    along = X_WG[:3, 0]
    room = max(0.5 * np.abs(along) @ size - finger.SPREAD_AXIS - finger.RADIUS, 0.0)
    return se3.pose(X_WG[:3, :3], X_WG[:3, 3] + np.clip(along @ aside, -room, room) * along)


def _from_above(solid: Solid, size: np.ndarray, round_: bool):
    """Pinches with the palm down: name, X_WG and the hand's shape; a round that lies is taken as a box is, across it."""
    crossings = {"y": [1.0, 0.0, 0.0]} if round_ else {"y": [1.0, 0.0, 0.0], "x": [0.0, 1.0, 0.0]}
    turns, spreads = (("",), ROUND_SPREADS) if round_ else (("", "turned "), (0.0,))
    lowest = size[2] - finger.RADIUS - FLOOR_GAP
    for (across, x_E), turn, spread in product(crossings.items(), turns, spreads):
        R_WG = _axes(np.array(x_E), np.array([0.0, 0.0, -1.0])) @ np.diag([-1.0, -1.0, 1.0] if turn else [1.0] * 3)
        for depth in dict.fromkeys(min(depth, lowest) for depth in DEPTHS):
            width = 2.0 * _radius_at(solid, size[2] - depth) if round_ else size[1 if across == "y" else 0]
            try:
                offset, reach, preshape = _fingers(width, spread, round_)
            except InputError:
                continue
            tips = finger.tip(finger.closing(reach))[1]
            p_WG = np.array([0.0, 0.0, size[2] - depth + tips - GRASP_HEIGHT]) - offset * R_WG[:, 1]
            if p_WG[2] + GRASP_HEIGHT - finger.PALM_HEIGHT < size[2] + PALM_GAP:
                continue
            name = f"above {across} {turn}{1e3 * depth:.0f} mm"
            name += f" spread {np.degrees(spread):.0f}" if spread else ""
            yield name, se3.pose(R_WG, p_WG), _shape(spread, preshape, PINCH, width)


def _from_the_side(solid: Solid, size: np.ndarray, round_: bool):
    """Pinches and wraps with the palm upright: name, X_WG and the hand's shape."""
    least = finger.PALM_RADIUS + FLOOR_GAP
    heights = [
        z for z in sorted({max(least, share * size[2]) for share in HEIGHTS}) if z + finger.SPREAD_AXIS <= size[2]
    ]
    for (along, axis), z in product([("x", 0)] if round_ else [("x", 0), ("y", 1)], heights):
        depth, width = (2.0 * _radius_at(solid, z),) * 2 if round_ else (size[axis], size[1 - axis])
        try:
            _, reach, preshape = _fingers(width, 0.0, False)
        except InputError:
            continue
        u = np.eye(3)[axis]
        tips = finger.tip(finger.closing(reach))[1]
        deepest = tips - finger.PALM_HEIGHT - PALM_GAP
        for (grip, torque, inside), turn in product(
            (("pinch", PINCH, min(0.5 * depth, deepest)), ("wrap", WRAP, deepest)), ("", " turned")
        ):
            R_WG = _axes(np.array([0.0, 0.0, 1.0]), u) @ np.diag([-1.0, -1.0, 1.0] if turn else [1.0] * 3)
            p_WG = -(0.5 * depth - inside + tips - GRASP_HEIGHT) * u + [0.0, 0.0, z]
            name = f"side {along} {1e3 * z:.0f} mm up {grip}{turn}"
            yield name, se3.pose(R_WG, p_WG), _shape(0.0, preshape, torque, width)


def _shape(spread: float, preshape: np.ndarray, torque: np.ndarray, width: float) -> dict:
    return {"spread": spread, "preshape": preshape, "torque": torque, "width": width}


def _fingers(width: float, spread: float, round_: bool) -> tuple[float, float, np.ndarray]:
    """Offset of the object's middle towards finger 3, reach of the tips that touch it [m], and the preshape (3,) [rad]."""
    offset, reach = finger.centring(0.5 * width, spread) if round_ else (0.0, 0.5 * width + finger.RADIUS)
    return offset, reach, np.full(3, finger.closing(reach + OPENING))


def _radius_at(solid: Solid, z: float) -> float:
    """Radius [m] of a standing round where it is widest within a fingertip of the height [m]."""
    near = [r for low, high, r in solid.rounds if low - finger.RADIUS <= z <= high + finger.RADIUS]
    return float(max(near)) if near else float(solid.rounds[:, 2].max())


_HALF_TURNS = {"x": [1.0, -1.0, -1.0], "y": [-1.0, 1.0, -1.0], "z": [-1.0, -1.0, 1.0]}


def _same(points: np.ndarray, others: np.ndarray) -> bool:
    """Whether two sets of points are one, to half a millimetre."""
    return bool((np.linalg.norm(points[:, None] - others[None], axis=2).min(1) < 5e-4).all())


def _axes(x: np.ndarray, z: np.ndarray) -> np.ndarray:
    return np.column_stack([x, np.cross(z, x), z])


def _rotation_to_z(up: np.ndarray) -> np.ndarray:
    """R_WO with ``up`` of O along z of W, by the shortest turn."""
    axis = np.cross(up, [0.0, 0.0, 1.0])
    sine = np.linalg.norm(axis)
    if sine < 1e-9:
        return np.eye(3) if up[2] > 0 else np.diag([1.0, -1.0, -1.0])
    return se3.exp_so3(axis / sine * np.arctan2(sine, up[2]))
