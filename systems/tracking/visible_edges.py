"""Visible edges of a CAD model and the tracking nodes on them (paper III-B, Fig. 6: visible edges, nodes at regular image intervals).

Frames: O object, C camera (x right, y down, z forward). Nodes stand at regular intervals of the *image*; the normal of a node points to
the left of its edge's own direction, so that what is learnt on either side keeps its side while the object turns.
"""

from dataclasses import dataclass

import numpy as np

from vipr.systems.camera.lens import Lens
from vipr.systems.tracking.cad_model import SMOOTH, WIRE, CadModel, across

RIM_SEGMENTS = 48
NEAR = 1e-3  # m in front of the camera


@dataclass(frozen=True, eq=False)
class Nodes:
    """N points of visible edges."""

    p_O: np.ndarray  # (N, 3) m
    pixel: np.ndarray  # (N, 2)
    normal: np.ndarray  # (N, 2) unit, in the image
    depth: np.ndarray  # (N,) m
    inside: np.ndarray  # (N, 2) whether the object's surface is seen on the side of +normal, of -normal
    bin: np.ndarray  # (N,) memory bin on the model
    edge: np.ndarray  # (N,) number of the edge, limb or rim
    spacing: float  # px between neighbours along an edge

    def __len__(self):
        return len(self.p_O)

    def take(self, index) -> "Nodes":
        """The nodes of an index or mask."""
        parts = (self.p_O, self.pixel, self.normal, self.depth, self.inside, self.bin, self.edge)
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
    a_O, b_O, inside, starts, counts, owner, circle, line = _segments(model, X_CO)
    R, t = X_CO[:3, :3], X_CO[:3, 3]
    ends = np.concatenate([a_O, b_O]) @ R.T + t
    S = len(a_O)
    low, high = np.zeros(S), np.ones(S)
    if S and ends[:, 2].min() > NEAR:
        pixel = lens.project(ends)
        whole = pixel.min() >= border and (pixel.max(0) <= (lens.width - 1 - border, lens.height - 1 - border)).all()
    else:
        whole = S == 0
        pixel = np.zeros((0, 2))
    if not whole:
        low, high = _clip(ends[:S], ends[S:], lens, border)
        keep = high > low
        a_O, b_O, inside, starts, counts, owner, circle, line, low, high = (
            part[keep] for part in (a_O, b_O, inside, starts, counts, owner, circle, line, low, high)
        )
        along = b_O - a_O
        a_O, b_O = a_O + low[:, None] * along, a_O + high[:, None] * along
        S = len(a_O)
        ends = np.concatenate([a_O, b_O]) @ R.T + t
        pixel = lens.project(ends)
    if not S:
        return _no_nodes(spacing)
    depth = ends[:, 2]
    difference = pixel[S:] - pixel[:S]
    length = np.sqrt((difference * difference).sum(1))
    total = np.cumsum(length)
    spacing = max(total[-1] / max(count, 1), spacing)
    place = (np.arange(int(total[-1] / spacing)) + 0.5) * spacing
    edge = np.minimum(np.searchsorted(total, place, side="right"), S - 1)
    length_n = length[edge]
    rounded = circle[:, 6] > 0
    # Corners spoil the profiles of their neighbours: stay a little away from the ends of long edges.
    margin = np.where((length > 16.0) & ~rounded, 3.0, 0.0)[edge]
    image_s = np.minimum(np.maximum(place - (total - length)[edge], margin), length_n - margin) / np.maximum(
        length_n, 1e-9
    )
    near, far = image_s * depth[:S][edge], (1.0 - image_s) * depth[S:][edge]
    s = near / np.maximum(near + far, 1e-12)  # the same point along the edge in space
    p_O = a_O[edge] + s[:, None] * (b_O - a_O)[edge]
    if rounded.any():  # from the chord to the arc
        centre, radius = circle[edge, :3], circle[edge, 6:]
        spoke = p_O - centre
        arc = centre + radius * spoke / np.maximum(np.linalg.norm(spoke, axis=1, keepdims=True), 1e-12)
        p_O = np.where(rounded[edge, None], arc, p_O)
    p_C = p_O @ R.T + t
    pixel = lens.project(p_C)
    across = np.empty_like(difference)
    across[:, 0], across[:, 1] = -difference[:, 1], difference[:, 0]
    normal = (across / np.maximum(length, 1e-9)[:, None])[edge]
    along_edge = low[edge] + s * (high - low)[edge]
    counts_n = counts[edge]
    bins = starts[edge] + np.minimum((along_edge * counts_n).astype(int), counts_n - 1)
    nodes = Nodes(p_O, pixel, normal, p_C[:, 2], inside[edge], bins, line[edge], float(spacing))
    shown = None
    if (occluders_C is not None and len(occluders_C)) or (len(model.surface) and not model.convex):
        shown = ~_hidden_nodes(model, X_CO, lens, nodes, owner[edge], occluders_C)
    if not whole or rounded.any():
        inside_image = (pixel >= border).all(1) & (pixel <= (lens.width - 1 - border, lens.height - 1 - border)).all(1)
        shown = inside_image if shown is None else shown & inside_image
    return nodes if shown is None or shown.all() else nodes.take(shown)


def _no_nodes(spacing):
    return Nodes(
        np.zeros((0, 3)),
        np.zeros((0, 2)),
        np.zeros((0, 2)),
        np.zeros(0),
        np.zeros((0, 2), bool),
        np.zeros(0, int),
        np.zeros(0, int),
        float(spacing),
    )


def _segments(model, X_CO):
    """Candidate edges at this pose: ends (S, 3) twice, inside (S, 2), bin start, bin count, owner, circle (S, 7), number.

    owner: the cylinder that a limb or rim belongs to, -1 otherwise; circle: centre, normal, radius of an arc, radius 0 for straight ones.
    """
    eye = -X_CO[:3, :3].T @ X_CO[:3, 3]  # the camera's centre in O
    start, number = model.bin_start[:-1], np.diff(model.bin_start)
    E, C = len(model.edges), len(model.cylinders)
    planes, offsets = model.edge_planes
    first, second, left, right = (planes @ eye > offsets).reshape(4, E)
    wire = model.edge_kind == WIRE
    contour = (model.edge_kind == SMOOTH) & (first != second)
    if not model.closed:  # both sides of a face can be seen
        first = second = np.ones(E, bool)
    seen = np.flatnonzero(contour | ((first | second | wire) & (model.edge_kind != SMOOTH)))
    on_first, on_second, left, right = (first & ~wire)[seen], (second & ~wire)[seen], left[seen], right[seen]
    inside = np.empty((len(seen), 2), bool)
    # The image's y points down: what is left of an edge in a right-handed view is on the side of -normal.
    inside[:, 0] = (on_first & ~left) | (on_second & ~right)
    inside[:, 1] = (on_first & left) | (on_second & right)
    ends = model.vertices[model.edges[seen]]
    straight = (
        ends[:, 0],
        ends[:, 1],
        inside,
        start[seen],
        number[seen],
        np.full(len(seen), -1),
        np.zeros((len(seen), 7)),
        seen,
    )
    if not C and not len(model.circles):
        return straight
    parts = [straight]
    for i, (p, q, r) in enumerate((c[:3], c[3:6], c[6]) for c in model.cylinders):
        parts.append(_limbs(p, q, r, eye, start[E + 2 * i], i, E + 2 * i))
        rim = E + 2 * C + 2 * i
        parts.append(_rim(p, p - q, r, eye, start[rim], i, q - p, rim))
        parts.append(_rim(q, q - p, r, eye, start[rim + 1], i, p - q, rim + 1))
    for i, (p, n, r) in enumerate((c[:3], c[3:6], c[6]) for c in model.circles):
        parts.append(_rim(p, n, r, eye, start[E + 4 * C + i], -1, None, E + 4 * C + i))
    return tuple(np.concatenate(column) for column in zip(*parts, strict=True))


def _limbs(p, q, r, eye, start, owner, number):
    """The two lines where the line of sight touches a cylinder."""
    axis = (q - p) / np.linalg.norm(q - p)
    off = eye - p
    off = off - (off @ axis) * axis
    distance = np.linalg.norm(off)
    if distance <= r:  # seen along the axis
        return _none()
    u = off / distance
    v = np.cross(axis, u)
    cos, sin = r / distance, np.sqrt(1.0 - (r / distance) ** 2)
    spokes = r * np.array([cos * u + sin * v, cos * u - sin * v])
    left = np.cross(q - p, -spokes) @ (eye - p) > 0
    return (
        p + spokes,
        q + spokes,
        np.stack([~left, left], 1),
        np.array([start, start + 32]),
        np.array([32, 32]),
        np.full(2, owner),
        np.zeros((2, 7)),
        np.array([number, number + 1]),
    )


def _rim(centre, normal, r, eye, start, owner, body, number):
    """A circle as short chords; of a cylinder's end (body: the axis, away from the end) only what its own surface leaves to be seen."""
    u, v = across(normal)
    angle = np.linspace(0.0, 2.0 * np.pi, RIM_SEGMENTS + 1)
    points = centre + r * (np.outer(np.cos(angle), u) + np.outer(np.sin(angle), v))
    a, b = points[:-1], points[1:]
    middle = 0.5 * (a + b)
    cap = np.full(RIM_SEGMENTS, normal @ (eye - centre) > 0)
    side = np.einsum("nd,nd->n", middle - centre, eye - middle) > 0
    if body is None:
        cap[:], side[:] = True, False
    inward = np.einsum("nd,nd->n", np.cross(b - a, centre - middle), eye - middle) > 0  # the cap is left of a -> b
    down = (
        np.zeros(RIM_SEGMENTS, bool)
        if body is None
        else np.einsum("nd,nd->n", np.cross(b - a, np.broadcast_to(body, a.shape)), eye - middle) > 0
    )
    plus = (cap & ~inward) | (side & ~down)
    minus = (cap & inward) | (side & down)
    seen = cap | side
    bins = start + (np.arange(RIM_SEGMENTS) * 64) // RIM_SEGMENTS
    arc = np.broadcast_to(np.r_[centre, normal, r], (RIM_SEGMENTS, 7))
    return (
        a[seen],
        b[seen],
        np.stack([plus, minus], 1)[seen],
        bins[seen],
        np.ones(seen.sum(), int),
        np.full(seen.sum(), owner),
        arc[seen],
        np.full(seen.sum(), number),
    )


def _none():
    return (
        np.zeros((0, 3)),
        np.zeros((0, 3)),
        np.zeros((0, 2), bool),
        np.zeros(0, int),
        np.zeros(0, int),
        np.zeros(0, int),
        np.zeros((0, 7)),
        np.zeros(0, int),
    )


def _clip(a, b, lens, border):
    """Interval (low, high) of each segment a -> b in C that lies before the camera and in the image; low >= high: nothing."""
    x0, x1 = (border - lens.cx) / lens.fx, (lens.width - 1 - border - lens.cx) / lens.fx
    y0, y1 = (border - lens.cy) / lens.fy, (lens.height - 1 - border - lens.cy) / lens.fy
    planes = np.array([[0, 0, 1], [1, 0, -x0], [-1, 0, x1], [0, 1, -y0], [0, -1, y1]], float)
    da = a @ planes.T - (NEAR, 0, 0, 0, 0)  # >= 0 inside
    db = b @ planes.T - (NEAR, 0, 0, 0, 0)
    with np.errstate(divide="ignore", invalid="ignore"):
        cut = da / (da - db)
    low = np.where((da < 0) & (db >= 0), cut, np.where(da < 0, 2.0, 0.0)).max(1)
    high = np.where((db < 0) & (da >= 0), cut, 1.0).min(1)
    return low, high


def _hidden_nodes(model, X_CO, lens, nodes, owner, occluders_C):
    hidden = np.zeros(len(nodes), bool)
    if not len(nodes):
        return hidden
    if not (model.convex and not len(model.cylinders)) and len(model.surface):
        surface_C = model.surface @ X_CO[:3, :3].T + X_CO[:3, 3]
        hidden |= hidden_behind(
            nodes.pixel, nodes.depth, surface_C, lens, 0.004 * model.size, owner, model.surface_owner, model.closed
        )
    if occluders_C is not None and len(occluders_C):
        hidden |= hidden_behind(nodes.pixel, nodes.depth, occluders_C, lens, 0.0)
    return hidden


def hidden_behind(
    pixel: np.ndarray,
    depth: np.ndarray,
    triangles_C: np.ndarray,
    lens: Lens,
    tolerance: float,
    owner: np.ndarray | None = None,
    triangle_owner: np.ndarray | None = None,
    one_sided: bool = False,
) -> np.ndarray:
    """(N,) whether a point at pixel (N, 2) and depth (N,) [m] is hidden by a triangle (T, 3, 3) of C, nearer by more than tolerance [m].

    Only pairs whose triangle's bounding box holds the point are computed. Triangles of the point's own cylinder do not count.
    """
    hidden = np.zeros(len(pixel), bool)
    ahead = (triangles_C[:, :, 2] > NEAR).all(1)
    uv = triangles_C[..., :2] / np.maximum(triangles_C[..., 2:], NEAR) * (lens.fx, lens.fy) + (lens.cx, lens.cy)
    e1, e2 = uv[:, 1] - uv[:, 0], uv[:, 2] - uv[:, 0]
    area = e1[:, 0] * e2[:, 1] - e1[:, 1] * e2[:, 0]
    ahead &= (area < -1e-9) if one_sided else (np.abs(area) > 1e-9)  # outward faces run clockwise where y points down
    chosen = np.flatnonzero(ahead)
    if not len(chosen):
        return hidden
    uv, e1, e2, area, z = uv[chosen], e1[chosen], e2[chosen], area[chosen], triangles_C[chosen, :, 2]
    low, high, near = uv.min(1), uv.max(1), z.min(1)
    maybe = (
        (pixel[:, None, 0] > low[None, :, 0])
        & (pixel[:, None, 0] < high[None, :, 0])
        & (pixel[:, None, 1] > low[None, :, 1])
        & (pixel[:, None, 1] < high[None, :, 1])
        & (depth[:, None] > near + tolerance)
    )
    if owner is not None and triangle_owner is not None:
        maybe &= (owner[:, None] != triangle_owner[chosen]) | (owner[:, None] < 0)
    n, k = np.nonzero(maybe)
    d = pixel[n] - uv[k, 0]
    beta = (d[:, 0] * e2[k, 1] - d[:, 1] * e2[k, 0]) / area[k]
    gamma = (e1[k, 0] * d[:, 1] - e1[k, 1] * d[:, 0]) / area[k]
    inverse = 1.0 / z[k]
    inverse_depth = inverse[:, 0] + beta * (inverse[:, 1] - inverse[:, 0]) + gamma * (inverse[:, 2] - inverse[:, 0])
    covers = (beta > 1e-4) & (gamma > 1e-4) & (beta + gamma < 1.0 - 1e-4)
    covers &= inverse_depth * (depth[n] - tolerance) > 1.0
    hidden[n[covers]] = True
    return hidden
