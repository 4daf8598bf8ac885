"""Rims of round bodies: a curved edge looks nearer to its centre than it is, the more the narrower it is curved.

What is seen of an edge is the mean over parallel lines that are straight, of pixels that are areas. Where the edge has curvature k, a place
t along the tangent lies k t^2 / 2 towards the centre: on average half of k times the variance of t, which is 2/3 px^2 for three lines
1 px apart, 1/12 for the pixel's own width and 1/6 for what lies between pixels.
"""

from dataclasses import replace

import numpy as np

from vipr.systems.camera.lens import Lens
from vipr.systems.tracking.cad_model import CadModel
from vipr.systems.tracking.normal_flow import Matches
from vipr.systems.tracking.visible_edges import Nodes

SPREAD = 2.0 / 3.0 + 1.0 / 12.0 + 1.0 / 6.0  # px^2
NARROWEST = 0.3  # 1/px, curvature beyond which the edge is no arc over the width of the lines


def straightened(matches: Matches, nodes: Nodes, model: CadModel, X_CO: np.ndarray, lens: Lens) -> Matches:
    """The matches with the sharp edges of nodes on rims moved outward to where the rim is."""
    first = len(model.edges) + 2 * len(model.cylinders)
    on = np.flatnonzero(nodes.edge >= first)
    if not len(on):
        return matches
    ends = [(c[i : i + 3], c[3:6] - c[:3], c[6]) for c in model.cylinders for i in (0, 3)]
    ends += [(c[:3], c[3:6], c[6]) for c in model.circles]
    centre, axis, radius = (np.array(part)[nodes.edge[on] - first] for part in zip(*ends, strict=True))
    spoke = (nodes.p_O[on] - centre) / radius[:, None]
    tangent = np.cross(axis / np.linalg.norm(axis, axis=1)[:, None], spoke)
    outward, along = (_seen(v @ X_CO[:3, :3].T, nodes.pixel[on], nodes.depth[on], lens) for v in (spoke, tangent))
    area = outward[:, 0] * along[:, 1] - outward[:, 1] * along[:, 0]
    curvature = np.abs(area) / (radius * np.maximum((along**2).sum(1), 1e-12) ** 1.5)
    shift = 0.5 * SPREAD * np.minimum(curvature, NARROWEST) * np.sign((outward * nodes.normal[on]).sum(1))
    offset = matches.offset.copy()
    offset[on, matches.wide :] += shift[:, None]
    return replace(matches, offset=offset)


def _seen(v_C, pixel, depth, lens):
    """(N, 2) px that a metre along v_C (N, 3) makes in the image at pixels (N, 2) of points at depths (N,)."""
    focal, centre = np.array([lens.fx, lens.fy]), np.array([lens.cx, lens.cy])
    return (focal * v_C[:, :2] - (pixel - centre) * v_C[:, 2:]) / depth[:, None]
