"""Which taught grasps suit an object as it lies: the way up, and the turns that its symmetry allows.

Frames: W world (z up), O object, G the hand when the fingers close.
"""

from collections.abc import Iterator

import numpy as np

from vipr.systems import se3
from vipr.systems.grasping.grasp import Grasp, GraspTable, Symmetry
from vipr.systems.grasping.payload import DYNAMIC_LOAD

TURNS = 16  # tried around an upright body of revolution
UP_TOLERANCE = np.radians(12.0)  # between the way up of a grasp and of the object


def suitable(table: GraspTable, X_WO: np.ndarray) -> list[Grasp]:
    """The grasps for an object at X_WO, best first, each with its X_OG turned as the object's symmetry allows; none that asks
    more of the wrist than the data sheet."""
    up_O = X_WO[:3, :3].T @ [0.0, 0.0, 1.0]
    found = [
        turned
        for grasp in table.grasps
        if table.load(grasp) <= DYNAMIC_LOAD
        for turned in alike(grasp, table.symmetry, up_O)
        if np.arccos(np.clip(turned.up @ up_O, -1.0, 1.0)) < UP_TOLERANCE
    ]
    return sorted(found, key=lambda grasp: -grasp.held * grasp.quality)


def alike(grasp: Grasp, symmetry: Symmetry, up_O: np.ndarray) -> Iterator[Grasp]:
    """The grasp at every place where the object looks the same; of a lying body of revolution where its way up is ``up_O``."""
    axes, centre = np.eye(3), symmetry.centre
    half = [grasp, *(grasp.turned(np.pi, axes["xyz".index(axis)], centre) for axis in symmetry.half_turns)]
    if not symmetry.revolution:
        yield from half
        return
    for one in half:
        if abs(one.up[2]) > 0.5:
            for turn in range(TURNS):
                yield one.turned(2.0 * np.pi * turn / TURNS, axes[2], centre)
        else:
            roll = np.arctan2(up_O[1], up_O[0]) - np.arctan2(one.up[1], one.up[0])
            yield one.turned(roll, axes[2], centre)


def way_up(table: GraspTable, X_WO: np.ndarray) -> np.ndarray | None:
    """The axis (3,) of O that points up, of those that grasps are known for; None if the object lies like none of them."""
    found = suitable(table, X_WO)
    return found[0].up if found else None


def unrolled(symmetry: Symmetry, X_WO: np.ndarray) -> np.ndarray:
    """The same look with O's x as far up as it goes, for a body of revolution that lies: how it is rolled is neither seen nor matters."""
    up_O = X_WO[:3, :3].T @ [0.0, 0.0, 1.0]
    if not symmetry.revolution or abs(up_O[2]) > 0.5:
        return X_WO
    return X_WO @ se3.pose(se3.exp_so3(np.array([0.0, 0.0, np.arctan2(up_O[1], up_O[0])])), np.zeros(3))
