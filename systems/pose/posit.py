"""POSIT: pose from four or more points by iterated scaled orthography, many point sets at once.

Sources: DeMenthon and Davis 1995 (paper III-A) for points that span space; Oberkampf, DeMenthon and Davis 1996 for points in a plane, where
scaled orthography leaves two poses, mirrored about the plane parallel to the image. Frames: O object, C camera (x right, y down, z
forward). Image points are *normalised*: ``x = (u - cx)/fx``, ``y = (v - cy)/fy``, so the focal length is 1. The first point of a set is
its reference point. All functions take leading batch dimensions and never raise on degenerate sets: those come back as NaN.
"""

from dataclasses import dataclass

import numpy as np

from vipr.systems.errors import InputError

FLAT = 0.02  # third over first singular value below which a set counts as planar
THIN = 0.005  # second over first singular value below which a set counts as collinear
MARGIN = 0.1  # depth of every point must exceed this share of the reference point's


@dataclass(frozen=True)
class PositSolution:
    """One pose that POSIT found."""

    X_CO: np.ndarray  # (4, 4)
    error: float  # RMS distance in the normalised image
    iterations: int  # until the perspective terms stood still, or the limit


def spread(points_O: np.ndarray) -> np.ndarray:
    """(..., 3) singular values [m] of the points (..., N, 3) about their mean, largest first."""
    centred = points_O - points_O.mean(axis=-2, keepdims=True)
    return np.sqrt(np.maximum(np.linalg.eigvalsh(np.swapaxes(centred, -1, -2) @ centred)[..., ::-1], 0.0))


def reprojection(points_O: np.ndarray, xy: np.ndarray, X_CO: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Distances (..., N) in the normalised image and depths (..., N) [m]; distance is infinite for points not before the camera."""
    p_C = points_O @ np.swapaxes(X_CO[..., :3, :3], -1, -2) + X_CO[..., None, :3, 3]
    z = p_C[..., 2]
    ahead = z > 0
    projected = p_C[..., :2] / np.where(ahead, z, 1.0)[..., None]
    return np.where(ahead, np.linalg.norm(projected - xy, axis=-1), np.inf), z


def posit(
    points_O: np.ndarray, xy: np.ndarray, *, iterations: int = 50, tolerance: float = 1e-10
) -> list[PositSolution]:
    """Poses of one set of points (N, 3) [m] seen at normalised image points (N, 2), best first.

    One solution for points in space, up to two for points in a plane, none for points on a line or in one place. Raises InputError for
    fewer than four points or for numbers that are not finite.
    """
    points_O, xy = np.asarray(points_O, float), np.asarray(xy, float)
    if points_O.ndim != 2 or points_O.shape[1:] != (3,) or xy.shape != (len(points_O), 2) or len(points_O) < 4:
        raise InputError(
            f"POSIT: needs 4 or more points (N, 3) with as many image points (N, 2), got {points_O.shape} and {xy.shape}"
        )
    if not (np.isfinite(points_O).all() and np.isfinite(xy).all()):
        raise InputError("POSIT: points and image points must be finite numbers, got NaN or infinity")
    singular = spread(points_O)
    if not singular[1] > THIN * singular[0]:
        return []
    solve = posit_coplanar_batch if singular[2] < FLAT * singular[0] else posit_batch
    X_CO, counts = solve(points_O[None], xy[None], iterations=iterations, tolerance=tolerance)
    found = []
    for X, count in zip(X_CO.reshape(-1, 4, 4), np.broadcast_to(counts, X_CO.shape[:-2]).ravel(), strict=True):
        if np.isfinite(X).all():
            distance, _ = reprojection(points_O, xy, X)
            found.append(PositSolution(X, float(np.sqrt(np.mean(distance**2))), int(count)))
    found = sorted((s for s in found if np.isfinite(s.error)), key=lambda s: s.error)
    if len(found) == 2 and np.allclose(found[0].X_CO, found[1].X_CO, atol=1e-7):
        found.pop()
    return found


def posit_batch(points_O, xy, *, iterations: int = 50, tolerance: float = 1e-10) -> tuple[np.ndarray, np.ndarray]:
    """Poses (H, 4, 4) of H sets of points in space (H, N, 3) seen at (H, N, 2), and iterations (H,); NaN where a set is degenerate."""
    M = points_O[:, 1:] - points_O[:, :1]
    with np.errstate(all="ignore"):
        B = np.linalg.pinv(M, rcond=1e-6)
        perspective = np.zeros((*xy.shape[:1], xy.shape[1] - 1))
        counts = np.full(len(xy), iterations)
        for n in range(1, iterations + 1):
            i_s, j_s = _scaled_axes(B, xy, perspective)
            X_CO = _pose(i_s, j_s, points_O[:, 0], xy[:, 0])
            new = np.einsum("hni,hi->hn", M, X_CO[:, 2, :3]) / _reference_depth(i_s, j_s)[:, None]
            change = np.max(np.abs(new - perspective), axis=1)
            perspective = new
            counts = np.minimum(counts, np.where(change < tolerance, n, iterations))
            if not (change >= tolerance).any():
                break
        return _checked(X_CO, points_O, perspective), counts


def posit_coplanar_batch(
    points_O, xy, *, iterations: int = 50, tolerance: float = 1e-10
) -> tuple[np.ndarray, np.ndarray]:
    """Both poses (H, 2, 4, 4) of H sets of points in a plane (H, N, 3) seen at (H, N, 2), and iterations (H, 2); NaN where degenerate.

    Each branch starts from one root of the two-fold ambiguity and keeps, at every step, the root that projects better.
    """
    M = points_O[:, 1:] - points_O[:, :1]
    with np.errstate(all="ignore"):
        U, s, Vt = np.linalg.svd(M, full_matrices=False)
        s = np.where(s[:, :2] > 1e-9 * s[:, :1], s[:, :2], np.nan)
        B = np.swapaxes(Vt[:, :2] / s[..., None], 1, 2) @ np.swapaxes(U[:, :, :2], 1, 2)
        normal = Vt[:, 2]
        # Branches as a second batch dimension; B, points and image are shared.
        B, M, normal = B[:, None], M[:, None], normal[:, None]
        points_O, xy = points_O[:, None], xy[:, None]
        perspective = np.zeros((len(xy), 2, xy.shape[2] - 1))
        counts = np.full(perspective.shape[:2], iterations)
        for n in range(1, iterations + 1):
            I0, J0 = _scaled_axes(B, xy, perspective)
            # (lam + i mu)^2 = |J0|^2 - |I0|^2 - 2i I0.J0 makes the axes equally long and orthogonal.
            square = np.sum(J0 * J0, -1) - np.sum(I0 * I0, -1) - 2j * np.sum(I0 * J0, -1)
            root = np.sqrt(square)[..., None]
            plus = I0 + root.real * normal, J0 + root.imag * normal
            minus = I0 - root.real * normal, J0 - root.imag * normal
            X_plus, X_minus = (_pose(*axes, points_O[..., 0, :], xy[..., 0, :]) for axes in (plus, minus))
            if n == 1:
                first = np.array([True, False])[None, :, None]
            else:
                first = (_misfit(points_O, xy, X_plus) <= _misfit(points_O, xy, X_minus))[..., None]
            i_s, j_s = np.where(first, plus[0], minus[0]), np.where(first, plus[1], minus[1])
            X_CO = np.where(first[..., None], X_plus, X_minus)
            new = np.einsum("...ni,...i->...n", M, X_CO[..., 2, :3]) / _reference_depth(i_s, j_s)[..., None]
            change = np.max(np.abs(new - perspective), axis=-1)
            perspective = new
            counts = np.minimum(counts, np.where(change < tolerance, n, iterations))
            if not (change >= tolerance).any():
                break
        return _checked(X_CO, points_O, perspective), counts


def _scaled_axes(B, xy, perspective):
    """The first two camera axes in O, times 1/Z0: (..., 3) each (the I and J of the paper)."""
    scaled = xy[..., 1:, :] * (1.0 + perspective[..., None]) - xy[..., :1, :]
    axes = B @ scaled
    return axes[..., 0], axes[..., 1]


def _reference_depth(i_s, j_s):
    return 1.0 / np.sqrt(np.linalg.norm(i_s, axis=-1) * np.linalg.norm(j_s, axis=-1))


def _pose(i_s, j_s, reference_O, reference_xy):
    """Poses whose first two axes are nearest to the scaled ones: the two are orthogonalised evenly, neither is preferred."""
    i = i_s / np.linalg.norm(i_s, axis=-1, keepdims=True)
    j = j_s / np.linalg.norm(j_s, axis=-1, keepdims=True)
    k = np.cross(i, j)
    k /= np.linalg.norm(k, axis=-1, keepdims=True)
    middle = i + j
    middle /= np.linalg.norm(middle, axis=-1, keepdims=True)
    across = np.cross(k, middle)
    i, j = (middle - across) / np.sqrt(2.0), (middle + across) / np.sqrt(2.0)
    X_CO = np.zeros((*i.shape[:-1], 4, 4))
    X_CO[..., 0, :3], X_CO[..., 1, :3], X_CO[..., 2, :3], X_CO[..., 3, 3] = i, j, k, 1.0
    depth = _reference_depth(i_s, j_s)[..., None]
    reference_C = np.concatenate([np.broadcast_to(reference_xy, (*depth.shape[:-1], 2)) * depth, depth], axis=-1)
    X_CO[..., :3, 3] = reference_C - np.einsum("...ij,...j->...i", X_CO[..., :3, :3], reference_O)
    return X_CO


def _misfit(points_O, xy, X_CO):
    distance, z = reprojection(points_O, xy, X_CO)
    return np.where((z > 0).all(axis=-1), np.sum(distance**2, axis=-1), np.inf)


def _checked(X_CO, points_O, perspective):
    """NaN for poses that are not finite or put a point beside or behind the camera."""
    good = np.isfinite(X_CO).all(axis=(-2, -1)) & (np.min(perspective, axis=-1) > MARGIN - 1.0)
    z0 = np.einsum("...i,...i->...", X_CO[..., 2, :3], points_O[..., 0, :]) + X_CO[..., 2, 3]
    return np.where((good & (z0 > 0))[..., None, None], X_CO, np.nan)
