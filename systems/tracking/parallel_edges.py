"""Edges of the model that lie side by side in the image, as those of a face seen almost from its edge: one edge of the image belongs to
one of them, not to both.
"""

from dataclasses import replace

import numpy as np

from vipr.systems.compiled import compiled
from vipr.systems.tracking.normal_flow import Matches
from vipr.systems.tracking.visible_edges import Nodes

SAME, APART = 0.7, 5.0  # px: closer edges are one; others leave each other alone
PARALLEL = 0.95  # cosine of the angle between their normals, at least
SHARE, MORE_PX = 0.25, 0.4  # of their distance, and px: how far that of two edges of the image may be from the model's
UNSURE = 0.1  # weight of a node whose two edges cannot be told apart


def told_apart(matches: Matches, nodes: Nodes, straight: int) -> tuple[Matches, np.ndarray]:
    """The matches without sharp edges that may be those of a neighbour, and the weight (N,) of each node, 1 or `UNSURE`.

    Where two edges of the model are neighbours, only pairs of edges of the image as far apart as they, in their order, count. The first
    so many edges of the model are straight; rims and limbs, which touch where they end, are left alone.
    """
    weight, strength = np.ones(len(nodes)), matches.strength.copy()
    among = np.flatnonzero(nodes.edge < straight)
    _keep_pairs(matches.offset, strength, weight, matches.wide, nodes.pixel, nodes.normal, among, nodes.spacing)
    return replace(matches, strength=strength), weight


@compiled
def _keep_pairs(offset, strength, weight, wide, pixel, normal, among, spacing):
    K = offset.shape[1]
    for n in among:
        beside = np.inf  # to the nearest neighbour, along the normal
        for m in among:
            dx, dy = pixel[m, 0] - pixel[n, 0], pixel[m, 1] - pixel[n, 1]
            if abs(dx) > APART + spacing or abs(dy) > APART + spacing:
                continue
            along = dy * normal[n, 0] - dx * normal[n, 1]
            across = dx * normal[n, 0] + dy * normal[n, 1]
            parallel = abs(normal[n, 0] * normal[m, 0] + normal[n, 1] * normal[m, 1]) > PARALLEL
            if parallel and abs(along) <= 0.75 * spacing and SAME < abs(across) < min(APART, abs(beside)):
                beside = across
        if abs(beside) > APART:
            continue
        slack, paired = SHARE * abs(beside) + MORE_PX, np.zeros(K, np.bool_)
        for k in range(wide, K):
            for j in range(wide, K):
                both = strength[n, k] != 0.0 and strength[n, j] != 0.0 and j != k
                paired[k] |= both and abs(offset[n, j] - offset[n, k] - beside) < slack
        if not paired.any():
            weight[n] = UNSURE
            continue
        for k in range(K):
            if not paired[k]:
                strength[n, k] = 0.0
