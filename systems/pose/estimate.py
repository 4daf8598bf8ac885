"""Pose of an object from points and pixels: POSIT, refinement, wrong matches thrown out, covariance.

The POSE box of paper III-A. Frames: O object, C camera (x right, y down, z forward). Units: m and px.
"""

from dataclasses import dataclass, field
from itertools import combinations
from math import comb

import numpy as np
from scipy.special import fdtri

from vipr.systems import se3
from vipr.systems.camera.lens import Lens
from vipr.systems.errors import InputError
from vipr.systems.pose import lowe, posit

METHODS = ("projective", "lowe", "posit")
HYPOTHESES = 300  # minimal sets tried: with 40 % of the matches wrong, one clean set in 8, all 300 spoilt once in 10^17
AMBIGUOUS = 1.5  # ratio of the errors of two poses below which neither can be ruled out, however many points
DISTINCT = np.radians(2.0)  # poses closer than this are one


@dataclass(frozen=True, eq=False)
class PoseEstimate:
    """A pose with its uncertainty, or why there is none."""

    X_CO: np.ndarray = field(default_factory=lambda: np.eye(4))  # (4, 4); means nothing unless valid
    covariance: np.ndarray = field(default_factory=lambda: np.full((6, 6), np.inf))
    """(6, 6) of (w, v): rotation vector in C about the origin of O [rad], position of O in C [m]."""
    inliers: np.ndarray = field(default_factory=lambda: np.zeros(0, bool))  # (N,) matches believed
    residual_px: float = float("nan")  # RMS distance of the believed matches
    sigma_px: float = float("nan")  # estimated standard deviation of one pixel coordinate
    alternatives: tuple[tuple[np.ndarray, float], ...] = ()  # other poses with their RMS distance [px], best first
    ambiguous: bool = False  # an alternative fits nearly as well: points in a plane seen from afar
    iterations: int = 0  # of the refinement (of POSIT for method posit)
    valid: bool = False
    reason: str = ""  # why not valid


def estimate_pose(
    points_O: np.ndarray,
    pixels: np.ndarray,
    lens: Lens,
    *,
    method: str = "projective",
    robust: bool = True,
    X_CO_start: np.ndarray | None = None,
    loss: str = "tukey",
    seed: int = 0,
) -> PoseEstimate:
    """Pose X_CO of matched points (N, 3) [m] and pixels (N, 2) of the undistorted image; points in space or in a plane, N >= 4.

    method: ``projective`` (POSIT, then the fully projective refinement), ``lowe`` (POSIT, then Lowe's) or ``posit`` alone. robust: up to
    about 40 % of the matches may be wrong; minimal sets are tried by POSIT and the best are refined by an M-estimator (loss ``huber``
    or ``tukey``). X_CO_start: refine from there instead of searching; a tracker's way, and the fast one.

    Degenerate sets (points on a line or in one place, no pose with all points before the camera) give an estimate with ``valid`` false and
    the reason. Raises InputError for wrong shapes, fewer than four points, NaN, an unknown method or loss.
    """
    points_O, pixels = _checked(points_O, pixels)
    if method not in METHODS:
        raise InputError(f"pose: unknown method {method!r}, allowed are {', '.join(METHODS)}")
    if loss not in lowe.LOSSES:
        raise InputError(f"pose: unknown loss {loss!r}, allowed are {', '.join(lowe.LOSSES)}")
    singular = posit.spread(points_O)
    if singular[0] < 1e-9:
        return PoseEstimate(inliers=np.zeros(len(points_O), bool), reason="all points are in one place")
    if singular[1] < posit.THIN * singular[0]:
        return PoseEstimate(inliers=np.zeros(len(points_O), bool), reason="the points are on one line")
    if np.ptp(pixels, axis=0).max() < 1e-6:
        return PoseEstimate(inliers=np.zeros(len(points_O), bool), reason="all pixels are in one place")
    xy = (pixels - (lens.cx, lens.cy)) / (lens.fx, lens.fy)
    if X_CO_start is not None:
        if not se3.is_pose(X_CO_start):
            raise InputError("pose: X_CO_start must be a finite 4x4 rigid motion")
        starts = [np.asarray(X_CO_start, float)]
    else:
        starts = _starts_from_all(points_O, xy)
        if robust and len(points_O) > 4:
            starts = _best_hypotheses(points_O, pixels, xy, lens, starts, seed)
    if method == "posit":
        found = [(X, _trimmed(points_O, pixels, lens, X, robust), None) for X in starts]
    else:
        loss = loss if robust and len(points_O) > 4 else "none"
        found = _refined(points_O, pixels, lens, starts, method, loss, robust)
        if X_CO_start is None and singular[2] < 10 * posit.FLAT * singular[0]:
            best = min(found, key=lambda f: f[1])[0]
            found += _refined(points_O, pixels, lens, [_mirrored(points_O, best)], method, loss, robust)
    found = sorted((f for f in found if np.isfinite(f[1])), key=lambda f: f[1])
    if not found:
        return PoseEstimate(inliers=np.zeros(len(points_O), bool), reason="no pose puts all points before the camera")
    return _report(points_O, pixels, lens, found, method, robust and len(points_O) > 4)


def _checked(points_O, pixels):
    try:
        points_O, pixels = np.asarray(points_O, float), np.asarray(pixels, float)
    except (TypeError, ValueError):
        raise InputError("pose: points and pixels must be arrays of numbers") from None
    if points_O.ndim != 2 or points_O.shape[1] != 3 or pixels.shape != (len(points_O), 2):
        raise InputError(f"pose: needs points (N, 3) with pixels (N, 2), got {points_O.shape} and {pixels.shape}")
    if len(points_O) < 4:
        raise InputError(f"pose: needs at least 4 points, got {len(points_O)}")
    if not (np.isfinite(points_O).all() and np.isfinite(pixels).all()):
        raise InputError("pose: points and pixels must be finite numbers, got NaN or infinity")
    return points_O, pixels


def _starts_from_all(points_O, xy):
    """Poses of POSIT on all points; where those are nearly flat, of both kinds."""
    starts = [s.X_CO for s in posit.posit(points_O, xy, iterations=30)]
    singular = posit.spread(points_O)
    if not starts or posit.FLAT <= singular[2] / singular[0] < 10 * posit.FLAT:
        X_CO, _ = posit.posit_coplanar_batch(points_O[None], xy[None], iterations=30)
        starts += [X for X in X_CO.reshape(-1, 4, 4) if np.isfinite(X).all()]
    return starts or _coarse_starts(points_O, xy)


def _coarse_starts(points_O, xy):
    """Where POSIT fails (an object nearly as deep as it is far): 24 orientations at the distance that the image size tells."""
    size, seen = np.linalg.norm(posit.spread(points_O)), np.linalg.norm(xy - xy.mean(axis=0))
    depth = size / max(seen, 1e-9)
    centre = np.append(xy.mean(axis=0), 1.0) * depth
    starts = []
    for axis in range(3):
        for sign in (1.0, -1.0):
            z = np.roll([sign, 0.0, 0.0], axis)
            x = np.roll([0.0, 1.0, 0.0], axis)
            for quarter in range(4):
                a = quarter * np.pi / 2
                first = np.cos(a) * x + np.sin(a) * np.cross(z, x)
                R = np.array([first, np.cross(z, first), z])
                starts.append(se3.pose(R, centre - R @ points_O.mean(axis=0)))
    return starts


def _mirrored(points_O, X_CO):
    """The pose that looks the same from far away, for points in a plane: mirrored in depth about their centre."""
    centre_O = points_O.mean(axis=0)
    normal_O = np.linalg.svd(points_O - centre_O)[2][2]
    centre_C = X_CO[:3, :3] @ centre_O + X_CO[:3, 3]
    sight = centre_C / np.linalg.norm(centre_C)
    R = (np.eye(3) - 2 * np.outer(sight, sight)) @ X_CO[:3, :3] @ (np.eye(3) - 2 * np.outer(normal_O, normal_O))
    return se3.pose(R, centre_C - R @ centre_O)


def _best_hypotheses(points_O, pixels, xy, lens, starts, seed, keep=4):
    """The poses, of minimal sets and of all points, that the best 60 % of the matches agree with most."""
    n = len(points_O)
    if comb(n, 4) <= HYPOTHESES:
        sets = np.array(list(combinations(range(n), 4)))
    else:
        rng = np.random.default_rng(seed)
        sets = rng.integers(0, n, (HYPOTHESES, 4))  # a set with a point twice is flat or thin, and treated as such
    singular = posit.spread(points_O[sets])
    thick = singular[:, 1] > 0.05 * singular[:, 0]
    solid = thick & (singular[:, 2] > 0.05 * singular[:, 0])
    flat = thick & ~solid
    poses = [np.array(starts).reshape(-1, 4, 4)]
    for chosen, solve in ((solid, posit.posit_batch), (flat, posit.posit_coplanar_batch)):
        if chosen.any():
            X_CO, _ = solve(points_O[sets[chosen]], xy[sets[chosen]], iterations=8, tolerance=1e-4)
            poses.append(X_CO.reshape(-1, 4, 4))
    poses = np.concatenate(poses)
    poses = poses[np.isfinite(poses).all(axis=(1, 2))]
    if not len(poses):
        return starts
    distance, _ = posit.reprojection(points_O, xy, poses)
    order = np.argsort(np.sum(np.partition(distance, _believed(n) - 1, axis=1)[:, : _believed(n)] ** 2, axis=1))
    chosen: list[np.ndarray] = []
    apart = np.ones(len(poses), bool)  # from every chosen one: the rotation between has a trace below 1 + 2 cos(5 deg)
    for i in order:
        if apart[i]:
            chosen.append(poses[i])
            apart &= np.einsum("hij,ij->h", poses[:, :3, :3], poses[i, :3, :3]) < 1.0 + 2.0 * np.cos(np.radians(5.0))
        if len(chosen) == keep:
            break
    return chosen


def _believed(n):
    return max(int(np.ceil(0.6 * n)), min(n, 5))


def _refined(points_O, pixels, lens, starts, method, loss, robust):
    """(X_CO, criterion, refinement) of the starts; wrong matches are first cut off hard, so that they do not set the scale."""
    if loss == "none":
        ends = [lowe.refine(points_O, pixels, lens, X, method=method) for X in starts]
        return [(e.X_CO, _trimmed_residuals(e.residuals, robust), e) for e in ends]
    cut = []
    for X in starts:
        projected, depth = lowe.project(points_O, X[:3, :3], X[:3, 3], lens)
        distance = np.where(depth > lowe.NEAR, np.linalg.norm(projected - pixels, axis=1), np.inf)
        near = np.argsort(distance)[: _believed(len(distance))]
        if np.isfinite(distance[near]).all() and posit.spread(points_O[near])[1] > 1e-6:
            X = lowe.refine(points_O[near], pixels[near], lens, X, method=method, iterations=8, tolerance=1e-4).X_CO
        cut.append((_trimmed(points_O, pixels, lens, X, robust), X))
    cut.sort(key=lambda c: c[0])
    ends = [lowe.refine(points_O, pixels, lens, X, method=method, loss=loss, tolerance=1e-6) for _, X in cut[:2]]
    return [(e.X_CO, _trimmed_residuals(e.residuals, robust), e) for e in ends]


def _trimmed(points_O, pixels, lens, X_CO, robust):
    projected, _ = lowe.project(points_O, X_CO[:3, :3], X_CO[:3, 3], lens)
    return _trimmed_residuals(projected - pixels, robust)


def _trimmed_residuals(residuals, robust):
    """RMS distance [px] of the matches that are believed whatever happens: the best 60 % if robust, all otherwise."""
    squares = np.sum(residuals**2, axis=1)
    if not np.isfinite(squares).all():
        return np.inf
    k = _believed(len(squares)) if robust else len(squares)
    return float(np.sqrt(np.mean(np.sort(squares)[:k])))


def _distinguishable(n):
    """Ratio of two RMS distances of n points that noise alone exceeds once in 20 (F test); few points tell little."""
    freedom = max(2 * n - 6, 1)
    return max(AMBIGUOUS, float(np.sqrt(fdtri(freedom, freedom, 0.95))))


def _report(points_O, pixels, lens, found, method, robust):
    X_CO, _, refinement = found[0]
    n = len(points_O)
    if refinement is None:
        projected, _ = lowe.project(points_O, X_CO[:3, :3], X_CO[:3, 3], lens)
        residuals, weights, iterations = pixels - projected, np.ones(n), 0
    else:
        residuals, weights, iterations = refinement.residuals, refinement.weights, refinement.iterations
    squares = np.sum(residuals**2, axis=1)
    inliers = np.ones(n, bool)
    if robust:
        scale = np.sqrt(np.median(squares)) / 1.1774 * np.sqrt(2 * n / (2 * n - 6)) + 1e-6
        inliers = squares < (3.5 * scale) ** 2
    used = int(inliers.sum())
    sigma = float(np.sqrt(np.sum(squares[inliers]) / max(2 * used - 6, 1)))
    J = lowe.jacobian(points_O, X_CO[:3, :3], X_CO[:3, 3], lens) * (weights * inliers)[:, None, None]
    information = np.einsum("nij,nik->jk", J, lowe.jacobian(points_O, X_CO[:3, :3], X_CO[:3, 3], lens))
    unit = np.array([1.0] * 3 + [max(float(posit.spread(points_O)[0]), 1e-9)] * 3)
    values = np.linalg.eigvalsh(information * np.outer(unit, unit))
    rms = float(np.sqrt(np.mean(squares[inliers]))) if used else float("inf")
    others, best = [], found[0][1]
    for X, criterion, _ in found[1:]:
        if all(se3.angle_between(X[:3, :3], Y[:3, :3]) > DISTINCT for Y in [X_CO, *(o[0] for o in others)]):
            others.append((X, criterion))
    report = dict(
        X_CO=X_CO,
        inliers=inliers,
        residual_px=rms,
        sigma_px=sigma,
        alternatives=tuple(others),
        ambiguous=bool(others) and others[0][1] < _distinguishable(used) * best,
        iterations=iterations,
    )
    if used < 4 or not values[0] > 1e-12 * values[-1]:
        return PoseEstimate(**report, reason=f"{used} believed matches do not determine a pose")
    covariance = sigma**2 * np.linalg.inv(information * np.outer(unit, unit)) * np.outer(unit, unit)
    return PoseEstimate(**report, covariance=covariance, valid=True)
