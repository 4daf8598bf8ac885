"""Self-diagnosis: is the object really where the tracker believes it to be?

Two kinds of evidence, each corrected for what chance would give: the share of the nodes that have an edge where the model says (chance: how
densely edges lie along the search lines anyway), and the share of the texture patches that look as they were learnt.
"""

import math
from dataclasses import dataclass

import numpy as np

from vipr.systems.compiled import compiled
from vipr.systems.tracking.keyframes import Keyframe
from vipr.systems.tracking.normal_flow import Matches
from vipr.systems.tracking.pose_fit import Fit
from vipr.systems.tracking.texture import TextureFit

NEAR = 1.5  # px: an edge within this supports its node
CLOSE = 0.3  # px: residuals of a sharp picture at the right pose are smaller
WRONG = 0.23  # closeness and a quarter of the share of supported nodes: at wrong poses they come to less
TRACKING, LOST = 0.5, 0.15  # score above which the pose can be used, below which it means nothing


@dataclass(frozen=True)
class Evidence:
    """What speaks for a pose."""

    edges: float = 0.0  # -1 to 1, share of supported nodes beyond chance; 1 is perfect, 0 is chance
    nodes: int = 0  # supported
    texture: float = 0.0  # significance of the patches that look right, standard deviations
    patches: int = 0  # compared
    sigma: float = float("nan")  # px, robust RMS residual
    trust: float = 1.0  # 0 to 1, how sure the keyframe's own pose was
    given: float = 0.0  # 0 to 1, how well a pose given from outside agrees
    unproven: bool = False  # it was not tracked before, and its texture cannot be compared
    quality: float = 0.0  # 0 to 1, how closely and how strongly the nodes' edges fit: compares attempts at one image
    # 0 to 1, how closely alone, and to a fraction of a pixel: tells an edge from a line of print beside it.
    closeness: float = 0.0

    @property
    def by_edges(self) -> float:
        """0 to 1, probability that the pose is right by the edges alone."""
        return _logistic(-3.6 + 9.0 * self.edges) if self.nodes >= 8 else 0.0

    @property
    def score(self) -> float:
        """0 to 1, the probability that the pose is right."""
        if self.nodes < 8:
            return 0.0
        z, by_texture = -3.6 + 9.0 * self.edges, 0.0
        if self.patches >= 8:
            # Patches that agree while the edges do not: they may have been learnt at a wrong pose.
            by_texture = self.trust * _logistic(1.2 * (self.texture - 4.5)) * min(max(0.4 + 2.0 * self.edges, 0.3), 1.0)
        by_edges = _logistic(z)
        if (self.unproven or (self.patches >= 8 and self.texture < 4.0)) and self.edges < 0.85:
            by_edges = min(by_edges, 0.45)  # edges there are everywhere
        by_hand = 0.9 * self.given * _logistic(-3.0 + 12.0 * self.edges)
        fits = _logistic(40.0 * (self.closeness + 0.25 * self.edges - WRONG))
        return fits * (1.0 - (1.0 - by_edges) * (1.0 - by_texture) * (1.0 - by_hand))


def _logistic(z: float) -> float:
    return 1.0 / (1.0 + math.exp(min(-z, 700.0)))


def weigh(
    matches: Matches,
    fit: Fit,
    texture: TextureFit | None = None,
    keyframe: Keyframe | None = None,
    shown: np.ndarray | float = 1.0,
) -> Evidence:
    """Evidence for a pose from its last edge pass and texture alignment; shown (N,): how far each node is thought to be uncovered."""
    N = len(matches.offset)
    if not N:
        return Evidence()
    edges, supported, quality, closeness = _support(
        matches.strength, matches.wide, matches.reach, fit.residual, fit.chosen, shown * np.ones(N)
    )
    seen = (texture.significance, texture.patches) if texture is not None else (0.0, 0)
    trust = keyframe.trust if keyframe is not None else 1.0
    return Evidence(edges, supported, *seen, fit.sigma, trust, quality=quality, closeness=closeness)


@compiled
def _support(strength, wide, reach, residual, chosen, shown):
    """(share of the shown nodes that have their edge near, beyond chance; their number; `Evidence.quality`; `Evidence.closeness`)."""
    N = len(residual)
    share, all_shown, chance, quality, closeness, supported = 0.0, 0.0, 0.0, 0.0, 0.0, 0
    for n in range(N):
        found, strongest = 0, 1e-9
        for k in range(wide):
            found += strength[n, k] != 0.0
            strongest = max(strongest, abs(strength[n, k]))
        chance += 1.0 - np.exp(-found * min(2.0 * NEAR / (2.0 * reach + 1.0), 1.0))
        all_shown += shown[n]
        if abs(residual[n]) < NEAR:  # nan: not supported
            share += shown[n]
            supported += 1
        if residual[n] == residual[n]:
            clear = min(abs(strength[n, chosen[n]]) / strongest, 1.0)
            quality += np.exp(-0.5 * residual[n] ** 2) * (0.5 + 0.5 * clear)
            closeness += np.exp(-0.5 * (residual[n] / CLOSE) ** 2)
    chance /= N
    return (share / all_shown - chance) / (1.0 - chance), supported, quality / N, closeness / N
