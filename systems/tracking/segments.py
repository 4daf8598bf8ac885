"""Candidate edges at one pose: straight edges of faces, limbs and rims of cylinders, circles. Frame O: the object's own."""

from typing import NamedTuple

import numpy as np

from vipr.systems.compiled import compiled
from vipr.systems.tracking.cad_model import SMOOTH, WIRE, CadModel, across

RIM_SEGMENTS = 48


class Segments(NamedTuple):
    """S pieces of edges that face the camera."""

    a_O: np.ndarray  # (S, 3) m, where each begins
    b_O: np.ndarray  # (S, 3) m, where it ends
    inside: np.ndarray  # (S, 2) whether the object's surface is seen on the side of +normal, of -normal
    owner: np.ndarray  # (S,) number of the cylinder that a limb or rim belongs to, -1 otherwise
    circle: np.ndarray  # (S, 7) centre, normal, radius of an arc; radius 0 for straight ones
    number: np.ndarray  # (S,) of the edge, limb or rim


NO_SEGMENTS = Segments(
    np.zeros((0, 3)),
    np.zeros((0, 3)),
    np.zeros((0, 2), bool),
    np.zeros(0, int),
    np.zeros((0, 7)),
    np.zeros(0, int),
)


def candidates(model: CadModel, X_CO: np.ndarray) -> Segments:
    """What of the model would be seen at a pose if nothing stood in front."""
    eye = -X_CO[:3, :3].T @ X_CO[:3, 3]  # the camera's centre in O
    E, C = len(model.edges), len(model.cylinders)
    seen, inside = _facing(*model.edge_planes, model.edge_kind, model.closed, eye)
    a_O, b_O, plain = model.straight_edges
    straight = Segments(
        a_O[seen],
        b_O[seen],
        inside,
        plain[: len(seen)],
        np.zeros((len(seen), 7)),
        seen,
    )
    if not C and not len(model.circles):
        return straight
    parts = [straight]
    for i, (p, q, r) in enumerate((c[:3], c[3:6], c[6]) for c in model.cylinders):
        parts.append(limbs(p, q, r, eye, i, E + 2 * i))
        first = E + 2 * C + 2 * i
        parts.append(rim(p, p - q, r, eye, i, q - p, first))
        parts.append(rim(q, q - p, r, eye, i, p - q, first + 1))
    for i, (p, n, r) in enumerate((c[:3], c[3:6], c[6]) for c in model.circles):
        parts.append(rim(p, n, r, eye, -1, None, E + 4 * C + i))
    return Segments(*(np.concatenate(column) for column in zip(*parts, strict=True)))


@compiled
def _facing(planes, offsets, kind, closed, eye):
    """(numbers of the edges that may be seen from eye (3,) in O, inside (S, 2)); planes and offsets as `CadModel.edge_planes` has them."""
    E = len(kind)
    seen, inside = np.empty(E, np.int64), np.empty((E, 2), np.bool_)
    S = 0
    beyond = np.empty(4, np.bool_)
    for e in range(E):
        for i in range(4):
            plane = planes[i * E + e]
            beyond[i] = plane[0] * eye[0] + plane[1] * eye[1] + plane[2] * eye[2] > offsets[i * E + e]
        first, second, left, right = beyond
        contour = kind[e] == SMOOTH and first != second
        if not closed:  # both sides of a face can be seen
            first = second = True
        if contour or (kind[e] != SMOOTH and (first or second or kind[e] == WIRE)):
            on_first, on_second = first and kind[e] != WIRE, second and kind[e] != WIRE
            seen[S] = e
            # The image's y points down: what is left of an edge in a right-handed view is on the side of -normal.
            inside[S, 0] = (on_first and not left) or (on_second and not right)
            inside[S, 1] = (on_first and left) or (on_second and right)
            S += 1
    return seen[:S], inside[:S]


def limbs(p, q, r, eye, owner, number):
    """The two lines where the line of sight touches a cylinder."""
    axis = (q - p) / np.linalg.norm(q - p)
    off = eye - p
    off = off - (off @ axis) * axis
    distance = np.linalg.norm(off)
    if distance <= r:  # seen along the axis
        return NO_SEGMENTS
    u = off / distance
    v = np.cross(axis, u)
    cos, sin = r / distance, np.sqrt(1.0 - (r / distance) ** 2)
    spokes = r * np.array([cos * u + sin * v, cos * u - sin * v])
    left = np.cross(q - p, -spokes) @ (eye - p) > 0
    return Segments(
        p + spokes,
        q + spokes,
        np.stack([~left, left], 1),
        np.full(2, owner),
        np.zeros((2, 7)),
        np.array([number, number + 1]),
    )


def rim(centre, normal, r, eye, owner, body, number):
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
    arc = np.broadcast_to(np.r_[centre, normal, r], (RIM_SEGMENTS, 7))
    return Segments(
        a[seen],
        b[seen],
        np.stack([plus, minus], 1)[seen],
        np.full(seen.sum(), owner),
        arc[seen],
        np.full(seen.sum(), number),
    )
