"""Triangles of plane polygons, convex or not, and of round bodies."""

import numpy as np


def unit(v: np.ndarray) -> np.ndarray:
    """Vectors (..., 3) at length one; zero stays zero."""
    v = np.asarray(v, float)
    length = np.linalg.norm(v, axis=-1, keepdims=True)
    return np.divide(v, length, out=np.zeros_like(v), where=length > 0)


def triangulate(points: np.ndarray, face) -> list[tuple[int, int, int]]:
    """Triangles (index triples) of one polygon by clipping ears; a polygon without area gives none."""
    loop = [int(i) for k, i in enumerate(face) if i != face[k - 1]]
    if len(loop) < 3:
        return []
    corners = points[loop]
    normal = np.cross(corners, np.roll(corners, -1, 0)).sum(0)  # Newell: twice the area vector
    if np.linalg.norm(normal) < 1e-12 * max(np.ptp(corners, axis=0).max(), 1e-9) ** 2:
        return []
    drop = np.argmax(np.abs(normal))
    flat = np.delete(points, drop, axis=1) * (1.0 if (normal[drop] > 0) == (drop != 1) else -1.0, 1.0)

    def turn(a, b, c):
        (ax, ay), (bx, by), (cx, cy) = flat[a], flat[b], flat[c]
        return (bx - ax) * (cy - ay) - (by - ay) * (cx - ax)

    triangles = []
    while len(loop) > 3:
        for k, b in enumerate(loop):
            a, c = loop[k - 1], loop[(k + 1) % len(loop)]
            others = [p for p in loop if p not in (a, b, c)]
            if turn(a, b, c) > 0 and not any(
                turn(a, b, p) >= 0 and turn(b, c, p) >= 0 and turn(c, a, p) >= 0 for p in others
            ):
                triangles.append((a, b, c))
                del loop[k]
                break
        else:  # no ear: collinear points or a polygon that crosses itself
            k = min(range(len(loop)), key=lambda k: abs(turn(loop[k - 1], loop[k], loop[(k + 1) % len(loop)])))
            del loop[k]
    if abs(turn(*loop)) > 0:
        triangles.append(tuple(loop))
    return triangles


def cylinder_triangles(start: np.ndarray, end: np.ndarray, radius: float, sides: int = 24) -> np.ndarray:
    """(T, 3, 3) triangles of a closed cylinder inscribed in the one given [m]."""
    axis = unit(end - start)
    u = unit(np.cross(axis, np.eye(3)[np.argmin(np.abs(axis))]))
    angle = np.linspace(0.0, 2.0 * np.pi, sides + 1)
    ring = radius * (np.outer(np.cos(angle), u) + np.outer(np.sin(angle), np.cross(axis, u)))
    a, b, c, d = start + ring[:-1], start + ring[1:], end + ring[:-1], end + ring[1:]
    low, high = np.broadcast_to(start, a.shape), np.broadcast_to(end, a.shape)
    return np.concatenate([np.stack(t, 1) for t in ((a, b, d), (a, d, c), (low, b, a), (high, c, d))])


def sphere_triangles(centre: np.ndarray, radius: float, rings: int = 8) -> np.ndarray:
    """(T, 3, 3) triangles of a sphere [m], as latitude rings."""
    latitude = np.linspace(-0.5 * np.pi, 0.5 * np.pi, rings + 1)
    longitude = np.linspace(0.0, 2.0 * np.pi, 2 * rings + 1)
    y, x = np.meshgrid(latitude, longitude, indexing="ij")
    p = centre + radius * np.stack([np.cos(y) * np.cos(x), np.cos(y) * np.sin(x), np.sin(y)], -1)
    a, b, c, d = p[:-1, :-1], p[:-1, 1:], p[1:, 1:], p[1:, :-1]
    return np.concatenate([np.stack([a, b, c], 2).reshape(-1, 3, 3), np.stack([a, c, d], 2).reshape(-1, 3, 3)])


def box_triangles(size: np.ndarray) -> np.ndarray:
    """(12, 3, 3) triangles of a box centred on its frame, size (3,) [m]."""
    corner = 0.5 * np.asarray(size, float) * np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)])
    quads = ((0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3))
    return np.array([corner[list(t)] for a, b, c, d in quads for t in ((a, b, c), (a, c, d))])
