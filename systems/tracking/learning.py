"""Learning a keyframe: where the picture of the object has most structure, and where on its surface that is.

Frames: O object, C camera.
"""

import cv2
import numpy as np

from vipr.systems.camera.lens import Lens
from vipr.systems.compiled import compiled
from vipr.systems.tracking.cad_model import CadModel
from vipr.systems.tracking.keyframes import Keyframe
from vipr.systems.tracking.looks import ABOVE_NOISE, HALF, SAMPLES, contrast_floor, normalise, sample_patch
from vipr.systems.tracking.normal_flow import Patch
from vipr.systems.tracking.surface import surface_points
from vipr.systems.tracking.visible_edges import visible_nodes


def learn_keyframe(
    pyramid_: list[Patch],
    model: CadModel,
    X_CO: np.ndarray,
    covariance: np.ndarray,
    lens: Lens,
    count: int = 64,
    occluders_C: np.ndarray | None = None,
    trust: float = 1.0,
    fit_px: float = 0.0,
) -> Keyframe | None:
    """Patches on the visible faces where the picture has most structure in two directions; None where there are too few."""
    full = pyramid_[0]
    pixel = _candidates(full, model, X_CO, lens, count)
    if len(pixel) < 6:
        return None
    p_C, normal_C = surface_points(model, X_CO, lens, pixel, occluders_C)
    steps = []
    valid = np.isfinite(p_C[:, 2])
    for offset in ((1.0, 0.0), (0.0, 1.0)):  # one pixel along x and y, on the tangent plane
        ray = np.column_stack([(pixel + offset - (lens.cx, lens.cy)) / (lens.fx, lens.fy), np.ones(len(pixel))])
        with np.errstate(divide="ignore", invalid="ignore"):
            depth = np.einsum("md,md->m", normal_C, p_C) / np.einsum("md,md->m", normal_C, ray)
            steps.append(ray * depth[:, None] - p_C)
    axes_C = np.stack(steps, 1)
    for corner in ((-HALF - 1, -HALF - 1), (-HALF - 1, HALF + 1), (HALF + 1, -HALF - 1), (HALF + 1, HALF + 1)):
        other, _ = surface_points(model, X_CO, lens, pixel + corner, occluders_C)
        off = np.abs(np.einsum("md,md->m", normal_C, other - p_C))
        with np.errstate(invalid="ignore"):
            valid &= off < 0.02 * model.size  # the whole patch lies on one face
    valid &= np.isfinite(axes_C).all((1, 2))
    if valid.sum() < 6:
        return None
    valid = np.flatnonzero(valid)[:count]  # best first
    pixel, p_C, normal_C, axes_C = pixel[valid], p_C[valid], normal_C[valid], axes_C[valid]
    looks, gradients, gains = zip(
        *(
            _looks(level.grey, level.origin, 2.0**k, contrast_floor(level.noise), pixel)
            for k, level in enumerate(pyramid_)
        ),
        strict=True,
    )
    looks, gradient = np.stack(looks), np.stack(gradients)
    # Too little to see in one direction or another: such a patch would follow its noise.
    a, b, c = ((gradient[0, i] * gradient[0, j]).sum(1) for i, j in ((0, 0), (1, 1), (0, 1)))
    least = 0.5 * (a + b - np.sqrt((a - b) ** 2 + 4.0 * c * c))
    clear = least > ABOVE_NOISE**2 * 0.5 * (max(full.noise, 0.5) * gains[0]) ** 2 * SAMPLES
    if clear.sum() < 6:
        return None
    p_C, normal_C, axes_C, looks, gradient = (
        p_C[clear],
        normal_C[clear],
        axes_C[clear],
        looks[:, clear],
        gradient[:, :, clear],
    )
    R, t = X_CO[:3, :3], X_CO[:3, 3]
    return Keyframe(
        X_CO, covariance, (p_C - t) @ R, normal_C @ R, axes_C @ R, looks, gradient, trust, fit_px, picture=full
    )


@compiled
def _looks(grey, origin, scale, floor, pixel):
    """Looks (M, P) of the patches at pixels (M, 2) in one level, their gradients (2, M, P) and gains (M,); 0 where there is no contrast."""
    M = len(pixel)
    looks, gradient, gains = np.empty((M, SAMPLES), np.float32), np.empty((2, M, SAMPLES), np.float32), np.empty(M)
    ahead, behind, upright = np.empty(SAMPLES, np.float32), np.empty(SAMPLES, np.float32), np.eye(2)
    for m in range(M):
        x, y = (pixel[m, 0] - origin[0]) / scale, (pixel[m, 1] - origin[1]) / scale
        sample_patch(grey, x, y, upright, ahead)
        gain = normalise(ahead, floor)
        gains[m] = gain
        for p in range(SAMPLES):
            looks[m, p] = gain * ahead[p]
        for axis in range(2):
            dx, dy = 1.0 - axis, 0.0 + axis
            sample_patch(grey, x + dx, y + dy, upright, ahead)
            sample_patch(grey, x - dx, y - dy, upright, behind)
            mean = np.float32(0.0)
            for p in range(SAMPLES):
                ahead[p] = np.float32(0.5) * (ahead[p] - behind[p])
                mean += ahead[p]
            for p in range(SAMPLES):
                gradient[axis, m, p] = gain * (ahead[p] - mean / SAMPLES)
    return looks, gradient, gains


def _candidates(full, model, X_CO, lens, count):
    """Pixels with structure in two directions, the best of each cell of a grid over the object."""
    p_C = model.corners @ X_CO[:3, :3].T + X_CO[:3, 3]
    if (p_C[:, 2] <= 1e-3).any():
        return np.zeros((0, 2))
    box = lens.project(p_C) - full.origin
    height, width = full.grey.shape
    x0, y0 = np.maximum(np.floor(box.min(0)).astype(int), HALF + 2)
    x1, y1 = np.minimum(np.ceil(box.max(0)).astype(int), (width - HALF - 2, height - HALF - 2))
    if x1 - x0 < 12 or y1 - y0 < 12:
        return np.zeros((0, 2))
    quality = cv2.cornerMinEigenVal(full.grey[y0:y1, x0:x1], 5, 3)
    hull = cv2.convexHull((box - (x0, y0)).astype(np.float32).reshape(-1, 1, 2))
    mask = np.zeros(quality.shape, np.uint8)
    cv2.fillConvexPoly(mask, np.round(hull).astype(np.int32), 1)
    edges = np.round(visible_nodes(model, X_CO, lens, 2000, 1.5).pixel - full.origin - (x0, y0)).astype(int)
    edges = edges[((edges >= 0) & (edges < (x1 - x0, y1 - y0))).all(1)]
    mask[edges[:, 1], edges[:, 0]] = 0  # keep off the model's edges: a patch lies on one face
    quality = quality * cv2.erode(mask, np.ones((2 * HALF + 3,) * 2, np.uint8), borderValue=0)
    cell = max(5, int(np.sqrt(max(int(mask.sum()), 1) / (2.0 * count))))
    rows, columns = quality.shape[0] // cell, quality.shape[1] // cell
    if rows < 1 or columns < 1:
        return np.zeros((0, 2))
    cells = quality[: rows * cell, : columns * cell].reshape(rows, cell, columns, cell).transpose(0, 2, 1, 3)
    cells = cells.reshape(rows * columns, cell * cell)
    best = cells.argmax(1)
    value = cells[np.arange(len(cells)), best]
    y = np.arange(rows * columns) // columns * cell + best // cell
    x = np.arange(rows * columns) % columns * cell + best % cell
    threshold = max(float(value.max()) * 0.003, 1e-6)
    order = np.argsort(-value, kind="stable")
    order = order[value[order] > threshold][: 3 * count // 2]
    return np.column_stack([x[order] + x0, y[order] + y0]) + full.origin
