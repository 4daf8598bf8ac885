"""Visible edges of a CAD model and the tracking nodes on them (paper III-B, Fig. 6: visible edges, nodes at regular image intervals).

Frames: O object, C camera (x right, y down, z forward). Nodes stand at regular intervals of the *image*; the normal of a node points to
the left of its edge's own direction, so that what is learnt on either side keeps its side while the object turns.
"""

from dataclasses import dataclass

import numpy as np

from vipr.systems.camera.lens import Lens
from vipr.systems.compiled import compiled
from vipr.systems.tracking.cad_model import CadModel
from vipr.systems.tracking.occlusion import NEAR, hidden_behind
from vipr.systems.tracking.segments import candidates


@dataclass(frozen=True, eq=False)
class Nodes:
    """N points of visible edges."""

    p_O: np.ndarray  # (N, 3) m
    pixel: np.ndarray  # (N, 2)
    normal: np.ndarray  # (N, 2) unit, in the image
    depth: np.ndarray  # (N,) m
    inside: np.ndarray  # (N, 2) whether the object's surface is seen on the side of +normal, of -normal
    edge: np.ndarray  # (N,) number of the edge, limb or rim
    spacing: float  # px between neighbours along an edge

    def __len__(self):
        return len(self.p_O)

    def take(self, index) -> "Nodes":
        """The nodes of an index or mask."""
        parts = (self.p_O, self.pixel, self.normal, self.depth, self.inside, self.edge)
        return Nodes(*(part[index] for part in parts), self.spacing)


def visible_nodes(
    model: CadModel,
    X_CO: np.ndarray,
    lens: Lens,
    count: int = 200,
    spacing: float = 3.0,
    occluders_C: np.ndarray | None = None,
    border: float = 2.0,
) -> Nodes:
    """Nodes on the visible edges, about count of them but no closer than spacing [px], inside the image by border [px].

    occluders_C (S, 3, 3) are triangles of other bodies in C [m] that may stand in front. Behind the camera or out of view: no nodes.
    """
    segments = candidates(model, X_CO)
    view = (lens.fx, lens.fy, lens.cx, lens.cy, lens.width, lens.height)
    low, high, ends = _clipped(segments.a_O, segments.b_O, X_CO, *view, border)
    *parts, segment, spacing = _place(
        *segments[:3], *segments[4:], X_CO, *view, low, high, ends, count, spacing, border
    )
    nodes = Nodes(*parts, spacing)
    if not len(nodes):
        return nodes
    shown = None
    if len(model.surface) and not model.convex:
        surface_C = model.surface @ X_CO[:3, :3].T + X_CO[:3, 3]
        owners = segments.owner[segment], model.surface_owner
        tolerance = 0.004 * model.size
        shown = ~hidden_behind(nodes.pixel, nodes.depth, surface_C, lens, tolerance, *owners, model.closed)
    if occluders_C is not None and len(occluders_C):
        free = ~hidden_behind(nodes.pixel, nodes.depth, occluders_C, lens, 0.0)
        shown = free if shown is None else shown & free
    return nodes if shown is None or shown.all() else nodes.take(shown)


@compiled
def _clipped(a_O, b_O, X_CO, fx, fy, cx, cy, width, height, border):
    """Interval (low, high) of each segment in the image and before the camera (low >= high: nothing), and its ends in C (S, 2, 3)."""
    S = len(a_O)
    low, high, ends = np.zeros(S), np.ones(S), np.empty((S, 2, 3))
    x0, x1, y0, y1 = border, width - 1 - border, border, height - 1 - border
    for s in range(S):
        for end, p in ((0, a_O[s]), (1, b_O[s])):
            for i in range(3):
                ends[s, end, i] = X_CO[i, 0] * p[0] + X_CO[i, 1] * p[1] + X_CO[i, 2] * p[2] + X_CO[i, 3]
        a, b = ends[s, 0], ends[s, 1]
        for side in range(5):  # distances from the planes of the view's pyramid, positive inside
            if side == 0:
                da, db = a[2] - NEAR, b[2] - NEAR
            elif side == 1:
                da, db = fx * a[0] - (x0 - cx) * a[2], fx * b[0] - (x0 - cx) * b[2]
            elif side == 2:
                da, db = (x1 - cx) * a[2] - fx * a[0], (x1 - cx) * b[2] - fx * b[0]
            elif side == 3:
                da, db = fy * a[1] - (y0 - cy) * a[2], fy * b[1] - (y0 - cy) * b[2]
            else:
                da, db = (y1 - cy) * a[2] - fy * a[1], (y1 - cy) * b[2] - fy * b[1]
            if da < 0.0 and db < 0.0:
                low[s] = 2.0
            elif da < 0.0:
                low[s] = max(low[s], da / (da - db))
            elif db < 0.0:
                high[s] = min(high[s], da / (da - db))
    return low, high, ends


@compiled
def _place(
    a_O,
    b_O,
    inside,
    circle,
    number,
    X_CO,
    fx,
    fy,
    cx,
    cy,
    width,
    height,
    low,
    high,
    ends,
    count,
    spacing,
    border,
):
    """Nodes at equal image intervals along all that is left of the segments, one after the other: the parts of `Nodes`, segment (N,)."""
    S = len(a_O)
    pixel_ends, length, total = np.empty((S, 2, 2)), np.zeros(S), 0.0
    for s in range(S):
        if low[s] >= high[s]:
            continue
        for i in range(3):
            a, along = ends[s, 0, i], ends[s, 1, i] - ends[s, 0, i]
            ends[s, 0, i], ends[s, 1, i] = a + low[s] * along, a + high[s] * along
        for end in range(2):
            p = ends[s, end]
            pixel_ends[s, end, 0], pixel_ends[s, end, 1] = fx * p[0] / p[2] + cx, fy * p[1] / p[2] + cy
        length[s] = np.hypot(pixel_ends[s, 1, 0] - pixel_ends[s, 0, 0], pixel_ends[s, 1, 1] - pixel_ends[s, 0, 1])
        total += length[s]
    spacing = max(total / max(count, 1), spacing)
    most = int(total / spacing) if total > 0.0 else 0  # also of a pose that is no number
    p_O, pixel, normal, depth = np.empty((most, 3)), np.empty((most, 2)), np.empty((most, 2)), np.empty(most)
    sides, number_n, segment = np.empty((most, 2), np.bool_), np.empty(most, np.int64), np.empty(most, np.int64)
    n, passed, place = 0, 0.0, 0.5 * spacing
    for s in range(S):
        # Corners spoil the profiles of their neighbours: stay a little away from the ends of long edges.
        margin = 3.0 if length[s] > 16.0 and circle[s, 6] == 0.0 else 0.0
        while place < passed + length[s] and n < most:
            image_s = min(max(place - passed, margin), length[s] - margin) / length[s]
            place += spacing
            near, far = image_s * ends[s, 0, 2], (1.0 - image_s) * ends[s, 1, 2]
            along = low[s] + near / (near + far) * (high[s] - low[s])  # the same point along the edge in space
            for i in range(3):
                p_O[n, i] = a_O[s, i] + along * (b_O[s, i] - a_O[s, i])
            if circle[s, 6] > 0.0:  # from the chord to the arc
                spoke = p_O[n] - circle[s, :3]
                p_O[n] = circle[s, :3] + spoke * (circle[s, 6] / max(np.sqrt((spoke * spoke).sum()), 1e-12))
            x = X_CO[0, 0] * p_O[n, 0] + X_CO[0, 1] * p_O[n, 1] + X_CO[0, 2] * p_O[n, 2] + X_CO[0, 3]
            y = X_CO[1, 0] * p_O[n, 0] + X_CO[1, 1] * p_O[n, 1] + X_CO[1, 2] * p_O[n, 2] + X_CO[1, 3]
            z = X_CO[2, 0] * p_O[n, 0] + X_CO[2, 1] * p_O[n, 1] + X_CO[2, 2] * p_O[n, 2] + X_CO[2, 3]
            pixel[n, 0], pixel[n, 1], depth[n] = fx * x / z + cx, fy * y / z + cy, z
            if not (
                border - 1e-6 <= pixel[n, 0] <= width - 1 - border + 1e-6
                and border - 1e-6 <= pixel[n, 1] <= height - 1 - border + 1e-6
            ):
                continue
            normal[n, 0] = -(pixel_ends[s, 1, 1] - pixel_ends[s, 0, 1]) / length[s]
            normal[n, 1] = (pixel_ends[s, 1, 0] - pixel_ends[s, 0, 0]) / length[s]
            sides[n, 0], sides[n, 1] = inside[s, 0], inside[s, 1]
            number_n[n], segment[n] = number[s], s
            n += 1
        passed += length[s]
    return p_O[:n], pixel[:n], normal[:n], depth[:n], sides[:n], number_n[:n], segment[:n], spacing
