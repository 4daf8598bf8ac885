"""Low-poly solids with normals, colours and texture coordinates, written as OBJ + MTL."""

from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

# name -> diffuse colour (r, g, b), or the file name of a texture
Material = tuple[float, float, float] | str


@dataclass
class Mesh:
    """Polygons: each is (material, points (n, 3), normals (n, 3), texture coordinates (n, 2)); anticlockwise seen from outside."""

    polygons: list = field(default_factory=list)

    def polygon(self, material, points, normals=None, uvs=None):
        """Add one flat polygon; without normals it is shaded flat."""
        points = np.asarray(points, float)
        if normals is None:
            normal = sum(np.cross(points[i], points[(i + 1) % len(points)]) for i in range(len(points)))
            normals = np.tile(normal / np.linalg.norm(normal), (len(points), 1))
        uvs = np.zeros((len(points), 2)) if uvs is None else np.asarray(uvs, float)
        self.polygons.append((material, points, np.asarray(normals, float), uvs))

    def box(self, material, low, high):
        """Axis-parallel box between two corners [m]."""
        (x0, y0, z0), (x1, y1, z1) = low, high
        p = np.array([(x, y, z) for z in (z0, z1) for y in (y0, y1) for x in (x0, x1)])
        for face in BOX_FACES:
            self.polygon(material, p[list(face)])

    def tube(self, material, start, end, radius, end_radius=None, sides=16, caps=(True, True), cap_material=None):
        """Cylinder or frustum from start to end (3,) [m] with smooth sides; caps at start and end."""
        start, end = np.asarray(start, float), np.asarray(end, float)
        end_radius = radius if end_radius is None else end_radius
        axis = end - start
        length = np.linalg.norm(axis)
        x, y = perpendiculars(axis / length)
        a = 2 * np.pi * np.arange(sides + 1) / sides
        ring = np.cos(a)[:, None] * x + np.sin(a)[:, None] * y
        slope = (radius - end_radius) / length
        normals = (ring + slope * axis / length) / np.hypot(1, slope)
        low, high = start + radius * ring, end + end_radius * ring
        for i in range(sides):
            self.polygon(
                material,
                [low[i], low[i + 1], high[i + 1], high[i]],
                [normals[i], normals[i + 1], normals[i + 1], normals[i]],
                [(i / sides, 0), ((i + 1) / sides, 0), ((i + 1) / sides, 1), (i / sides, 1)],
            )
        if caps[0]:
            self.polygon(cap_material or material, low[:0:-1])
        if caps[1]:
            self.polygon(cap_material or material, high[:-1])

    def slab(self, material, circles, z0, z1, sides=16):
        """Prism between z0 and z1 [m] over the convex hull of circles [(x, y, r), ...] in the x-y plane, rounded ends shaded smooth."""
        outline = []  # (point, normal), anticlockwise
        for a in 2 * np.pi * np.arange(sides) / sides:
            normal = np.array([np.cos(a), np.sin(a)])
            support = [normal @ (x, y) + r for x, y, r in circles]
            best = max(support)
            reach = [
                np.array([x, y]) + r * normal for s, (x, y, r) in zip(support, circles, strict=True) if s > best - 1e-9
            ]
            reach.sort(key=lambda p: p @ [-normal[1], normal[0]])
            outline += [(p, normal) for p in (reach if len(reach) < 2 else (reach[0], reach[-1]))]
        for (p, n), (p2, n2) in zip(outline, outline[1:] + outline[:1], strict=True):
            if np.linalg.norm(p2 - p) > 1e-9:
                points = [(*p, z0), (*p2, z0), (*p2, z1), (*p, z1)]
                self.polygon(material, points, [(*n, 0), (*n2, 0), (*n2, 0), (*n, 0)])
        self.polygon(material, [(*p, z1) for p, _ in outline])
        self.polygon(material, [(*p, z0) for p, _ in outline[::-1]])

    def moved(self, X_AB: np.ndarray) -> "Mesh":
        """The same mesh in A, given in B."""
        R, p = X_AB[:3, :3], X_AB[:3, 3]
        return Mesh([(m, v @ R.T + p, n @ R.T, uv) for m, v, n, uv in self.polygons])

    def __add__(self, other):
        return Mesh(self.polygons + other.polygons)

    def write(self, path: Path, materials: dict[str, Material]) -> None:
        """Write ``path`` (.obj) and the .mtl beside it."""
        used = list(dict.fromkeys(m for m, *_ in self.polygons))
        lines = []
        for name in used:
            value = materials[name]
            lines.append(f"newmtl {name}")
            if isinstance(value, str):
                lines += ["Kd 1 1 1", f"map_Kd {value}"]
            else:
                lines.append("Kd " + " ".join(f"{v:g}" for v in value))
            lines.append("")
        path.with_suffix(".mtl").write_text("\n".join(lines))
        tables = {"v": {}, "vt": {}, "vn": {}}
        faces = []
        for name in used:
            faces.append(f"usemtl {name}")
            for material, points, normals, uvs in self.polygons:
                if material == name:
                    corners = [
                        "/".join(str(_index(tables[k], row)) for k, row in (("v", v), ("vt", t), ("vn", n)))
                        for v, t, n in zip(points, uvs, normals, strict=True)
                    ]
                    faces.append("f " + " ".join(corners))
        rows = [f"{kind} " + " ".join(row) for kind, table in tables.items() for row in table]
        path.write_text("\n".join([f"mtllib {path.with_suffix('.mtl').name}", *rows, *faces]) + "\n")


BOX_FACES = ((0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4), (3, 2, 6, 7), (1, 3, 7, 5), (2, 0, 4, 6))


def write_edges(path: Path, points, faces) -> None:
    """Write a CAD edge model: vertices (n, 3) [m] and polygonal faces (vertex numbers, anticlockwise seen from outside), nothing else."""
    rows = [f"v {_text(p)}" for p in points] + ["f " + " ".join(str(i + 1) for i in f) for f in faces]
    path.write_text("\n".join(rows) + "\n")


def perpendiculars(axis: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Unit vectors x, y with x, y, axis right-handed; for the z axis they are those of the frame."""
    x = np.cross([0.0, 1.0, 0.0], axis) if abs(axis[1]) < 0.9 else np.cross(axis, [1.0, 0.0, 0.0])
    x /= np.linalg.norm(x)
    return x, np.cross(axis, x)


def _text(row) -> str:
    return " ".join(f"{round(float(v), 6) + 0.0:g}" for v in row)


def _index(table: dict, row) -> int:
    return table.setdefault(tuple(_text(row).split()), len(table) + 1)
