"""Image-based visual servoing on points (paper III-F; Chaumette and Hutchinson 2006)."""

from dataclasses import dataclass
from typing import Literal

import numpy as np

from vipr.systems.errors import InputError
from vipr.systems.servo.gain import gain_at
from vipr.systems.servo.interaction import point_interaction
from vipr.systems.servo.law import Law
from vipr.systems.servo.situation import Situation

JACOBIANS = ("current", "desired", "mean", "estimated")


@dataclass(frozen=True, kw_only=True)
class ImageBased(Law):
    """Every feature goes straight to its goal in the image, as far as one rigid motion can do it.

    jacobian: ``current`` (features and depths of now), ``desired`` (of the goal: constant), ``mean`` of the two (Malis 2004), or
    ``estimated`` (features of now, depths from how they moved: no model of the object).
    """

    kind: Literal["image_based"] = "image_based"
    jacobian: str = "current"

    def __post_init__(self):
        super().__post_init__()
        if self.jacobian not in JACOBIANS:
            raise InputError(f"servo: unknown jacobian {self.jacobian!r}, allowed are {', '.join(JACOBIANS)}")


def image_based_twist(situation: Situation, law: ImageBased, depths: np.ndarray | None = None) -> np.ndarray:
    """V_B (w, v) at C's origin in C: ``lambda L^+ (s - s*)``, positive since the body moves and not the camera.

    depths: (n,) estimated [m], for the ``estimated`` Jacobian.
    """
    error = (situation.x - situation.x_goal).ravel()
    L = interaction_of(situation, law.jacobian, depths)
    return gain_at(law.gain, error) * np.linalg.lstsq(L, error, rcond=None)[0]


def interaction_of(situation: Situation, jacobian: str, depths: np.ndarray | None = None) -> np.ndarray:
    """(2 n, 6) interaction matrix of the chosen kind."""
    if jacobian == "current":
        return point_interaction(situation.x, situation.depths)
    if jacobian == "estimated":
        return point_interaction(situation.x, depths)
    desired = point_interaction(situation.x_goal, situation.goal_depths)
    if jacobian == "desired":
        return desired
    return 0.5 * (point_interaction(situation.x, situation.depths) + desired)
