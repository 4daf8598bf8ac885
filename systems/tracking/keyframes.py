"""Keyframes: patches of the object's faces, learnt while tracking, their places on the model and their looks at several scales.

Frames: O object, C camera.
"""

from dataclasses import dataclass, field, replace
from functools import cached_property

import cv2
import numpy as np

from vipr.systems.camera.lens import Lens
from vipr.systems.compiled import compiled
from vipr.systems.tracking.cad_model import CadModel
from vipr.systems.tracking.displacements import difference
from vipr.systems.tracking.normal_flow import Patch, bilinear
from vipr.systems.tracking.triangulation import unit
from vipr.systems.tracking.visible_edges import visible_nodes

HALF = 3  # px; a patch is 7 x 7 samples at each level
LEVELS = 4
ABOVE_NOISE = 1.8  # a patch needs an RMS contrast, and gradients both ways, of so many times the noise's
SAMPLES = (2 * HALF + 1) ** 2


@dataclass(frozen=True, eq=False)
class Keyframe:
    """M patches seen at one pose."""

    X_CO: np.ndarray  # (4, 4)
    covariance: np.ndarray  # (6, 6) of that pose
    p_O: np.ndarray  # (M, 3) m, centres
    normal_O: np.ndarray  # (M, 3) of the surface
    axes_O: np.ndarray  # (M, 2, 3) m on the surface for one pixel along x and y of the keyframe
    looks: np.ndarray  # (LEVELS, M, P) samples, mean removed, length one; zero where the patch has no contrast
    gradient: np.ndarray  # (LEVELS, 2, M, P) of looks by the keyframe's level pixels along x and y
    trust: float = 1.0  # 0 to 1, probability that the pose was right
    fit_px: float = 0.0  # residual of the edges at that pose
    # (6, 6) of that pose, beside the covariance: what was the same in all frames up to then and had not averaged out.
    shared: np.ndarray = field(default_factory=lambda: np.zeros((6, 6)))
    lasting: bool = False  # known beforehand: kept whatever is seen
    picture: Patch | None = None  # what it was learnt from

    def __len__(self):
        return len(self.p_O)

    @cached_property
    def alive(self) -> np.ndarray:
        """(LEVELS, M) whether the patch has contrast at the level."""
        return self.looks.any(2)

    @cached_property
    def keypoints(self) -> tuple[np.ndarray, np.ndarray]:
        """Pixels (N, 2) of the keypoints in the picture that it was learnt from, and their descriptors (N, 128)."""
        if self.picture is None:
            return np.zeros((0, 2)), np.zeros((0, 128), np.float32)
        pixel, look = keypoints(np.clip(self.picture.grey, 0, 255).astype(np.uint8))
        return pixel + self.picture.origin, look

    def without(self, numbers: np.ndarray) -> "Keyframe":
        """The keyframe without the patches of these numbers."""
        kept = np.setdiff1d(np.arange(len(self)), numbers)
        return replace(
            self,
            p_O=self.p_O[kept],
            normal_O=self.normal_O[kept],
            axes_O=self.axes_O[kept],
            looks=self.looks[:, kept],
            gradient=self.gradient[:, :, kept],
        )


def keypoints(grey: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Pixels (N, 2) of the SIFT keypoints of a grey image (h, w) uint8, and their descriptors (N, 128)."""
    found, look = cv2.SIFT_create(nfeatures=1000).detectAndCompute(grey, None)
    if not found:
        return np.zeros((0, 2)), np.zeros((0, 128), np.float32)
    return np.array([k.pt for k in found]), look


def pyramid(patch: Patch) -> list[Patch]:
    """The patch at full, half, quarter ... size; coordinates relative to its origin shrink alike."""
    levels = [patch]
    for _ in range(LEVELS - 1):
        grey = levels[-1].grey
        levels.append(
            Patch(
                cv2.pyrDown(grey) if min(grey.shape) > 8 else np.ascontiguousarray(grey[::2, ::2]),
                patch.origin,
                0.45 * levels[-1].noise,
            )
        )
    return levels


@compiled
def sample_patch(grey, x, y, axes, out):
    """Samples, rows of y, of the image around (x, y) into out (SAMPLES,); axes (2, 2): pixels for a grid step along x and y, as rows."""
    p = 0
    for j in range(-HALF, HALF + 1):
        for i in range(-HALF, HALF + 1):
            out[p] = bilinear(grey, x + i * axes[0, 0] + j * axes[1, 0], y + i * axes[0, 1] + j * axes[1, 1])
            p += 1


@compiled
def normalise(samples, floor):
    """Takes the mean off samples (P,) in place; returns 1 / their length, or 0 where that is no more than the floor."""
    mean = np.float32(0.0)
    for value in samples:
        mean += value
    mean /= len(samples)
    square = np.float32(0.0)
    for p in range(len(samples)):
        samples[p] -= mean
        square += samples[p] * samples[p]
    return np.float32(1.0 / np.sqrt(square)) if square > floor * floor else np.float32(0.0)


def contrast_floor(noise: float) -> float:
    """Length of a patch's samples below which they are no more than noise [grey levels]."""
    return ABOVE_NOISE * max(noise, 0.5) * (2 * HALF + 1)


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


def choose_keyframe(keyframes: tuple[Keyframe, ...], X_CO: np.ndarray, limit: float = 0.6) -> Keyframe | None:
    """The keyframe seen most like X_CO (angle [rad] of the view plus change of size); the oldest of equals; None beyond the limit."""
    best, least = None, limit
    for keyframe in keyframes:
        away = view_difference(keyframe.X_CO, X_CO)
        if away < least - 0.02:
            best, least = keyframe, away
    return best


@compiled
def view_difference(X_CA: np.ndarray, X_CB: np.ndarray) -> float:
    """How differently two poses show the object: rotation [rad] out of the image plane, half of that in it, and |log of scale|."""
    w = difference(X_CA, X_CB)
    x, y, z = X_CB[0, 3], X_CB[1, 3], X_CB[2, 3]
    roll = (w[0] * x + w[1] * y + w[2] * z) / max(np.sqrt(x * x + y * y + z * z), 1e-12)
    out = np.sqrt(max(w[0] ** 2 + w[1] ** 2 + w[2] ** 2 - roll * roll, 0.0))
    return out + 0.5 * abs(roll) + abs(np.log(max(X_CA[2, 3], 1e-6) / max(X_CB[2, 3], 1e-6)))
