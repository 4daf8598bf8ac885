"""Image-based visual servoing on points or lines (paper III-F; Chaumette and Hutchinson 2006)."""

from dataclasses import dataclass
from typing import Literal

import numpy as np

from vipr.systems.errors import InputError
from vipr.systems.servo.gain import gain_at
from vipr.systems.servo.interaction import point_interaction
from vipr.systems.servo.law import Law
from vipr.systems.servo.line_features import line_error, lines_interaction
from vipr.systems.servo.situation import Situation

FEATURES = ("points", "lines")
JACOBIANS = ("current", "desired", "mean", "estimated")


@dataclass(frozen=True, kw_only=True)
class ImageBased(Law):
    """Every feature goes straight to its goal in the image, as far as one rigid motion can do it.

    features: the ``points``, or the ``lines`` through one and the next. jacobian: ``current`` (features and depths of now), ``desired`` (of
    the goal: constant), ``mean`` of the two (Malis 2004), or ``estimated`` (points of now, depths from how they moved: no model of the
    object).
    """

    kind: Literal["image_based"] = "image_based"
    features: str = "points"
    jacobian: str = "current"

    def __post_init__(self):
        super().__post_init__()
        if self.features not in FEATURES:
            raise InputError(f"servo: unknown features {self.features!r}, allowed are {', '.join(FEATURES)}")
        if self.jacobian not in JACOBIANS:
            raise InputError(f"servo: unknown jacobian {self.jacobian!r}, allowed are {', '.join(JACOBIANS)}")
        if self.features == "lines" and self.jacobian == "estimated":
            raise InputError(
                "servo: jacobian estimated is for points; with features lines take current, desired or mean"
            )


def image_based_twist(situation: Situation, law: ImageBased, depths: np.ndarray | None = None) -> np.ndarray:
    """V_B (w, v) at C's origin in C: ``lambda L^+ (s - s*)``, positive since the body moves and not the camera.

    depths: (n,) estimated [m], for the ``estimated`` Jacobian.
    """
    if law.features == "lines":
        error = line_error(situation.x, situation.x_goal)
    else:
        error = (situation.x - situation.x_goal).ravel()
    L = interaction_of(situation, law, depths)
    return gain_at(law.gain, error) * np.linalg.lstsq(L, error, rcond=None)[0]


def interaction_of(situation: Situation, law: ImageBased, depths: np.ndarray | None = None) -> np.ndarray:
    """(2 n, 6) interaction matrix of the law's kind."""
    if law.jacobian == "estimated":
        return point_interaction(situation.x, depths)
    matrices = []
    if law.jacobian in ("current", "mean"):
        matrices.append(_interaction(law.features, situation.x, situation.points_C))
    if law.jacobian in ("desired", "mean"):
        matrices.append(_interaction(law.features, situation.x_goal, situation.goal_points_C))
    return np.mean(matrices, axis=0)


def _interaction(features: str, x: np.ndarray, points_C: np.ndarray) -> np.ndarray:
    return lines_interaction(x, points_C) if features == "lines" else point_interaction(x, points_C[:, 2])
