"""The points of a model's surface that are seen at pixels of an image.

Frames: O object, C camera.
"""

import numpy as np

from vipr.systems.tracking.triangulation import unit


def surface_points(model, X_CO, lens, pixel, occluders_C):
    """Nearest surface point (M, 3) in C behind each pixel and its unit normal towards the camera; nan where there is none."""
    surface = model.surface @ X_CO[:3, :3].T + X_CO[:3, 3]
    own = len(surface)
    if occluders_C is not None and len(occluders_C):
        surface = np.concatenate([surface, occluders_C])
    ray = np.column_stack([(pixel - (lens.cx, lens.cy)) / (lens.fx, lens.fy), np.ones(len(pixel))])
    if not own:
        return np.full((len(pixel), 3), np.nan), np.full((len(pixel), 3), np.nan)
    a, e1, e2 = surface[:, 0], surface[:, 1] - surface[:, 0], surface[:, 2] - surface[:, 0]
    normal = np.cross(e1, e2)
    toward = ray @ normal.T  # (M, S)
    with np.errstate(divide="ignore", invalid="ignore"):
        depth = np.einsum("sd,sd->s", a, normal) / toward
        ae2, ae1 = np.cross(e2, a), np.cross(a, e1)
        beta = (ray @ ae2.T) / toward  # barycentric coordinates of the ray in each triangle
        gamma = (ray @ ae1.T) / toward
        hit = (depth > 1e-3) & (beta >= 0) & (gamma >= 0) & (beta + gamma <= 1)
    depth = np.where(hit, depth, np.inf)
    nearest = depth.argmin(1)
    d = depth[np.arange(len(pixel)), nearest]
    seen = np.isfinite(d) & (nearest < own)
    p_C = np.where(seen[:, None], ray * np.where(seen, d, 0.0)[:, None], np.nan)
    n_C = unit(normal[nearest])
    n_C = np.where((np.einsum("md,md->m", n_C, ray) > 0)[:, None], -n_C, n_C)
    if len(model.cylinders):  # from the tessellation to the round surface
        owner = np.where(seen, np.r_[model.surface_owner, np.full(len(surface) - own, -1)][nearest], -1)
        for i, (start, end, radius) in enumerate((c[:3], c[3:6], c[6]) for c in model.cylinders):
            axis = X_CO[:3, :3] @ unit(end - start)
            round_ = (owner == i) & (np.abs(n_C @ axis) < 0.5)
            p, spoke = _on_cylinder(ray[round_], X_CO[:3, :3] @ start + X_CO[:3, 3], axis, radius)
            p_C[round_], n_C[round_] = p, unit(spoke)
    return p_C, np.where(seen[:, None], n_C, np.nan)


def _on_cylinder(ray, base, axis, radius):
    """Where rays (M, 3) from the camera's centre enter a cylinder about an axis through base, and the spokes there (M, 3); all in C.

    A ray that passes it by is taken where it comes nearest.
    """
    across = ray - np.outer(ray @ axis, axis)
    start = base - (base @ axis) * axis
    a, b, c = (across * across).sum(1), across @ start, start @ start - radius**2
    p = ray * ((b - np.sqrt(np.maximum(b * b - a * c, 0.0))) / a)[:, None]
    return p, p - base - np.outer((p - base) @ axis, axis)
