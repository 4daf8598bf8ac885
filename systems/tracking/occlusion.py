"""What stands in front: points of the image hidden by triangles. Frame C: x right, y down, z forward."""

import numpy as np

from vipr.systems.camera.lens import Lens
from vipr.systems.compiled import compiled

NEAR = 1e-3  # m in front of the camera


def hidden_behind(
    pixel: np.ndarray,
    depth: np.ndarray,
    triangles_C: np.ndarray,
    lens: Lens,
    tolerance: float,
    owner: np.ndarray | None = None,
    triangle_owner: np.ndarray | None = None,
    one_sided: bool = False,
) -> np.ndarray:
    """(N,) whether a point at pixel (N, 2) and depth (N,) [m] is hidden by a triangle (T, 3, 3) of C, nearer by more than tolerance [m].

    Triangles of the point's own cylinder do not count: those with its owner's number. With one_sided, neither do those seen from behind.
    """
    if owner is None or triangle_owner is None:
        owner, triangle_owner = np.full(len(pixel), -1), np.full(len(triangles_C), -1)
    triangles_C = np.array(triangles_C, float)  # those of a signal are read-only, which would be compiled apart
    return _hidden(
        pixel, depth, triangles_C, lens.fx, lens.fy, lens.cx, lens.cy, tolerance, owner, triangle_owner, one_sided
    )


@compiled
def _hidden(pixel, depth, triangles_C, fx, fy, cx, cy, tolerance, owner, triangle_owner, one_sided):
    hidden = np.zeros(len(pixel), np.bool_)
    u, v, inverse = np.empty(3), np.empty(3), np.empty(3)
    for k in range(len(triangles_C)):
        T = triangles_C[k]
        if not (T[0, 2] > NEAR and T[1, 2] > NEAR and T[2, 2] > NEAR):
            continue
        for i in range(3):
            inverse[i] = 1.0 / T[i, 2]
            u[i], v[i] = fx * T[i, 0] * inverse[i] + cx, fy * T[i, 1] * inverse[i] + cy
        ax, ay, bx, by = u[1] - u[0], v[1] - v[0], u[2] - u[0], v[2] - v[0]
        area = ax * by - ay * bx
        if not (area < -1e-9 or (area > 1e-9 and not one_sided)):  # outward faces run clockwise where y points down
            continue
        for n in range(len(pixel)):
            if hidden[n] or (owner[n] >= 0 and owner[n] == triangle_owner[k]):
                continue
            dx, dy = pixel[n, 0] - u[0], pixel[n, 1] - v[0]
            beta, gamma = (dx * by - dy * bx) / area, (ax * dy - ay * dx) / area  # barycentric
            if beta > 1e-4 and gamma > 1e-4 and beta + gamma < 1.0 - 1e-4:
                nearer = inverse[0] + beta * (inverse[1] - inverse[0]) + gamma * (inverse[2] - inverse[0])
                hidden[n] = nearer * (depth[n] - tolerance) > 1.0
    return hidden
