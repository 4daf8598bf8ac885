"""Limbs of round bodies: where their silhouette is, beside which the shading changes fast.

Of a round body of radius R, what lies a little way d inside the limb is turned away from the line of sight by an angle of which the
cosine grows as the root of 2 d / R. Whatever the light, its brightness is a + c sqrt(d) there, to first order; outside lies the background
b. The strongest gradient is not at the limb but where step and shading together are steepest, up to more than a pixel away. So a, c and b
are fitted to what is clear of the limb's own pixels, and the limb is where the sum of the brightness across it says: pixels are means
over areas, of which the sum does not depend on where they begin.
"""

from dataclasses import replace

import numpy as np

from vipr.systems.compiled import compiled
from vipr.systems.tracking.cad_model import CadModel
from vipr.systems.tracking.normal_flow import Matches, Patch, sample_profiles
from vipr.systems.tracking.parallel_edges import UNSURE
from vipr.systems.tracking.visible_edges import Nodes

CLEAR, INSIDE, OUTSIDE = 1.0, 6.0, 2.5  # px from the limb: what is fitted lies between the first and one of the others
ACROSS = 1.25  # px on either side, over which brightness is summed
FARTHEST = 2.2  # px from its node
STEP, LINES = 0.5, 3  # px between samples; parallel lines whose mean is taken
ITERATIONS = 8
MOST_PX, STILL_PX = 0.4, 0.05  # of one iteration: at most, and where the place has come to rest
FAINTEST = 4.0  # times the noise: a smaller step at the limb says nothing of its place
PER_NOISE = 2.3  # px for noise as strong as the step: that of the sum, and of a and c carried on to the limb
LEAST_PX, MOST_NOISE_PX = 0.05, 1.0
LEAST_GREY = 0.4  # grey levels of noise: no less is believed
PLAIN, SLACK = 2.0, 0.05  # times the noise, and share of the step: what is left over of print or clutter is more


def at_limbs(
    matches: Matches, noise: np.ndarray, patch: Patch, nodes: Nodes, model: CadModel
) -> tuple[Matches, np.ndarray, np.ndarray | float]:
    """The matches with one sharp edge for each node on a limb before a background, where the limb is; their noise (N, K) [px]; and the
    weight (N,) of each node, 1 or `UNSURE`. Nodes beside print or before clutter keep the edges that they have.
    """
    first = len(model.edges)
    limb = (nodes.edge >= first) & (nodes.edge < first + 2 * len(model.cylinders)) & (nodes.inside.sum(1) == 1)
    if not limb.any() or matches.wide == matches.offset.shape[1]:
        return matches, noise, 1.0
    limb = np.flatnonzero(limb)
    sharp = slice(matches.wide, None)
    found = np.where(matches.strength[limb, sharp] != 0.0, matches.offset[limb, sharp], np.inf)
    nearest = found[np.arange(len(limb)), np.abs(found).argmin(1)]
    nearest = np.where(np.isfinite(nearest), nearest, 0.0)
    inward = np.where(nodes.inside[limb, 0], 1.0, -1.0)
    profiles = sample_profiles(
        patch, nodes.pixel[limb], nodes.normal[limb] * inward[:, None], FARTHEST + INSIDE + STEP, STEP, LINES
    )
    grey_noise = max(patch.noise / np.sqrt(LINES), LEAST_GREY)
    place, step, px, plain = _place(profiles, nearest * inward, grey_noise)
    limb, inward, place, step, px = limb[plain], inward[plain], place[plain], step[plain], px[plain]
    offset, strength, noise, weight = matches.offset.copy(), matches.strength.copy(), noise.copy(), np.ones(len(nodes))
    strength[limb, sharp] = 0.0
    offset[limb, matches.wide], strength[limb, matches.wide] = place * inward, step * inward
    noise[limb, matches.wide] = px
    weight[limb[step == 0.0]] = UNSURE
    return replace(matches, offset=offset, strength=strength), noise, weight


@compiled
def _place(profiles, start, grey_noise):
    """Places (N,) [px] of limbs along profiles (N, C, L) from the background to the body, the steps there (N,), the noise (N,) [px] of the
    places, and whether each profile is plain (N,): shading and background alone. Step 0 where there is none near the start (N,). Of several
    channels, that of the least noise.
    """
    N, C, L = profiles.shape
    place, jump, noise, plain = np.zeros(N), np.zeros(N), np.full(N, MOST_NOISE_PX), np.ones(N, np.bool_)
    middle = 0.5 * (L - 1)
    for n in range(N):
        for c in range(C):
            line, e, moved = profiles[n, c], min(max(start[n], -FARTHEST), FARTHEST), np.inf
            step, misfit = 0.0, 0.0
            for _ in range(ITERATIONS):
                count, sq, sqq, sp, sqp, spp = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
                outer, out, out_square = 0.0, 0.0, 0.0
                for j in range(L):
                    d = (j - middle) * STEP - e
                    if CLEAR <= d <= INSIDE:
                        q = np.sqrt(d)
                        count += 1.0
                        sq += q
                        sqq += q * q
                        sp += line[j]
                        sqp += q * line[j]
                        spp += line[j] * line[j]
                    elif CLEAR <= -d <= OUTSIDE:
                        outer += 1.0
                        out += line[j]
                        out_square += line[j] * line[j]
                slope = (sqp - sq * sp / count) / (sqq - sq * sq / count)
                level, background = (sp - slope * sq) / count, out / outer
                step = level - background
                square = spp - level * sp - slope * sqp + out_square - background * out
                misfit = np.sqrt(max(square, 0.0) / (count + outer - 3.0))
                if abs(step) < FAINTEST * grey_noise:
                    step = 0.0
                    break
                expected = (level + background) * ACROSS + slope * ACROSS**1.5 / 1.5
                off = (expected - (_sum(line, e + ACROSS, middle) - _sum(line, e - ACROSS, middle))) / step
                moved = abs(off)
                e += min(max(off, -MOST_PX), MOST_PX)
                if abs(e) > FARTHEST or moved < 0.2 * STILL_PX:
                    break
            plain[n] &= misfit < PLAIN * grey_noise + SLACK * abs(step)
            if step == 0.0 or abs(e) > FARTHEST or moved > STILL_PX:
                continue
            own = min(np.hypot(LEAST_PX, PER_NOISE * max(misfit, grey_noise) / abs(step)), MOST_NOISE_PX)
            if jump[n] == 0.0 or own < noise[n]:
                place[n], jump[n], noise[n] = e, step, own
    return place, jump, noise, plain


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
