"""Self-diagnosis: is the object really where the tracker believes it to be?

Two kinds of evidence, each corrected for what chance would give: the share of the nodes that have an edge where the model says (chance: how
densely edges lie along the search lines anyway), and the share of the texture patches that look as they were learnt.
"""

from dataclasses import dataclass

import numpy as np

from vipr.systems.tracking.keyframes import Keyframe
from vipr.systems.tracking.normal_flow import Matches
from vipr.systems.tracking.pose_fit import Fit
from vipr.systems.tracking.texture import TextureFit

NEAR = 1.5  # px: an edge within this supports its node
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
        return 1.0 - (1.0 - by_edges) * (1.0 - by_texture) * (1.0 - by_hand)


def _logistic(z: float) -> float:
    return float(1.0 / (1.0 + np.exp(-z)))


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
    present = matches.strength[:, : matches.wide] != 0
    supported = np.abs(fit.residual) < NEAR  # nan: not supported
    density = present.sum(1) * min(2.0 * NEAR / (2.0 * matches.reach + 1.0), 1.0)
    chance = float((1.0 - np.exp(-density)).mean())
    share = float((shown * supported).sum() / (shown * np.ones(N)).sum())
    edges = (share - chance) / (1.0 - chance)
    strength = np.abs(matches.strength)
    clear = np.minimum(strength[np.arange(N), fit.chosen] / np.maximum(strength[:, : matches.wide].max(1), 1e-9), 1.0)
    close = np.exp(-0.5 * np.nan_to_num(fit.residual, nan=9.0) ** 2)
    quality = float((close * (0.5 + 0.5 * clear)).mean())
    seen = (texture.significance, texture.patches) if texture is not None else (0.0, 0)
    return Evidence(
        edges, int(supported.sum()), *seen, fit.sigma, keyframe.trust if keyframe is not None else 1.0, quality=quality
    )
