"""Places of sharp edges to a hundredth of a pixel, wherever in a pixel they lie.

Pixels are means over areas, so that a step inside one of them is spread over it and its neighbours, unevenly. The peak of its derivative
is off by up to 0.1 px, one way or the other with the place of the edge within the pixel, which does not average out along an edge that
crosses few rows or columns. The centroid of the gradient of what lies between the pixels (bilinear) is exact: what the pixel shares with
its neighbours on either side, it shares in proportion. The window holds all of a sharp step and little of what is beside it.
"""

import numpy as np

from vipr.systems.compiled import compiled

WINDOW = 1.25  # px on either side, of the gradient whose centroid is taken
MOST = 0.5  # px, as far as a centroid may be from its peak


@compiled
def to_centroids(profiles, offset, strength, channel, step):
    """Moves the places of edges (N, K) [px from the middle] from the sharp derivative's peaks to the centroids of the gradient about them.

    profiles (N, C, L) are sampled every step [px]; strength (N, K): 0 where there is no edge; channel (N, K): which one shows it.
    """
    L = profiles.shape[2]
    middle = 0.5 * (L - 1)
    for n in range(len(profiles)):
        for k in range(offset.shape[1]):
            if strength[n, k] == 0.0:
                continue
            line, peak = profiles[n, channel[n, k]], offset[n, k]
            centre = peak
            for _ in range(2):
                first = max(int(np.ceil((centre - WINDOW) / step + middle - 1.0)), 0)
                last = min(int((centre + WINDOW) / step + middle), L - 2)
                total, moment = 0.0, 0.0
                for j in range(first, last + 1):
                    place = (j + 0.5 - middle) * step
                    share = min(max((WINDOW + 0.5 * step - abs(place - centre)) / step, 0.0), 1.0)
                    gradient = share * (line[j + 1] - line[j])
                    total += gradient
                    moment += gradient * (place - peak)
                if total * strength[n, k] <= 0.0:
                    break
                centre = peak + min(max(moment / total, -MOST), MOST)
            offset[n, k] = centre
