"""CAD models of objects to be tracked: polyhedra, cylinders and circles, with the edges that a camera can see.

Frame O: the object's own, in which the file gives its points, in metres. Faces are stored as triangles; an edge between coplanar
triangles does not exist, one between faces that meet at a small angle (a tessellated curve) counts only as a silhouette.
"""

from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path

import numpy as np

from vipr.systems.errors import InputError
from vipr.systems.tracking.triangulation import cylinder_triangles, triangulate, unit

CREASE, WIRE, SMOOTH = 0, 1, 2  # kinds of edges: seen when a face is, always, only between a front and a back face
COPLANAR = np.deg2rad(2.0)
LARGEST = 100.0  # m; a larger model is surely in millimetres


@dataclass(frozen=True, eq=False)
class Shape:
    """What a model file says, before anything is worked out; lengths in metres, frame O."""

    name: str = "object"
    points: np.ndarray = field(default_factory=lambda: np.zeros((0, 3)))  # (P, 3)
    faces: tuple[tuple[int, ...], ...] = ()  # polygons, indices of points
    lines: tuple[tuple[int, int], ...] = ()  # edges without a face
    cylinders: tuple[tuple[np.ndarray, np.ndarray, float], ...] = ()  # axis start (3,), axis end (3,), radius
    circles: tuple[tuple[np.ndarray, np.ndarray, float], ...] = ()  # centre (3,), unit normal (3,), radius


@dataclass(frozen=True, eq=False)
class CadModel:
    """Geometry of one object in O [m]; build it with ``build_model`` or ``load_model``."""

    name: str
    vertices: np.ndarray  # (V, 3)
    triangles: np.ndarray  # (T, 3) indices of vertices, counter-clockwise seen from outside where the surface is closed
    normals: np.ndarray  # (T, 3) unit
    edges: np.ndarray  # (E, 2) indices of vertices
    edge_normals: np.ndarray  # (E, 2, 3) unit normals of the two faces (twice the same at a border)
    edge_inward: np.ndarray  # (E, 2, 3) unit vectors in the two faces, away from the edge
    edge_kind: np.ndarray  # (E,) CREASE, WIRE or SMOOTH
    closed: bool  # no border: back faces can be left out
    convex: bool  # and nothing of the model hides an edge of a front face
    cylinders: np.ndarray  # (C, 7) axis start, axis end, radius
    circles: np.ndarray  # (K, 7) centre, unit normal, radius

    @cached_property
    def corners(self) -> np.ndarray:
        """(N, 3) points that span the model: the vertices, and the corners of boxes around cylinders and circles."""
        parts = [self.vertices]
        for a, b, r in ((c[:3], c[3:6], c[6]) for c in self.cylinders):
            u, v = across(b - a)
            parts.append(np.array([e + r * (i * u + j * v) for e in (a, b) for i in (-1, 1) for j in (-1, 1)]))
        for centre, n, r in ((c[:3], c[3:6], c[6]) for c in self.circles):
            u, v = across(n)
            parts.append(np.array([centre + r * (i * u + j * v) for i in (-1, 1) for j in (-1, 1)]))
        return np.concatenate(parts)

    @cached_property
    def centre(self) -> np.ndarray:
        """(3,) middle of the bounding box."""
        return 0.5 * (self.corners.min(0) + self.corners.max(0))

    @cached_property
    def size(self) -> float:
        """Diagonal of the bounding box [m]."""
        return float(np.linalg.norm(np.ptp(self.corners, axis=0)))

    @cached_property
    def surface(self) -> np.ndarray:
        """(S, 3, 3) triangles that hide what is behind them: faces, then cylinders."""
        return np.concatenate(
            [self.vertices[self.triangles], *(cylinder_triangles(c[:3], c[3:6], c[6]) for c in self.cylinders)]
        )

    @cached_property
    def surface_owner(self) -> np.ndarray:
        """(S,) number of the cylinder that a surface triangle stands for, -1 for a face."""
        per_cylinder = (len(self.surface) - len(self.triangles)) // max(len(self.cylinders), 1)
        return np.r_[np.full(len(self.triangles), -1), np.repeat(np.arange(len(self.cylinders)), per_cylinder)]

    @cached_property
    def edge_planes(self) -> tuple[np.ndarray, np.ndarray]:
        """Planes (4 E, 3) and offsets (4 E,): ``planes @ eye > offsets`` says of each edge, for a camera centre eye in O, whether its first
        and its second face are seen, then whether these faces lie to the left of the edge.
        """
        a, b = self.vertices[self.edges[:, 0]], self.vertices[self.edges[:, 1]]
        sides = [np.cross(b - a, self.edge_inward[:, i]) for i in (0, 1)]
        planes = np.concatenate([self.edge_normals[:, 0], self.edge_normals[:, 1], *sides])
        return planes, (planes * np.tile(a, (4, 1))).sum(1)

    @cached_property
    def straight_edges(self) -> tuple[np.ndarray, ...]:
        """Ends (E, 3) twice of the edges, and (E,) of -1: no cylinder's."""
        return *(self.vertices[self.edges[:, i]] for i in (0, 1)), np.full(len(self.edges), -1)


def across(axis: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Two unit vectors that make a right-handed frame with the axis (3,)."""
    axis = unit(axis)
    u = unit(np.cross(axis, np.eye(3)[np.argmin(np.abs(axis))]))
    return u, np.cross(axis, u)


def build_model(shape: Shape, smooth_angle: float = np.deg2rad(31.0)) -> CadModel:
    """Edges, normals and visibility properties of a shape.

    Faces that meet at less than smooth_angle [rad] are taken for a tessellated curve. Raises InputError for a shape with nothing to track.
    """
    who = f"model {shape.name}"
    points = np.asarray(shape.points, float).reshape(-1, 3)
    if not (shape.faces or shape.lines or shape.cylinders or shape.circles):
        raise InputError(f"{who}: has no faces, lines, cylinders or circles; an edge tracker needs at least one")
    round_parts = [np.r_[a, b, r] for a, b, r in (*shape.cylinders, *shape.circles)]
    if not all(np.isfinite(part).all() for part in (points, *round_parts)):
        raise InputError(f"{who}: a coordinate or radius is not a finite number of metres")
    for a, b, r in shape.cylinders:
        if not (r > 0 and np.linalg.norm(np.subtract(b, a)) > 0):
            raise InputError(f"{who}: a cylinder needs a positive radius and length, got radius {r} m")
    for _, n, r in shape.circles:
        if not (r > 0 and np.linalg.norm(n) > 0):
            raise InputError(f"{who}: a circle needs a positive radius and a plane, got radius {r} m")
    indices = [i for part in (*shape.faces, *shape.lines) for i in part]
    if indices and not 0 <= min(indices) <= max(indices) < len(points):
        raise InputError(f"{who}: a face or line names a point outside 0 to {len(points) - 1}")

    scale = float(np.linalg.norm(np.ptp(points, axis=0))) if len(points) else 0.0
    vertices, weld = _weld(points, 1e-6 * scale)
    corners = [triangulate(vertices, weld[list(face)]) for face in shape.faces]
    triangles = np.array([t for part in corners for t in part], int).reshape(-1, 3)
    if shape.faces and not len(triangles) and not (shape.lines or shape.cylinders or shape.circles):
        raise InputError(f"{who}: all of its {len(shape.faces)} faces have no area")
    triangles, closed = _orient(vertices, triangles)
    normals = unit(
        np.cross(
            vertices[triangles[:, 1]] - vertices[triangles[:, 0]], vertices[triangles[:, 2]] - vertices[triangles[:, 0]]
        )
    )
    edges, edge_normals, inward, kind = _edges(vertices, triangles, normals, smooth_angle)
    lines = np.array([weld[list(line)] for line in shape.lines], int).reshape(-1, 2)
    lines = lines[lines[:, 0] != lines[:, 1]]
    convex = bool(
        closed
        and len(triangles)
        and not shape.cylinders
        and np.max(np.einsum("td,vtd->vt", normals, vertices[:, None] - vertices[triangles[:, 0]])) < 1e-5 * scale
    )
    model = CadModel(
        shape.name,
        vertices,
        triangles,
        normals,
        np.concatenate([edges, lines]),
        np.concatenate([edge_normals, np.zeros((len(lines), 2, 3))]),
        np.concatenate([inward, np.zeros((len(lines), 2, 3))]),
        np.concatenate([kind, np.full(len(lines), WIRE)]),
        closed,
        convex,
        np.array([np.r_[a, b, r] for a, b, r in shape.cylinders]).reshape(-1, 7),
        np.array([np.r_[c, unit(n), r] for c, n, r in shape.circles]).reshape(-1, 7),
    )
    if not 0 < model.size < LARGEST:
        raise InputError(f"{who}: is {model.size:g} m across, expected metres, more than 0 and less than {LARGEST:g}")
    return model


def load_model(path: str | Path) -> CadModel:
    """Model of an ``.obj``, ``.cao`` (V1), ``.yaml`` or mesh file (``.stl``, ``.ply``, ``.off``), in metres.

    Raises InputError, with the file's name, for anything that cannot be tracked.
    """
    from vipr.systems.tracking.cad_files import read_shape

    return build_model(read_shape(Path(path)))


def _weld(points, tolerance):
    """Unique points (V, 3), and the index into them of every point given."""
    if not len(points):
        return points, np.zeros(0, int)
    keys = np.round(points / max(tolerance, 1e-12)).astype(np.int64)
    _, first, inverse = np.unique(keys, axis=0, return_index=True, return_inverse=True)
    order = np.argsort(first)  # keep the file's order
    rank = np.empty_like(order)
    rank[order] = np.arange(len(order))
    return points[first[order]], rank[inverse.ravel()]


def _half_edges(triangles):
    """(start, end) -> [(triangle, whether it runs this way)], for start < end."""
    table = {}
    for t, (a, b, c) in enumerate(triangles.tolist()):
        for i, j in ((a, b), (b, c), (c, a)):
            table.setdefault((min(i, j), max(i, j)), []).append((t, i < j))
    return table


def _orient(vertices, triangles):
    """Triangles turned to one sense over each connected part, outward where it is closed; and whether all are closed."""
    triangles = triangles.copy()
    neighbours = [[] for _ in triangles]
    closed = len(triangles) > 0
    for users in _half_edges(triangles).values():
        closed = closed and len(users) == 2
        if len(users) == 2:
            (s, s_way), (t, t_way) = users
            neighbours[s].append((t, s_way == t_way))
            neighbours[t].append((s, s_way == t_way))
    seen = np.zeros(len(triangles), bool)
    for seed in range(len(triangles)):
        if seen[seed]:
            continue
        seen[seed] = True
        part, flip = [seed], {seed: False}
        for t in part:
            for n, differs in neighbours[t]:
                if not seen[n]:
                    seen[n] = True
                    flip[n] = flip[t] != differs
                    part.append(n)
        turned = [t for t in part if flip[t]]
        triangles[turned] = triangles[turned][:, ::-1]
        corner = vertices[triangles[part]] - vertices[triangles[part]].mean((0, 1))
        volume = np.einsum("ij,ij->", corner[:, 0], np.cross(corner[:, 1], corner[:, 2]))
        if (closed and volume < 0) or (not closed and len(turned) > len(part) / 2):
            triangles[part] = triangles[part][:, ::-1]
    return triangles, closed


def _edges(vertices, triangles, normals, smooth_angle):
    edges, edge_normals, inward, kinds = [], [], [], []
    for (i, j), users in _half_edges(triangles).items():
        sides = [t for t, _ in users[:2]]
        normal = normals[[sides[0], sides[-1]]]
        angle = np.arccos(np.clip(normal[0] @ normal[1], -1.0, 1.0))
        if len(users) == 2 and angle < COPLANAR:
            continue
        kinds.append(CREASE if len(users) != 2 or angle > smooth_angle else SMOOTH)
        edges.append((i, j))
        edge_normals.append(normal)
        along = unit(vertices[j] - vertices[i])
        into = vertices[triangles[[sides[0], sides[-1]]]].mean(1) - vertices[i]
        inward.append(unit(into - np.outer(into @ along, along)))
    count = len(edges)
    return (
        np.array(edges, int).reshape(count, 2),
        np.array(edge_normals).reshape(count, 2, 3),
        np.array(inward).reshape(count, 2, 3),
        np.array(kinds, int),
    )
