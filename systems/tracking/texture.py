"""Alignment of the texture learnt while tracking: all patches of a keyframe at once over the six pose parameters.

In a later frame each patch is warped by the start pose, compared after removing mean and gain, and all patches together give one
Gauss-Newton step for the pose (the gradients are the template's: inverse compositional). Coarse to fine, this follows motions of tens of
pixels; since patches are compared with their keyframe, never with the last frame, errors do not add up from frame to frame.

Frames: O object, C camera; displacements d as in ``displacements``.
"""

from dataclasses import dataclass, field

import numpy as np

from vipr.systems.camera.lens import Lens
from vipr.systems.compiled import compiled
from vipr.systems.tracking.cad_model import CadModel
from vipr.systems.tracking.displacements import difference, move, pixel_derivatives, turned
from vipr.systems.tracking.keyframes import Keyframe
from vipr.systems.tracking.looks import HALF, contrast_floor, normalise, sample_patch
from vipr.systems.tracking.normal_flow import Patch
from vipr.systems.tracking.occlusion import hidden_behind
from vipr.systems.tracking.small_algebra import dot6, kth_smallest, mirror, solve

VISIBLE = 0.35  # share of the patches that is taken to be visible, at least
CHANCE = 0.1  # share of patches that look right at a wrong pose, at most (textures repeat themselves)
ALIKE = 0.7  # correlation of a patch that looks right


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


class _View:
    """A keyframe's visible patches at one start pose: pixels, warps and Jacobians, fixed while the level is aligned."""

    def __init__(self, keyframe, model, X_CO, lens, occluders_C, seen=None):
        self.seen = _visible(keyframe, model, X_CO, lens, occluders_C) if seen is None else seen
        self.X_CO = X_CO
        self.pixel, self.J, self.K, self.axes = _warps(
            keyframe.p_O, keyframe.axes_O, self.seen, X_CO, lens.fx, lens.fy, lens.cx, lens.cy
        )

    def __len__(self):
        return len(self.seen)


def _visible(keyframe, model, X_CO, lens, occluders_C):
    """Numbers of the patches that face the camera, in the image and not hidden."""
    seen, pixel, depth = _facing(
        keyframe.p_O, keyframe.normal_O, X_CO, lens.fx, lens.fy, lens.cx, lens.cy, lens.width, lens.height
    )
    if seen.any() and not (model.convex and not len(model.cylinders)):
        surface = model.surface @ X_CO[:3, :3].T + X_CO[:3, 3]
        seen[seen] = ~hidden_behind(pixel[seen], depth[seen], surface, lens, 0.01 * model.size)
    if seen.any() and occluders_C is not None and len(occluders_C):
        seen[seen] = ~hidden_behind(pixel[seen], depth[seen], occluders_C, lens, 0.0)
    return np.flatnonzero(seen)


@compiled
def _facing(p_O, normal_O, X_CO, fx, fy, cx, cy, width, height):
    """(seen (M,), pixel (M, 2), depth (M,)) of patches: before the camera, not too oblique, in the image."""
    M = len(p_O)
    seen, pixel, depth = np.zeros(M, np.bool_), np.zeros((M, 2)), np.zeros(M)
    for m in range(M):
        x, y, z = turned(X_CO, p_O[m])
        x, y, z = x + X_CO[0, 3], y + X_CO[1, 3], z + X_CO[2, 3]
        a, b, c = turned(X_CO, normal_O[m])
        if z <= 1e-3 or -(a * x + b * y + c * z) <= 0.2 * np.sqrt(x * x + y * y + z * z):
            continue
        pixel[m, 0], pixel[m, 1], depth[m] = fx * x / z + cx, fy * y / z + cy, z
        seen[m] = HALF < pixel[m, 0] < width - 1 - HALF and HALF < pixel[m, 1] < height - 1 - HALF
    return seen, pixel, depth


@compiled
def _warps(p_O, axes_O, seen, X_CO, fx, fy, cx, cy):
    """For each patch in seen: its pixel (2,), J (2, 6) of that by d, K (2, 6) of the place in the keyframe by d, and the image motion
    (2, 2) for a keyframe pixel along x and y, as rows.
    """
    M = len(seen)
    pixel, J, K, axes = np.empty((M, 2)), np.empty((M, 2, 6)), np.zeros((M, 2, 6)), np.empty((M, 2, 2))
    for m in range(M):
        n = seen[m]
        x, y, z = turned(X_CO, p_O[n])
        pixel_derivatives(J[m], x, y, z, X_CO, fx, fy)
        depth = z + X_CO[2, 3]
        pixel[m, 0], pixel[m, 1] = fx * (x + X_CO[0, 3]) / depth + cx, fy * (y + X_CO[1, 3]) / depth + cy
        for j in range(2):
            u, v, w = turned(X_CO, axes_O[n, j])
            for i in range(2):
                axes[m, j, i] = J[m, i, 3] * u + J[m, i, 4] * v + J[m, i, 5] * w
        determinant = axes[m, 0, 0] * axes[m, 1, 1] - axes[m, 0, 1] * axes[m, 1, 0]
        if abs(determinant) > 0.05:  # else too oblique: no pull
            for i in range(6):
                K[m, 0, i] = (axes[m, 1, 1] * J[m, 0, i] - axes[m, 1, 0] * J[m, 1, i]) / determinant
                K[m, 1, i] = (axes[m, 0, 0] * J[m, 1, i] - axes[m, 0, 1] * J[m, 0, i]) / determinant
    return pixel, J, K, axes


def correlation_at(
    keyframe: Keyframe, levels: list[Patch], model: CadModel, X_CO: np.ndarray, lens: Lens, level: int, occluders_C=None
) -> float:
    """Mean correlation of the visible patches with their looks at a pose, without aligning them; -1 with fewer than 6."""
    view = _View(keyframe, model, X_CO, lens, occluders_C)
    if len(view) < 6:
        return -1.0
    *_, correlation, _ = _align_level(
        *_level(view, keyframe, levels, level), np.zeros((6, 6)), np.zeros(6), np.zeros(6), 0
    )
    return float(correlation.mean())


def looks_right(keyframe, levels, model, X_CO, lens, occluders_C=None):
    """(numbers of the visible patches that look right at a pose, of those that look wrong)."""
    view = _View(keyframe, model, X_CO, lens, occluders_C)
    none = np.zeros(0, int)
    if len(view) < 6:
        return none, none
    _, _, misfit, _, _ = _align_level(*_level(view, keyframe, levels, 1), np.zeros((6, 6)), np.zeros(6), np.zeros(6), 0)
    alive = keyframe.alive[1][view.seen]
    seen, correlation = view.seen[alive], 1.0 - 0.5 * misfit[alive]
    return seen[correlation > ALIKE], seen[correlation < 0.5]


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
    before = d = np.zeros(6)  # from X_CO to the view's pose, and on from there
    for k in use:
        if view is None or np.abs(view.J @ d).max() > 1.5:  # the warps of the level before no longer fit
            view = _View(keyframe, model, X, lens, occluders_C, seen)
            seen = view.seen
            if len(view) < 6:
                break
            before, d = difference(X_CO, X), np.zeros(6)
        d_found, H, misfit, _, typical = _align_level(*_level(view, keyframe, levels, k), prior, before, d, iterations)
        alive = keyframe.alive[k][seen]
        right = 1.0 - 0.5 * misfit[alive] > ALIKE
        share = float(right.mean()) if len(right) else 0.0
        if kept is not None and share < kept.agreement - 0.15:
            break  # blurred: the finer level has nothing to add
        d = d_found
        X = move(view.X_CO, d)
        kept = TextureFit(X, H, share, 1.0 - 0.5 * (typical - 0.02), len(right), view.pixel[alive], right)
    return kept if kept is not None else TextureFit(X_CO, np.zeros((6, 6)), 0.0, 0.0, 0)


def _level(view, keyframe, levels, k):
    """What ``_align_level`` needs of a view and a level."""
    level = levels[k]
    return (
        level.grey,
        level.origin,
        2.0**k,
        contrast_floor(level.noise),
        keyframe.looks[k],
        keyframe.gradient[k],
        view.seen,
        view.pixel,
        view.J,
        view.K,
        view.axes,
    )


@compiled
def _align_level(
    grey, origin, scale, floor, looks, slopes, seen, pixel, J, K, axes, prior, before, d_start, iterations
):
    """Gauss-Newton on the patches in one level: (d, information, misfit (M,), correlation (M,), typical misfit).

    A patch's pull on the pose is its pull on its own place in the keyframe (2,), with the structure tensor (2, 2) of its look, through K.
    misfit: squared distance of looks of length one, 2 (1 - correlation).
    """
    M, P = len(seen), looks.shape[1]
    now, d = np.empty(P, np.float32), d_start.copy()
    misfit, correlation, pull, structure = np.empty(M), np.empty(M), np.empty((M, 2)), np.zeros((M, 3))
    for m in range(M):
        for p in range(P):
            sx, sy = slopes[0, seen[m], p] / scale, slopes[1, seen[m], p] / scale
            structure[m, 0] += sx * sx
            structure[m, 1] += sx * sy
            structure[m, 2] += sy * sy
    H, typical, largest = np.zeros((6, 6)), 0.02, np.inf
    for turn in range(iterations + 1):
        for m in range(M):
            u = (pixel[m, 0] + dot6(J[m, 0], d) - origin[0]) / scale
            v = (pixel[m, 1] + dot6(J[m, 1], d) - origin[1]) / scale
            sample_patch(grey, u, v, axes[m], now)
            gain = normalise(now, floor)
            misfit[m], correlation[m], pull[m, 0], pull[m, 1] = 0.0, 0.0, 0.0, 0.0
            for p in range(P):
                look, seen_now = looks[seen[m], p], now[p] * gain
                error = look - seen_now
                misfit[m] += error * error
                correlation[m] += look * seen_now
                pull[m, 0] += slopes[0, seen[m], p] * error
                pull[m, 1] += slopes[1, seen[m], p] * error
        typical = kth_smallest(misfit, int(VISIBLE * M)) + 0.02
        if turn == iterations or largest < 0.05 * scale:
            break
        noise = typical / P * 4.0  # samples are not independent
        H, g = np.zeros((6, 6)), np.zeros(6)
        for m in range(M):
            weight = 1.0 / ((1.0 + (0.5 * misfit[m] / typical) ** 2) * noise)
            for i in range(6):
                a, b = K[m, 0, i], K[m, 1, i]
                g[i] += weight * (a * pull[m, 0] + b * pull[m, 1]) / scale
                a, b = (a * structure[m, 0] + b * structure[m, 1], a * structure[m, 1] + b * structure[m, 2])
                for j in range(i + 1):
                    H[i, j] += weight * (a * K[m, 0, j] + b * K[m, 1, j])
        mirror(H)
        for i in range(6):
            g[i] -= dot6(prior[i], before) + dot6(prior[i], d)
        delta = solve(H + prior, g)
        largest = 0.0
        for m in range(M):
            largest = max(largest, abs(dot6(J[m, 0], delta)), abs(dot6(J[m, 1], delta)))
        d = d + delta
    return d, H, misfit, correlation, typical
