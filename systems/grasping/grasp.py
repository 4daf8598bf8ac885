"""A grasp as data: where the hand goes relative to the object, how it is shaped, how hard it closes; and the tables of them.

Frames: O object, W world (z up), E the hand's ``grasp`` frame (z out of the palm, along the approach), G = E when the fingers close. A
table is a YAML file ``models/<object>/grasps.yaml``; lengths in it are in mm and angles in degrees, here in m and rad.
"""

from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np
import yaml

from vipr.systems import se3
from vipr.systems.errors import InputError
from vipr.systems.grasping.payload import DYNAMIC_LOAD, MOST, PAYLOAD, dynamic_load
from vipr.systems.hand import transmission
from vipr.systems.hand.finger import RADIUS, WIDEST_REACH

LARGEST_TORQUE = 1.8  # N m per finger angle, what the motors give
WIDEST = 2.0 * (WIDEST_REACH - RADIUS)  # m between the pads of finger 3 and the others, all open


@dataclass(frozen=True, eq=False)
class Grasp:
    """One taught grasp."""

    name: str = ""
    up: np.ndarray = field(
        default_factory=lambda: np.array([0.0, 0.0, 1.0])
    )  # (3,) in O: what points up for this grasp
    X_OG: np.ndarray = field(default_factory=lambda: np.eye(4))
    approach: float = 0.1  # m, the reference point lies so far back along G's z
    spread: float = 0.0  # rad
    preshape: np.ndarray = field(default_factory=lambda: np.zeros(3))  # (3,) rad, finger angles on the way
    torque: np.ndarray = field(default_factory=lambda: np.full(3, 0.8))  # (3,) N m at which the fingers stop
    closed: np.ndarray = field(default_factory=lambda: np.zeros(3))  # (3,) rad, where they stopped when it was taught
    width: float = 0.05  # m of the object between the fingers
    quality: float = 0.0  # epsilon of the grasp's wrench space, 0 to 1
    held: float = 0.0  # share of the teaching trials in which it held

    def __deepcopy__(self, memo):
        return self  # immutable

    def check(self) -> "Grasp":
        """The grasp, or InputError where the hand cannot do it."""
        who = f"grasp {self.name!r}"
        transmission.check_command(np.append(self.preshape, self.spread))
        if not self.width < WIDEST:
            raise InputError(f"{who}: {1e3 * self.width:.0f} mm is too wide, the hand opens to {1e3 * WIDEST:.0f} mm")
        if not ((self.torque > 0) & (self.torque <= LARGEST_TORQUE)).all():
            raise InputError(
                f"{who}: torque_nm must be above 0 and at most {LARGEST_TORQUE}, got {self.torque.tolist()}"
            )
        if not se3.is_pose(self.X_OG):
            raise InputError(f"{who}: its pose must be a rigid motion")
        if not 0.02 <= self.approach <= 0.3:
            raise InputError(f"{who}: approach_mm must be 20 to 300, got {1e3 * self.approach:g}")
        return self

    def turned(self, angle: float, axis: np.ndarray, centre: np.ndarray) -> "Grasp":
        """The grasp turned by angle [rad] about an axis (3,) through a point (3,) of O: as good on an object that looks the same then."""
        R = se3.exp_so3(angle * np.asarray(axis, float))
        return replace(self, X_OG=se3.pose(R, centre - R @ centre) @ self.X_OG, up=R @ self.up)


@dataclass(frozen=True, eq=False)
class Symmetry:
    """Turns about a point of O after which the object looks the same."""

    centre: np.ndarray = field(default_factory=lambda: np.zeros(3))  # (3,) in O, m
    half_turns: str = ""  # axes of O about which half a turn changes nothing: "xyz" for a box
    revolution: bool = False  # a body of revolution about O's z

    def __deepcopy__(self, memo):
        return self  # immutable


@dataclass(frozen=True, eq=False)
class GraspTable:
    """The grasps of one object, best first."""

    object: str = ""
    mass: float = 0.0  # kg
    symmetry: Symmetry = Symmetry()
    grasps: tuple[Grasp, ...] = ()

    def __deepcopy__(self, memo):
        return self  # immutable

    def check(self, mass: float | None = None) -> "GraspTable":
        """The table, or InputError if it is empty or the object (of that mass [kg], if it is known) is too heavy."""
        if not self.grasps:
            raise InputError(f"grasps of {self.object}: the table is empty; teach some: vipr grasp teach {self.object}")
        mass = self.mass if mass is None else mass
        if not 0 < mass <= MOST:
            raise InputError(
                f"grasps of {self.object}: {mass:g} kg is too heavy, the arm carries {PAYLOAD:g} kg, {MOST:.1f} kg beside the hand"
            )
        least = min(self.load(grasp, mass) for grasp in self.grasps)
        if least > DYNAMIC_LOAD:
            raise InputError(
                f"grasps of {self.object}: {mass:g} kg is too heavy so far out, {least:.4f} kg m2 about joint 5 with the hand, "
                f"allowed {DYNAMIC_LOAD:g}"
            )
        for grasp in self.grasps:
            grasp.check()
        return self

    def load(self, grasp: Grasp, mass: float | None = None) -> float:
        """Moment of inertia [kg m^2] about joint 5 of hand and object, its mass (the table's, or that given [kg]) in its middle."""
        return dynamic_load(grasp.X_OG, self.mass if mass is None else mass, self.symmetry.centre)


def best_only(table: GraspTable) -> GraspTable:
    """The table with the first grasp of each way up."""
    first: dict[tuple, Grasp] = {}
    for grasp in table.grasps:
        first.setdefault(tuple(np.round(grasp.up, 3)), grasp)
    return replace(table, grasps=tuple(first.values()))


def load_grasps(path: Path) -> GraspTable:
    """A table of grasps from its file; InputError names the file and what is wrong with it."""
    path = Path(path)
    if not path.is_file():
        raise InputError(f"grasps: there is no file {path}; teach some: vipr grasp teach OBJECT")
    try:
        data = yaml.safe_load(path.read_text()) or {}
        rows = data.get("grasps") or []
        table = GraspTable(
            object=str(data["object"]),
            mass=float(data["mass_kg"]),
            symmetry=Symmetry(1e-3 * _numbers(data, "centre_mm", 3), str(data["half_turns"]), bool(data["revolution"])),
            grasps=tuple(_grasp(row) for row in rows),
        )
    except (yaml.YAMLError, KeyError, TypeError, ValueError, AttributeError) as error:
        what = f"{error} is missing" if isinstance(error, KeyError) else " ".join(str(error).split())
        raise InputError(f"grasps: {path}: {what}") from None
    return table.check()


def save_grasps(table: GraspTable, path: Path, comment: str) -> None:
    """Write a table with a first line of comment."""
    data = {"object": table.object, "mass_kg": round(table.mass, 4)}
    data["centre_mm"] = _rounded(1e3 * table.symmetry.centre)
    data |= {"half_turns": table.symmetry.half_turns, "revolution": table.symmetry.revolution}
    data["grasps"] = [_row(grasp) for grasp in table.grasps]
    Path(path).write_text(f"# {comment}\n" + yaml.safe_dump(data, sort_keys=False, width=140, default_flow_style=None))


def _grasp(row: dict) -> Grasp:
    return Grasp(
        name=str(row["name"]),
        up=np.array(_numbers(row, "up", 3)),
        X_OG=se3.pose(se3.exp_so3(np.radians(_numbers(row, "r_og_deg", 3))), 1e-3 * _numbers(row, "p_og_mm", 3)),
        approach=1e-3 * float(row["approach_mm"]),
        spread=float(np.radians(row["spread_deg"])),
        preshape=np.radians(_numbers(row, "preshape_deg", 3)),
        torque=_numbers(row, "torque_nm", 3),
        closed=np.radians(_numbers(row, "closed_deg", 3)),
        width=1e-3 * float(row["width_mm"]),
        quality=float(row["quality"]),
        held=float(row["held"]),
    )


def _numbers(row: dict, key: str, count: int) -> np.ndarray:
    values = np.array(row[key], float)
    if values.shape != (count,) or not np.isfinite(values).all():
        raise ValueError(f"{key} must be {count} numbers, got {row[key]}")
    return values


def _rounded(values, digits=2) -> list[float]:
    return [round(float(v), digits) for v in values]


def _row(grasp: Grasp) -> dict:
    return {
        "name": grasp.name,
        "up": _rounded(grasp.up, 4),
        "p_og_mm": _rounded(1e3 * grasp.X_OG[:3, 3]),
        "r_og_deg": _rounded(np.degrees(se3.log_so3(grasp.X_OG[:3, :3])), 4),
        "approach_mm": round(float(1e3 * grasp.approach), 1),
        "spread_deg": round(float(np.degrees(grasp.spread)), 1),
        "preshape_deg": _rounded(np.degrees(grasp.preshape), 1),
        "torque_nm": _rounded(grasp.torque),
        "closed_deg": _rounded(np.degrees(grasp.closed), 1),
        "width_mm": round(float(1e3 * grasp.width), 1),
        "quality": round(float(grasp.quality), 4),
        "held": round(float(grasp.held), 3),
    }
