"""Texture learnt while tracking: patches of the object's faces, aligned all at once over the six pose parameters.

A keyframe holds patches of the visible faces, their places on the model and their looks at several scales. In a later frame each patch
is warped by the start pose, compared after removing mean and gain, and all patches together give one Gauss-Newton step for the
pose (the gradients are the template's: inverse compositional). Coarse to fine, this follows motions of tens of pixels; since patches
are compared with their keyframe, never with the last frame, errors do not add up from frame to frame.

Frames: O object, C camera; displacements d as in ``pose_fit``.
"""

from dataclasses import dataclass, field

import cv2
import numpy as np

from vipr.systems.camera.lens import Lens
from vipr.systems.tracking.cad_model import CadModel
from vipr.systems.tracking.normal_flow import Patch
from vipr.systems.tracking.pose_fit import difference, move, point_jacobian, solve
from vipr.systems.tracking.triangulation import unit
from vipr.systems.tracking.visible_edges import hidden_behind, visible_nodes

HALF = 3  # px; a patch is 7 x 7 samples at each level
LEVELS = 4
VISIBLE = 0.35  # share of the patches that is taken to be visible, at least
CHANCE = 0.1  # share of patches that look right at a wrong pose, at most (textures repeat themselves)
ABOVE_NOISE = 1.8  # a patch needs an RMS contrast, and gradients both ways, of so many times the noise's
ALIKE = 0.7  # correlation of a patch that looks right
GRID_Y, GRID_X = (g.reshape(-1).astype(np.float32) for g in np.mgrid[-HALF : HALF + 1, -HALF : HALF + 1])
SAMPLES = len(GRID_X)


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

    def __len__(self):
        return len(self.p_O)


@dataclass(frozen=True, eq=False)
class TextureFit:
    """Pose that aligns a keyframe's patches."""

    X_CO: np.ndarray
    information: np.ndarray  # (6, 6) about that pose, of the alignment alone
    agreement: float  # 0 to 1, share of the patches that look as they should (correlation above ALIKE)
    correlation: float  # of the better third of the patches, at the finest level used
    patches: int  # compared
    pixel: np.ndarray = field(default_factory=lambda: np.zeros((0, 2)))  # (M, 2) where they are
    right: np.ndarray = field(default_factory=lambda: np.zeros(0, bool))  # (M,) whether they look right

    @property
    def significance(self) -> float:
        """Standard deviations by which the patches that look right are more than chance would give."""
        expected = CHANCE * self.patches
        return (self.agreement * self.patches - expected) / np.sqrt(expected * (1.0 - CHANCE) + 0.5)


def pyramid(patch: Patch) -> list[Patch]:
    """The patch at full, half, quarter ... size; coordinates relative to its origin shrink alike."""
    levels = [patch]
    for _ in range(LEVELS - 1):
        grey = levels[-1].grey
        levels.append(
            Patch(cv2.pyrDown(grey) if min(grey.shape) > 8 else grey[::2, ::2], patch.origin, 0.45 * levels[-1].noise)
        )
    return levels


def _spread(axes):
    """Offsets (M, P) in x and y [level pixels] of a patch's samples; axes (M, 2, 2): level pixels for a grid step, as rows."""
    a = axes.astype(np.float32)[..., None]
    return GRID_X * a[:, 0, 0] + GRID_Y * a[:, 1, 0], GRID_X * a[:, 0, 1] + GRID_Y * a[:, 1, 1]


def _sample(level: Patch, scale: float, centre, spread):
    """Samples (M, P) around centres (M, 2) [px of the full image] at the offsets of ``_spread``."""
    c = ((centre - level.origin) / scale).astype(np.float32)
    x, y = c[:, :1] + spread[0], c[:, 1:] + spread[1]
    return cv2.remap(level.grey, x, y, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)


def _normalised(values, noise):
    """Samples with mean removed and at length one, and that length; patches no stronger than the noise become zero."""
    values = values - values.sum(1, keepdims=True) * np.float32(1.0 / SAMPLES)
    length = np.sqrt((values * values).sum(1))
    floor = ABOVE_NOISE * max(noise, 0.5) * (2 * HALF + 1)
    return values * np.where(length > floor, 1.0 / np.maximum(length, 1e-6), 0.0)[:, None], length


def learn_keyframe(
    pyramid_: list[Patch],
    model: CadModel,
    X_CO: np.ndarray,
    covariance: np.ndarray,
    lens: Lens,
    count: int = 64,
    occluders_C: np.ndarray | None = None,
    trust: float = 1.0,
) -> Keyframe | None:
    """Patches on the visible faces where the picture has most structure in two directions; None where there are too few."""
    full = pyramid_[0]
    pixel = _candidates(full, model, X_CO, lens, count)
    if len(pixel) < 6:
        return None
    p_C, normal_C = _surface_points(model, X_CO, lens, pixel, occluders_C)
    steps = []
    valid = np.isfinite(p_C[:, 2])
    for offset in ((1.0, 0.0), (0.0, 1.0)):  # one pixel along x and y, on the tangent plane
        ray = np.column_stack([(pixel + offset - (lens.cx, lens.cy)) / (lens.fx, lens.fy), np.ones(len(pixel))])
        with np.errstate(divide="ignore", invalid="ignore"):
            depth = np.einsum("md,md->m", normal_C, p_C) / np.einsum("md,md->m", normal_C, ray)
            steps.append(ray * depth[:, None] - p_C)
    axes_C = np.stack(steps, 1)
    for corner in ((-HALF - 1, -HALF - 1), (-HALF - 1, HALF + 1), (HALF + 1, -HALF - 1), (HALF + 1, HALF + 1)):
        other, _ = _surface_points(model, X_CO, lens, pixel + corner, occluders_C)
        off = np.abs(np.einsum("md,md->m", normal_C, other - p_C))
        with np.errstate(invalid="ignore"):
            valid &= off < 0.02 * model.size  # the whole patch lies on one face
    valid &= np.isfinite(axes_C).all((1, 2))
    if valid.sum() < 6:
        return None
    valid = np.flatnonzero(valid)[:count]  # best first
    pixel, p_C, normal_C, axes_C = pixel[valid], p_C[valid], normal_C[valid], axes_C[valid]
    M, P = len(pixel), SAMPLES
    looks, gradient = np.zeros((LEVELS, M, P), np.float32), np.zeros((LEVELS, 2, M, P), np.float32)
    upright = _spread(np.broadcast_to(np.eye(2), (M, 2, 2)))
    for k, level in enumerate(pyramid_):
        scale = 2.0**k
        values, length = _normalised(_sample(level, scale, pixel, upright), level.noise)
        looks[k] = values
        alive = np.where(np.abs(values).max(1) > 0, 1.0 / np.maximum(length, 1e-6), 0.0)[:, None]
        for axis, shift in enumerate(((1.0, 0.0), (0.0, 1.0))):
            ahead = _sample(level, scale, pixel + scale * np.array(shift), upright)
            behind = _sample(level, scale, pixel - scale * np.array(shift), upright)
            slope = 0.5 * (ahead - behind)
            gradient[k, axis] = (slope - slope.mean(1, keepdims=True)) * alive
        if k == 0:  # too little to see in one direction or another: such a patch would follow its noise
            a, b, c = ((gradient[0, i] * gradient[0, j]).sum(1) * length**2 for i, j in ((0, 0), (1, 1), (0, 1)))
            least = 0.5 * (a + b - np.sqrt((a - b) ** 2 + 4.0 * c * c))
            clear = least > ABOVE_NOISE**2 * 0.5 * max(level.noise, 0.5) ** 2 * P
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
    return Keyframe(X_CO, covariance, (p_C - t) @ R, normal_C @ R, axes_C @ R, looks, gradient, trust)


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


def _surface_points(model, X_CO, lens, pixel, occluders_C):
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
        flat = np.abs(np.einsum("md,md->m", n_C @ X_CO[:3, :3], np.zeros_like(n_C)))  # 0: replaced below
        for i, (start, end, radius) in enumerate((c[:3], c[3:6], c[6]) for c in model.cylinders):
            axis = X_CO[:3, :3] @ unit(end - start)
            spoke = p_C - (X_CO[:3, :3] @ start + X_CO[:3, 3])
            spoke = spoke - np.outer(spoke @ axis, axis)
            round_ = (owner == i) & (np.abs(n_C @ axis) < 0.5) & (flat < 1.0)
            p_C = np.where(round_[:, None], p_C - spoke + radius * unit(spoke), p_C)
            n_C = np.where(round_[:, None], unit(spoke), n_C)
    return p_C, np.where(seen[:, None], n_C, np.nan)


def _visible(keyframe, model, X_CO, lens, occluders_C):
    """Mask of the patches that face the camera, in the image and not hidden."""
    p_C = keyframe.p_O @ X_CO[:3, :3].T + X_CO[:3, 3]
    n_C = keyframe.normal_O @ X_CO[:3, :3].T
    ahead = p_C[:, 2] > 1e-3
    cosine = -np.einsum("md,md->m", n_C, p_C) / np.maximum(np.linalg.norm(p_C, axis=1), 1e-9)
    pixel = lens.project(np.where(ahead[:, None], p_C, 1.0))
    seen = ahead & (cosine > 0.2)
    seen &= (pixel > HALF).all(1) & (pixel < (lens.width - 1 - HALF, lens.height - 1 - HALF)).all(1)
    if seen.any() and not (model.convex and not len(model.cylinders)):
        surface = model.surface @ X_CO[:3, :3].T + X_CO[:3, 3]
        seen[seen] = ~hidden_behind(pixel[seen], p_C[seen, 2], surface, lens, 0.01 * model.size)
    if seen.any() and occluders_C is not None and len(occluders_C):
        seen[seen] = ~hidden_behind(pixel[seen], p_C[seen, 2], occluders_C, lens, 0.0)
    return seen


class _View:
    """A keyframe's visible patches at one start pose: pixels, warps and Jacobians, fixed while the level is aligned."""

    def __init__(self, keyframe, model, X_CO, lens, occluders_C, seen=None):
        self.seen = _visible(keyframe, model, X_CO, lens, occluders_C) if seen is None else seen
        p_O, axes_O = keyframe.p_O[self.seen], keyframe.axes_O[self.seen]
        self.pixel = lens.project(p_O @ X_CO[:3, :3].T + X_CO[:3, 3])
        self.X_CO = X_CO
        self.J = J = point_jacobian(p_O, X_CO, lens)  # (M, 2, 6)
        a = (axes_O @ X_CO[:3, :3].T) @ J[:, :, 3:].transpose(
            0, 2, 1
        )  # (M, 2, 2): row j, image motion for a step along j
        determinant = a[:, 0, 0] * a[:, 1, 1] - a[:, 0, 1] * a[:, 1, 0]
        determinant = np.where(np.abs(determinant) > 0.05, determinant, np.inf)  # too oblique: no pull
        inverse = np.stack([a[:, 1, 1], -a[:, 1, 0], -a[:, 0, 1], a[:, 0, 0]], 1) / determinant[:, None]
        self.K = inverse.reshape(-1, 2, 2) @ J  # keyframe pixels by d
        self.spread = _spread(a)


def correlation_at(
    keyframe: Keyframe, levels: list[Patch], model: CadModel, X_CO: np.ndarray, lens: Lens, level: int, occluders_C=None
) -> float:
    """Mean correlation of the visible patches with their looks at a pose, without aligning them; -1 with fewer than 6."""
    view = _View(keyframe, model, X_CO, lens, occluders_C)
    if view.seen.sum() < 6:
        return -1.0
    now, _ = _normalised(_sample(levels[level], 2.0**level, view.pixel, view.spread), levels[level].noise)
    return float((now * keyframe.looks[level][view.seen]).sum(1).mean())


def align(
    keyframe: Keyframe,
    levels: list[Patch],
    model: CadModel,
    X_CO: np.ndarray,
    lens: Lens,
    use: tuple[int, ...] = (2, 1, 0),
    iterations: int = 4,
    prior_information: np.ndarray | None = None,
    occluders_C: np.ndarray | None = None,
) -> TextureFit:
    """Pose near X_CO that aligns the patches, through the levels `use` from coarse to fine.

    prior_information (6, 6) is the confidence in X_CO itself; it decides what the patches do not show.
    """
    X, kept, seen, view = X_CO, None, None, None
    prior = prior_information if prior_information is not None else np.zeros((6, 6))
    P = SAMPLES
    before = d = np.zeros(6)  # from X_CO to the view's pose, and on from there
    for k in use:
        scale = 2.0**k
        if view is None or np.abs(view.J @ d).max() > 1.5:  # the warps of the level before no longer fit
            view = _View(keyframe, model, X, lens, occluders_C, seen)
            seen, M = view.seen, len(view.pixel)
            if M < 6:
                break
            before, d = difference(X_CO, X), np.zeros(6)
            K = view.K.astype(np.float32).transpose(1, 2, 0)[..., None]  # (2, 6, M, 1)
        look = keyframe.looks[k][seen]
        slope = keyframe.gradient[k][:, seen] * np.float32(1.0 / scale)
        descent = (slope[0] * K[0] + slope[1] * K[1]).reshape(6, M * P)
        d_start, delta_px = d, np.array([np.inf])
        rank = int(VISIBLE * M)
        for turn in range(iterations + 1):
            now, _ = _normalised(_sample(levels[k], scale, view.pixel + view.J @ d, view.spread), levels[k].noise)
            error = look - now
            misfit = (error * error).sum(1)  # 2 (1 - correlation)
            typical = float(np.partition(misfit, rank)[rank]) + 0.02
            if turn == iterations or np.abs(delta_px).max() < 0.05 * scale:
                break
            weight = 1.0 / (1.0 + (misfit * np.float32(0.5 / typical)) ** 2)
            noise = typical / P * 4.0  # samples are not independent
            weighted = (descent.reshape(6, M, P) * weight[:, None]).reshape(6, M * P)
            H = (weighted @ descent.T).astype(float) / noise
            pull = (weighted @ error.ravel()).astype(float) / noise - prior @ (before + d)
            delta = solve(H + prior, pull)
            delta_px = view.J @ delta
            d = d + delta
        alive = look.any(1)
        correlation = 1.0 - 0.5 * misfit[alive]
        best = 1.0 - 0.5 * (typical - 0.02)
        right = correlation > ALIKE
        if kept is not None and float(right.mean() if len(right) else 0.0) < kept.agreement - 0.15:
            d = d_start
            break  # blurred: the finer level has nothing to add
        X = move(view.X_CO, d)
        kept = TextureFit(X, H, float(right.mean()) if len(right) else 0.0, best, len(right), view.pixel[alive], right)
    return kept if kept is not None else TextureFit(X_CO, np.zeros((6, 6)), 0.0, 0.0, 0)


def choose_keyframe(keyframes: tuple[Keyframe, ...], X_CO: np.ndarray, limit: float = 0.6) -> Keyframe | None:
    """The keyframe seen most like X_CO (angle [rad] of the view plus change of size); the oldest of equals; None beyond the limit."""
    best, least = None, limit
    for keyframe in keyframes:
        away = view_difference(keyframe.X_CO, X_CO)
        if away < least - 0.02:
            best, least = keyframe, away
    return best


def view_difference(X_CA: np.ndarray, X_CB: np.ndarray) -> float:
    """How differently two poses show the object: rotation [rad] out of the image plane, half of that in it, and |log of scale|."""
    w = difference(X_CA, X_CB)[:3]
    sight = unit(X_CB[:3, 3])
    roll = float(w @ sight)
    return float(
        np.linalg.norm(w - roll * sight) + 0.5 * abs(roll) + abs(np.log(max(X_CA[2, 3], 1e-6) / max(X_CB[2, 3], 1e-6)))
    )
