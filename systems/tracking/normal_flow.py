"""Normal flow: displacement of edge nodes along their normals (paper III-B, eq. 25), several hypotheses a node.

All profiles of a frame are sampled in one call. A peak's place is found to a fraction of a pixel by a parabola through the gradient's
magnitude; near the pose, by the centroid of the gradient about the sharp peak. The paper quantises normals to 0, 45, 90 and 135 degrees;
``quantise`` offers that for comparison.
"""

from dataclasses import dataclass
from functools import lru_cache

import cv2
import numpy as np

from vipr.systems.compiled import compiled
from vipr.systems.tracking.centroids import to_centroids
from vipr.systems.tracking.visible_edges import Nodes

SHARP = 0.7  # px, width of the derivative in the last pass: neighbouring print hardly moves its peaks
LEAST_PX, LEAST_SHARP_PX = (
    0.2,
    0.03,
)  # px, noise of a place found by the wide derivative, and by the sharp one with the centroid
PER_NOISE = 0.8  # px of the latter for pixel noise as strong as the edge
CLEAR_OF_NOISE = 6.0  # standard deviations of the sharp derivative's noise


@dataclass(frozen=True, eq=False)
class Patch:
    """A rectangle of the image in float32 grey levels, and where it lies: ``pixel - origin`` is the position in it."""

    grey: np.ndarray  # (h, w) float32
    origin: np.ndarray  # (2,) x, y [px]
    noise: float = 0.0  # RMS grey levels of pixel noise, estimated
    colour: np.ndarray | None = None  # (h, w, 3) float32 BGR of a colour image


@dataclass(frozen=True, eq=False)
class Matches:
    """Edge hypotheses for each of N nodes; a missing one has strength 0."""

    offset: np.ndarray  # (N, K) px along the normal
    strength: np.ndarray  # (N, K) signed grey levels of the step, brighter on the side of +normal when positive
    reach: float  # px
    wide: int  # the first so many hypotheses are of the wide derivative, the others of the sharp one


def cut_patch(image: np.ndarray, low: np.ndarray, high: np.ndarray, colour: bool = True) -> Patch:
    """The image (h, w[, 3]) uint8 between pixels low and high (2,), cut to the frame; with its colours if they are wanted.

    An empty intersection gives a patch of a few dark pixels far away, on which no edge is ever found.
    """
    height, width = image.shape[:2]
    x0, y0 = (int(max(v, 0)) for v in np.floor(low))
    x1, y1 = (int(min(v + 1, limit)) for v, limit in zip(np.ceil(high), (width, height), strict=True))
    if x1 - x0 < 2 or y1 - y0 < 2:
        return Patch(np.zeros((2, 2), np.float32), np.array([1e6, 1e6]))
    part = image[y0:y1, x0:x1]
    grey = cv2.cvtColor(part, cv2.COLOR_BGR2GRAY) if part.ndim == 3 else np.ascontiguousarray(part)
    shades = part.astype(np.float32) if colour and part.ndim == 3 else None
    return Patch(grey.astype(np.float32), np.array([x0, y0], float), _noise(grey), shades)


@compiled
def _noise(grey):
    """Robust RMS pixel noise of a grey image (h, w) uint8: median absolute value of a [1 -2 1] response in rows that lie apart."""
    height, width = grey.shape
    counts, total = np.zeros(511, np.int64), 0
    for y in range(0, height, max(1, height // 24)):
        for x in range(1, width - 1):
            counts[abs(int(grey[y, x - 1]) - 2 * int(grey[y, x]) + int(grey[y, x + 1]))] += 1
            total += 1
    below = 0
    for value in range(511):
        if 2 * (below + counts[value]) >= total:  # as if the equal ones were spread over half a level either way
            share = (0.5 * total - below) / max(counts[value], 1)
            return max(value - 0.5 + share, 0.0) / 0.6745 / 6.0**0.5
        below += counts[value]
    return 0.0


@compiled
def bilinear(grey, x, y):
    """Grey level of a patch (h, w) float32 between its pixels; outside, that of the border."""
    height, width = grey.shape
    x, y = x if x > 0.0 else 0.0, y if y > 0.0 else 0.0  # nan is no place either
    x, y = min(x, width - 1.0), min(y, height - 1.0)
    left, top = min(int(x), width - 2), min(int(y), height - 2)
    a, b = np.float32(x - left), np.float32(y - top)
    above = grey[top, left] + a * (grey[top, left + 1] - grey[top, left])
    below = grey[top + 1, left] + a * (grey[top + 1, left + 1] - grey[top + 1, left])
    return above + b * (below - above)


def sample_profiles(
    patch: Patch, pixel: np.ndarray, normal: np.ndarray, reach: float, step: float = 1.0, across: int = 3
) -> np.ndarray:
    """Grey levels (N, 1, L), or colours (N, 3, L), along the normals from -reach to reach [px].

    Each is the mean of `across` parallel lines 1 px apart.
    """
    half = int(np.ceil(reach / step))
    s = np.arange(-half, half + 1, dtype=np.float32) * np.float32(step)
    base, n = (pixel - patch.origin).astype(np.float32), normal.astype(np.float32)
    side = (np.arange(across, dtype=np.float32) - np.float32(0.5 * (across - 1)))[:, None]
    x, y = base[:, 0] - side * n[:, 1], base[:, 1] + side * n[:, 0]
    lines = (across * len(pixel), len(s))
    x, y = x[..., None] + n[:, :1] * s, y[..., None] + n[:, 1:] * s
    values = cv2.remap(
        patch.grey if patch.colour is None else patch.colour,
        x.reshape(lines),
        y.reshape(lines),
        cv2.INTER_LINEAR,
        borderMode=cv2.BORDER_REPLICATE,
    )
    return _mean_of_lines(values.reshape(across, len(pixel), len(s), -1))


@compiled
def _mean_of_lines(values):
    """(N, C, L) from (lines, N, L, C)."""
    A, N, L, C = values.shape
    mean = np.empty((N, C, L), np.float32)
    for n in range(N):
        for c in range(C):
            for k in range(L):
                total = values[0, n, k, c]
                for a in range(1, A):
                    total += values[a, n, k, c]
                mean[n, c, k] = total / np.float32(A)
    return mean


@lru_cache(maxsize=32)
def _derivative_kernel(sigma: float, step: float) -> np.ndarray:
    """Derivative of a Gaussian, scaled so that a step of one grey level gives a peak of one."""
    half = max(1, int(np.ceil(2.5 * sigma / step)))
    x = np.arange(-half, half + 1) * step
    k = x * np.exp(-0.5 * (x / sigma) ** 2)
    return (k / k[k > 0].sum()).astype(np.float32)


def find_edges(
    patch: Patch,
    nodes: Nodes,
    reach: float,
    *,
    sigma: float = 1.5,
    contrast: float = 4.0,
    hypotheses: int = 4,
    across: int = 3,
    quantise: bool = False,
    sharp_reach: float = 0.0,
) -> Matches:
    """Edges within reach [px] along each node's normal: local maxima of the gradient of at least `contrast` grey levels.

    sigma [px] is the width of the derivative; in a colour image each place counts by its strongest channel. With sharp_reach,
    as many edges more are given within that distance by a derivative of width SHARP, where they are clear of the noise. With
    `quantise`, normals are rounded to multiples of 45 degrees and places to whole pixels, as the paper has it.
    """
    step = 0.5 if sharp_reach > 0 else 1.0
    normal = quantised(nodes.normal) if quantise else nodes.normal
    kernel = _derivative_kernel(sigma, step)
    margin = len(kernel) // 2 + 1  # one sample more at each end, for the parabola
    K = hypotheses
    if not len(nodes):
        columns = K * (1 + (sharp_reach > 0))
        return Matches(np.zeros((0, columns)), np.zeros((0, columns)), reach, K)
    raw = sample_profiles(patch, nodes.pixel, normal, reach + margin * step, step, across)
    offset, strength, _ = _peaks(raw, kernel, margin, step, contrast, K, quantise)
    if sharp_reach > 0:
        sharp_reach = min(sharp_reach, reach)
        skip = margin + round((reach - sharp_reach) / step)
        floor = max(contrast, CLEAR_OF_NOISE * 0.6 * patch.noise)
        sharp = _peaks(raw, _derivative_kernel(SHARP, step), skip, step, floor, K, quantise)
        if not quantise:
            to_centroids(raw, *sharp, step)
        offset, strength = np.concatenate([offset, sharp[0]], 1), np.concatenate([strength, sharp[1]], 1)
    if quantise:  # a step along a rounded normal is longer or shorter along the true one
        offset = offset * (normal * nodes.normal).sum(1)[:, None]
    return Matches(offset, strength, reach, K)


@compiled
def _peaks(profiles, kernel, margin, step, contrast, count, whole):
    """Places (N, count) [px], signed strengths and channels of the strongest gradients of profiles (N, C, L), margin samples left out at
    each end.
    """
    N, C, L = profiles.shape
    half, length = len(kernel) // 2, L - 2 * margin + 2
    offset, strength, channel = np.zeros((N, count)), np.zeros((N, count)), np.zeros((N, count), np.int64)
    one, response, magnitude = np.empty(length, np.float32), np.empty(length, np.float32), np.empty(length, np.float32)
    strongest = np.zeros(length, np.int64)
    for n in range(N):
        for c in range(C):
            line = profiles[n, c]
            one[:] = 0.0
            for t in range(1, half + 1):
                k = kernel[half + t]
                for j in range(length):
                    one[j] += k * (line[margin - 1 + j + t] - line[margin - 1 + j - t])
            for j in range(length):
                if c == 0 or abs(one[j]) > magnitude[j]:  # the strongest channel
                    response[j], magnitude[j], strongest[j] = one[j], abs(one[j]), c
        for j in range(1, length - 1):
            left, mid, right = magnitude[j - 1], magnitude[j], magnitude[j + 1]
            if not (mid >= left and mid > right and mid > contrast):
                continue
            k = count - 1  # strongest first
            if mid <= abs(strength[n, k]):
                continue
            while k > 0 and mid > abs(strength[n, k - 1]):
                strength[n, k], offset[n, k] = strength[n, k - 1], offset[n, k - 1]
                channel[n, k] = channel[n, k - 1]
                k -= 1
            shift = 0.0
            if not whole:
                shift = min(max(0.5 * (left - right) / min(left - 2.0 * mid + right, -1e-6), -1.0), 1.0)
            strength[n, k], offset[n, k] = response[j], (j + shift - 0.5 * (length - 1)) * step
            channel[n, k] = strongest[j]
    return offset, strength, channel


def noise_px(strength: np.ndarray, wide: int, noise: float) -> np.ndarray:
    """(N, K) px, noise of the places of edges of these strengths (N, K) at a pixel noise [grey levels]; sharp ones from column wide on."""
    px = np.full(strength.shape, LEAST_PX)
    weak = PER_NOISE * noise / np.maximum(np.abs(strength[:, wide:]), 1e-3)
    px[:, wide:] = np.minimum(np.hypot(LEAST_SHARP_PX, weak), LEAST_PX)
    return px


def quantised(normal: np.ndarray) -> np.ndarray:
    """Normals (N, 2) rounded to 0, 45, 90 or 135 degrees, as steps between pixels: length 1 or sqrt(2)."""
    angle = np.round(np.arctan2(normal[:, 1], normal[:, 0]) / (np.pi / 4)) * (np.pi / 4)
    return np.round(np.stack([np.cos(angle), np.sin(angle)], 1))
