"""What is seen in rendered sequences, written as OBJ files: printed boxes, a cluttered background, a hand.

All faces are flat shaded and of few triangles; pictures are made from a seed. Lengths in m.
"""

from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np


def picture(seed: int, width: int = 256, height: int = 256, shapes: int = 25, base: int = 150) -> np.ndarray:
    """A (height, width, 3) BGR print of coloured blocks, discs, strokes and lettering."""
    rng = np.random.default_rng(seed)
    image = np.full((height, width, 3), base, np.uint8)
    image[:] = rng.integers(base - 50, base + 80, 3)
    size = min(width, height)
    for _ in range(shapes):
        colour = tuple(int(c) for c in rng.integers(20, 255, 3))
        x, y = int(rng.integers(0, width)), int(rng.integers(0, height))
        kind, s = rng.integers(4), int(rng.integers(size // 16, size // 5))
        if kind == 0:
            cv2.rectangle(image, (x, y), (x + s, y + int(s * rng.uniform(0.3, 1.5))), colour, -1)
        elif kind == 1:
            cv2.circle(image, (x, y), s // 2, colour, -1, cv2.LINE_AA)
        elif kind == 2:
            end = (x + int(rng.integers(-2 * s, 2 * s)), y + int(rng.integers(-2 * s, 2 * s)))
            cv2.line(image, (x, y), end, colour, max(1, s // 8), cv2.LINE_AA)
        else:
            word = "".join(chr(c) for c in rng.integers(65, 91, 4))
            cv2.putText(image, word, (x - s, y), cv2.FONT_HERSHEY_SIMPLEX, s / 30, colour, max(1, s // 16), cv2.LINE_AA)
    return image


@dataclass
class Mesh:
    """Polygons with a flat normal each, and texture coordinates where there is a picture."""

    faces: list[np.ndarray]  # (n, 3) corners each [m], counter-clockwise from outside
    uv: list[np.ndarray] | None = None  # (n, 2) each

    @property
    def points(self) -> np.ndarray:
        return np.unique(np.concatenate(self.faces).round(9), axis=0)

    def write(self, path: Path, *, colour=(0.8, 0.8, 0.8), image: np.ndarray | None = None) -> Path:
        """Write the OBJ with its MTL (and PNG); returns the path of the OBJ."""
        name = path.stem
        v, vn, vt, f = [], [], [], []
        for k, corners in enumerate(self.faces):
            normal = np.cross(corners[1] - corners[0], corners[2] - corners[1])
            normal /= max(np.linalg.norm(normal), 1e-12)
            first = len(v) + 1
            v += [f"v {x:.9g} {y:.9g} {z:.9g}" for x, y, z in corners]
            vn.append("vn {:.6g} {:.6g} {:.6g}".format(*normal))
            uv = self.uv[k] if self.uv is not None else np.zeros((len(corners), 2))
            vt += [f"vt {a:.6g} {b:.6g}" for a, b in uv]
            # Triangles: some readers want no larger polygons.
            for i in range(1, len(corners) - 1):
                f.append("f " + " ".join(f"{first + j}/{first + j}/{k + 1}" for j in (0, i, i + 1)))
        path.write_text("\n".join([f"mtllib {name}.mtl", "usemtl paint", *v, *vt, *vn, *f]) + "\n")
        kd = (1.0, 1.0, 1.0) if image is not None else colour
        lines = ["newmtl paint", "Kd {} {} {}".format(*kd), "Ks 0 0 0"]
        if image is not None:
            cv2.imwrite(str(path.with_suffix(".png")), image)
            lines.append(f"map_Kd {name}.png")
        path.with_suffix(".mtl").write_text("\n".join(lines) + "\n")
        return path


def box(size, centre=(0.0, 0.0, 0.0)) -> Mesh:
    """A box (sx, sy, sz); its picture is laid out as 3 x 2 tiles, one a face."""
    h = 0.5 * np.asarray(size, float)
    faces, uv = [], []
    for k in range(6):
        axis, sign = k % 3, 1.0 if k < 3 else -1.0
        b, c = (axis + 1) % 3, (axis + 2) % 3
        corners = np.zeros((4, 3))
        corners[:, axis] = sign * h[axis]
        corners[:, b] = np.array([-1, 1, 1, -1]) * h[b] * sign
        corners[:, c] = np.array([-1, -1, 1, 1]) * h[c]
        faces.append(corners + np.asarray(centre, float))
        tile = np.array([[0.01, 0.01], [0.99, 0.01], [0.99, 0.99], [0.01, 0.99]])
        uv.append((tile + np.array([k % 3, k // 3])) / (3, 2))
    return Mesh(faces, uv)


def wall(width: float, height: float) -> Mesh:
    """A sheet across the line of sight, facing the camera (towards -z)."""
    x, y = 0.5 * width, 0.5 * height
    corners = np.array([[-x, y, 0], [-x, -y, 0], [x, -y, 0], [x, y, 0.0]])
    return Mesh([corners], [np.array([[0, 0], [0, 1], [1, 1], [1, 0.0]])])


def prism(start, end, radius: float, tip: float | None = None, sides: int = 8) -> list[np.ndarray]:
    """Faces of a closed prism around the segment, narrowing to the radius ``tip``."""
    start, end = np.asarray(start, float), np.asarray(end, float)
    axis = (end - start) / np.linalg.norm(end - start)
    side = np.cross(axis, [0, 0, 1.0] if abs(axis[2]) < 0.9 else [1.0, 0, 0])
    side /= np.linalg.norm(side)
    other = np.cross(axis, side)
    a = np.arange(sides) * 2 * np.pi / sides
    ring = np.cos(a)[:, None] * side + np.sin(a)[:, None] * other
    first, last = start + radius * ring, end + (radius if tip is None else tip) * ring
    faces = [np.array([first[i], first[i - sides + 1], last[i - sides + 1], last[i]]) for i in range(sides)]
    return [*faces, first[::-1], last]


def hand(length: float = 0.085) -> Mesh:
    """A flat right hand with its forearm: fingertips at the origin, fingers along -x, palm and arm towards +x; back towards -z."""
    faces = []
    for k, reach in enumerate((0.0, -0.008, 0.0, 0.014)):
        y = (k - 1.5) * 0.021
        faces += prism([length + 0.005, y, 0], [-reach * 1.0 if reach < 0 else reach, y * 1.05, 0], 0.0105, 0.0085)
    faces += box((0.09, 0.086, 0.026), (length + 0.045, 0.0, 0.0)).faces
    faces += prism([length + 0.02, -0.055, 0.0], [length - 0.035, -0.075, 0.012], 0.012, 0.009)
    faces += prism([length + 0.085, 0.0, 0.0], [length + 0.6, 0.12, 0.03], 0.03, 0.045, 10)
    return Mesh(faces)
