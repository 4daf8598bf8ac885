"""Limbs of round bodies: where their silhouette is, beside which the shading changes fast.

Of a round body of radius R, the surface a little way d inside the limb faces the camera by q = sqrt(t (2 - t)), t = d / R, and sideways
by 1 - t. Light from somewhere makes it as bright as a sum of both, light from everywhere adds a constant: a (1 - t / 2) + c q serves for a
mixture; outside lies the background b. The strongest gradient is not at the limb but where step and shading together are steepest, up to
more than a pixel away. So a, c and b are fitted to what is clear of the limb's own pixels, and the limb is where the sum of the brightness
across it says: pixels are means over areas, of which the sum does not depend on where they begin. Where a light goes out within the pixel
at the limb, it is brighter there than the fit can know: an error that the nodes of a limb have in common.
"""

from dataclasses import replace

import numpy as np

from vipr.systems.camera.lens import Lens
from vipr.systems.compiled import compiled
from vipr.systems.tracking.cad_model import CadModel
from vipr.systems.tracking.normal_flow import Matches, Patch, sample_profiles
from vipr.systems.tracking.parallel_edges import UNSURE
from vipr.systems.tracking.visible_edges import Nodes

CLEAR, INSIDE, OUTSIDE = 1.0, 4.0, 2.5  # px from the limb: what is fitted lies between the first and one of the others
ACROSS = 1.25  # px on either side, over which brightness is summed
FARTHEST = 2.2  # px from its node
STEP, LINES = 0.5, 9  # px between samples; parallel lines whose mean is taken
BLUR = 1.0 / 12.0 + 1.0 / 6.0  # px^2, variance of a pixel's width and of what lies between pixels
ALIKE = 0.3  # px: places that are the same
ITERATIONS = 8
MOST_PX, STILL_PX = 0.4, 0.05  # of one iteration: at most, and where the place has come to rest
FAINTEST = 4.0  # times the noise: a smaller step at the limb says nothing of its place
PER_NOISE = 2.3  # px for noise as strong as the step: that of the sum, and of a and c carried on to the limb
LEAST_PX, MOST_NOISE_PX = 0.05, 1.0
LEAST_GREY = 0.4  # grey levels of noise: no less is believed
PLAIN, SLACK = 2.0, 0.05  # times the noise, and share of the step: what is left over of print or clutter is more
UNKNOWN = 0.5  # of what the place would be off by if all shading ended a pixel inside the limb


def at_limbs(
    matches: Matches, noise: np.ndarray, patch: Patch, nodes: Nodes, model: CadModel, lens: Lens
) -> tuple[Matches, np.ndarray, np.ndarray | float, np.ndarray | float]:
    """The matches with one sharp edge for each node on a limb before a background, where the limb is; their noise (N, K) [px]; the weight
    (N,) of each node, 1 or `UNSURE`; and the error (N,) [px] that it may have in common with its neighbours. Nodes beside print or before
    clutter keep the edges that they have.
    """
    first = len(model.edges)
    limb = (nodes.edge >= first) & (nodes.edge < first + 2 * len(model.cylinders)) & (nodes.inside.sum(1) == 1)
    if not limb.any() or matches.wide == matches.offset.shape[1]:
        return matches, noise, 1.0, 0.0
    limb = np.flatnonzero(limb)
    sharp = slice(matches.wide, None)
    found = np.where(matches.strength[limb, sharp] != 0.0, matches.offset[limb, sharp], np.inf)
    nearest = found[np.arange(len(limb)), np.abs(found).argmin(1)]
    nearest = np.where(np.isfinite(nearest), nearest, 0.0)
    inward = np.where(nodes.inside[limb, 0], 1.0, -1.0)
    profiles = sample_profiles(
        patch, nodes.pixel[limb], nodes.normal[limb] * inward[:, None], FARTHEST + INSIDE + STEP, STEP, LINES
    )
    focal = np.hypot(lens.fx * nodes.normal[limb, 0], lens.fy * nodes.normal[limb, 1])
    radius = np.array([c[6] for c in model.cylinders])[(nodes.edge[limb] - first) // 2] * focal / nodes.depth[limb]
    grey_noise = max(patch.noise / np.sqrt(LINES), LEAST_GREY)
    place, step, px, common, plain = _place(profiles, nearest * inward, radius, grey_noise)
    limb, inward, place, step, px, common = (part[plain] for part in (limb, inward, place, step, px, common))
    offset, strength, noise = matches.offset.copy(), matches.strength.copy(), noise.copy()
    weight, shared = np.ones(len(nodes)), np.zeros(len(nodes))
    strength[limb, sharp] = 0.0
    offset[limb, matches.wide], strength[limb, matches.wide] = place * inward, step * inward
    noise[limb, matches.wide], shared[limb] = px, common
    weight[limb[step == 0.0]] = UNSURE
    return replace(matches, offset=offset, strength=strength), noise, weight, shared


@compiled
def _place(profiles, start, radius, grey_noise):
    """Places (N,) [px] of limbs of bodies of radius (N,) [px] along profiles (N, C, L) from the background to the body, the steps there
    (N,), the noise and the common error (N,) [px] of the places, and whether each profile is plain (N,): shading and background alone. Step
    0 where none is found from the middle or the start (N,), or not the same. Of several channels, that of the least noise.
    """
    N, C, _ = profiles.shape
    place, jump, plain = np.zeros(N), np.zeros(N), radius > INSIDE
    noise, common = np.full(N, MOST_NOISE_PX), np.zeros(N)
    for n in range(N):
        for c in range(C):
            e, step, misfit, hidden = _settle(profiles[n, c], 0.0, radius[n], grey_noise)
            if step == 0.0 or abs(start[n] - e) > ALIKE:
                other = _settle(profiles[n, c], start[n], radius[n], grey_noise)
                if step == 0.0:
                    e, step, misfit, hidden = other
                elif other[1] != 0.0 and abs(other[0] - e) > ALIKE:
                    step = 0.0  # one as good as the other
            plain[n] &= misfit < PLAIN * grey_noise + SLACK * abs(step)
            if step == 0.0:
                continue
            own = min(np.hypot(LEAST_PX, PER_NOISE * max(misfit, grey_noise) / abs(step)), MOST_NOISE_PX)
            if jump[n] == 0.0 or own < noise[n]:
                place[n], jump[n], noise[n] = e, step, own
                common[n] = min(UNKNOWN * abs(hidden / step), MOST_NOISE_PX)
    return place, jump, noise, common, plain


@compiled
def _settle(line, e, R, grey_noise):
    """(place [px], step, RMS misfit, how much darker shading makes the last pixel before the limb) of the limb along a profile (L,), from a
    place e; step 0 where there is none.
    """
    L = len(line)
    middle, moved, step, misfit, slope = 0.5 * (L - 1), np.inf, 0.0, 0.0, 0.0
    e = min(max(e, -FARTHEST), FARTHEST)
    for _ in range(ITERATIONS):
        bb, bq, qq, bp, qp, pp, count = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
        outer, out, out_square = 0.0, 0.0, 0.0
        for j in range(L):
            d = (j - middle) * STEP - e
            if CLEAR <= d <= INSIDE:
                t = min(d / R, 1.0)
                b, q = 1.0 - 0.5 * t, np.sqrt(t * (2.0 - t))
                q -= 0.5 * BLUR / (q**3 * R * R)
                count += 1.0
                bb += b * b
                bq += b * q
                qq += q * q
                bp += b * line[j]
                qp += q * line[j]
                pp += line[j] * line[j]
            elif CLEAR <= -d <= OUTSIDE:
                outer += 1.0
                out += line[j]
                out_square += line[j] * line[j]
        level, slope = (qq * bp - bq * qp) / (bb * qq - bq * bq), (bb * qp - bq * bp) / (bb * qq - bq * bq)
        background = out / outer
        step = level - background
        square = pp - level * bp - slope * qp + out_square - background * out
        misfit = np.sqrt(max(square, 0.0) / (count + outer - 3.0))
        if abs(step) < FAINTEST * grey_noise:
            return e, 0.0, misfit, 0.0
        t = min(ACROSS / R, 1.0)
        body = level * (1.0 - 0.25 * t) + slope * np.sqrt(2.0 * t) * (1.0 / 1.5 - t / 10.0)
        rise = (slope * (1.0 - t) / np.sqrt(t * (2.0 - t)) - 0.5 * level) / R
        expected = (body + background) * ACROSS + 0.5 * BLUR * rise
        off = (expected - (_sum(line, e + ACROSS, middle) - _sum(line, e - ACROSS, middle))) / step
        moved = abs(off)
        e += min(max(off, -MOST_PX), MOST_PX)
        if abs(e) > FARTHEST or moved < 0.2 * STILL_PX:
            break
    if abs(e) > FARTHEST or moved > STILL_PX:
        step = 0.0
    return e, step, misfit, slope * np.sqrt(2.0 / R) / 3.0


@compiled
def _sum(line, x, middle):
    """Integral of a profile from its first sample to x [px from its middle], linear between samples."""
    at = x / STEP + middle
    whole = int(at)
    total = 0.5 * (line[0] - line[whole])
    for j in range(1, whole + 1):
        total += line[j]
    part = at - whole
    return STEP * (total + part * (line[whole] + 0.5 * part * (line[whole + 1] - line[whole])))
