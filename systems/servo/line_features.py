"""Lines as image features: (rho, theta) of ``x cos theta + y sin theta = rho`` through each feature point and the next, all round."""

import numpy as np

from vipr.systems.errors import InputError
from vipr.systems.servo.interaction import line_interaction

SHORT = 1e-6  # normalised: points nearer in the image than this give no line


def lines_through(x: np.ndarray) -> np.ndarray:
    """(n, 2) rho and theta of the lines from each image point of x (n, 2) to the next."""
    ends = np.roll(x, -1, axis=0)
    a, b = x[:, 1] - ends[:, 1], ends[:, 0] - x[:, 0]
    length = np.hypot(a, b)
    if length.min() < SHORT:
        raise InputError(
            f"servo: line {int(np.argmin(length)) + 1} of {len(x)} is seen end-on: its points coincide in the image"
        )
    return np.column_stack([(a * x[:, 0] + b * x[:, 1]) / length, np.arctan2(b, a)])


def line_error(x: np.ndarray, x_goal: np.ndarray) -> np.ndarray:
    """(2 n,) rho1 theta1 rho2 theta2 ... of the lines through x less those through x_goal, angles the short way round."""
    error = lines_through(x) - lines_through(x_goal)
    error[:, 1] = (error[:, 1] + np.pi) % (2 * np.pi) - np.pi
    return error.ravel()


def lines_interaction(x: np.ndarray, points_C: np.ndarray) -> np.ndarray:
    """(2 n, 6) of the lines through the image points x (n, 2) of points_C (n, 3) [m].

    Of all planes through a line in space the one is taken that turns its face to the camera: it passes furthest from C's origin.
    """
    along = np.roll(points_C, -1, axis=0) - points_C
    normals = np.cross(along, np.cross(points_C, along))
    planes = np.column_stack([normals, -(normals * points_C).sum(1)])
    return np.vstack([line_interaction(*line, plane) for line, plane in zip(lines_through(x), planes, strict=True)])
