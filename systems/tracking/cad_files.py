"""Model files: polygon OBJ, ViSP's CAO (V1), a YAML with cylinders, and meshes through trimesh; metres, frame O."""

from itertools import pairwise
from pathlib import Path

import numpy as np
import yaml

from vipr.systems.errors import InputError
from vipr.systems.tracking.cad_model import Shape
from vipr.systems.tracking.triangulation import unit

MESHES = (".stl", ".ply", ".off", ".glb", ".gltf", ".dae", ".3mf")


def read_shape(path: Path) -> Shape:
    """What the file says. Raises InputError with the file's name and line."""
    readers = {".obj": _read_obj, ".cao": _read_cao, ".yaml": _read_yaml, ".yml": _read_yaml}
    readers |= dict.fromkeys(MESHES, _read_mesh)
    reader = readers.get(path.suffix.lower())
    if reader is None:
        raise InputError(f"model {path}: unknown kind {path.suffix or '(no ending)'}, allowed: {', '.join(readers)}")
    if not path.is_file():
        raise InputError(f"model {path}: no such file")
    return reader(path)


def _text(path):
    try:
        return path.read_text()
    except (OSError, UnicodeDecodeError) as error:
        raise InputError(f"model {path}: cannot be read ({error})") from None


def _number(word, kind, where):
    try:
        return kind(word)
    except ValueError:
        wanted = "a whole number" if kind is int else "a number"
        raise InputError(f"{where}: expected {wanted}, got {word!r}") from None


def _read_obj(path):
    points, faces, lines = [], [], []
    for row, line in enumerate(_text(path).splitlines(), 1):
        words, where = line.split("#")[0].split(), f"model {path} line {row}"
        if not words:
            continue
        if words[0] == "v":
            if len(words) < 4:
                raise InputError(f"{where}: a vertex needs 3 coordinates, got {len(words) - 1}")
            points.append([_number(w, float, where) for w in words[1:4]])
        elif words[0] in "fl" and len(words[0]) == 1:
            loop = [_number(w.split("/")[0], int, where) for w in words[1:]]
            loop = [i - 1 if i > 0 else len(points) + i for i in loop]
            if not loop or min(loop) < 0 or max(loop) >= len(points):
                raise InputError(f"{where}: names a vertex outside 1 to {len(points)}")
            if words[0] == "f" and len(loop) < 3:
                raise InputError(f"{where}: a face needs 3 vertices or more, got {len(loop)}")
            if words[0] == "f":
                faces.append(tuple(loop))
            else:
                lines += list(pairwise(loop))
    if not faces and not lines:
        raise InputError(f"model {path}: has no faces ('f' lines); a tracker needs the model's edges")
    return Shape(path.stem, np.array(points, float).reshape(-1, 3), tuple(faces), tuple(lines))


def _read_mesh(path):
    import trimesh

    try:
        mesh = trimesh.load(path, force="mesh", process=False)
    except Exception as error:  # trimesh raises whatever its many readers raise
        raise InputError(f"model {path}: cannot be read as a mesh ({str(error).splitlines()[0]})") from None
    if not len(mesh.faces):
        raise InputError(f"model {path}: has no faces; a tracker needs the model's edges")
    return Shape(path.stem, np.asarray(mesh.vertices, float), tuple(map(tuple, np.asarray(mesh.faces).tolist())))


def _read_yaml(path):
    try:
        content = yaml.safe_load(_text(path))
    except yaml.YAMLError as error:
        raise InputError(f"model {path}: is not YAML ({str(error).splitlines()[0]})") from None
    known = {"name", "polyhedron", "cylinders"}
    if not isinstance(content, dict) or set(content) - known:
        extra = ", ".join(map(str, set(content) - known)) if isinstance(content, dict) else type(content).__name__
        raise InputError(f"model {path}: expected {', '.join(sorted(known))}, got {extra}")
    base = Shape()
    if content.get("polyhedron"):
        base = read_shape(path.parent / str(content["polyhedron"]))
    cylinders = []
    for k, entry in enumerate(content.get("cylinders") or []):
        try:
            a, b = (np.array(entry[key], float).reshape(3) for key in ("axis_start", "axis_end"))
            cylinders.append((a, b, float(entry["radius"])))
        except (KeyError, TypeError, ValueError):
            raise InputError(
                f"model {path}: cylinder {k} needs axis_start [x, y, z], axis_end [x, y, z] and radius in metres, "
                f"got {entry!r}"
            ) from None
    return Shape(
        str(content.get("name") or path.stem),
        base.points,
        base.faces,
        base.lines,
        (*base.cylinders, *cylinders),
        base.circles,
    )


class _CaoWords:
    """Words of the non-comment lines of a CAO file, taken section by section."""

    def __init__(self, path):
        self.path = path
        rows = enumerate(_text(path).splitlines(), 1)
        self.rows = [(n, words) for n, line in rows if (words := line.split("#")[0].split())]

    def row(self, what):
        if not self.rows:
            raise InputError(f"model {self.path}: the file ends where {what} was expected")
        n, words = self.rows.pop(0)
        return f"model {self.path} line {n}", words

    def count(self, what):
        """Entries of the next section; 0 where the file has ended (later sections may be missing)."""
        if not self.rows:
            return 0
        where, words = self.row(f"the number of {what}")
        n = _number(words[0], int, f"{where}, number of {what}")
        if n < 0:
            raise InputError(f"{where}: the number of {what} must not be negative, got {n}")
        return n

    def numbers(self, what, kinds):
        where, words = self.row(what)
        if len(words) < len(kinds):
            raise InputError(f"{where}: {what} needs {len(kinds)} numbers, got {len(words)}")
        return [_number(w, k, where) for w, k in zip(words, kinds, strict=False)], where

    def indices(self, what, limit):
        where, words = self.row(what)
        size = _number(words[0], int, where)
        loop = [_number(w, int, where) for w in words[1 : 1 + max(size, 0)]]
        if size < 1 or len(loop) < size:
            raise InputError(f"{where}: {what} says {size} indices and gives {len(loop)}")
        return self.check(loop, limit, where)

    def check(self, loop, limit, where):
        if any(not 0 <= i < limit for i in loop):
            raise InputError(f"{where}: an index is outside 0 to {limit - 1}")
        return loop


def _read_cao(path):
    words = _CaoWords(path)
    where, head = words.row("V1")
    if head[0].upper() != "V1":
        raise InputError(f"{where}: a CAO file begins with V1, got {head[0]!r}")
    if words.rows and words.rows[0][1][0].startswith("load"):
        raise InputError(
            f"model {path}: includes other files by load(...), which is not supported; merge them into one"
        )
    points = [words.numbers("a point", (float,) * 3)[0] for _ in range(words.count("points"))]
    lines = []
    for _ in range(words.count("lines")):
        pair, where = words.numbers("a line", (int, int))
        lines.append(tuple(words.check(pair, len(points), where)))
    used, faces = set(), []
    for _ in range(words.count("faces from lines")):
        chain = words.indices("a face from lines", len(lines))
        used.update(chain)
        faces.append(_loop([lines[i] for i in chain], f"model {path}"))
    for _ in range(words.count("faces from points")):
        face = words.indices("a face from points", len(points))
        if len(face) == 2:
            lines.append(tuple(face))
        elif len(face) > 2:
            faces.append(tuple(face))
    cylinders, circles = [], []
    position = np.array(points, float).reshape(-1, 3)
    for _ in range(words.count("cylinders")):
        (a, b, r), where = words.numbers("a cylinder", (int, int, float))
        words.check((a, b), len(points), where)
        cylinders.append((position[a], position[b], r))
    for _ in range(words.count("circles")):
        (r, c, a, b), where = words.numbers("a circle", (float, int, int, int))
        words.check((c, a, b), len(points), where)
        normal = np.cross(position[a] - position[c], position[b] - position[c])
        circles.append((position[c], unit(normal), r))
    loose = tuple(line for i, line in enumerate(lines) if i not in used)
    return Shape(path.stem, position, tuple(faces), loose, tuple(cylinders), tuple(circles))


def _loop(segments, who):
    """Points in order around a chain of segments."""
    loop, rest = list(segments[0]), list(segments[1:])
    while rest:
        for k, (a, b) in enumerate(rest):
            if loop[-1] in (a, b):
                loop.append(b if loop[-1] == a else a)
                del rest[k]
                break
        else:
            raise InputError(f"{who}: the lines {segments} of a face do not form a closed loop")
    if loop[0] != loop[-1]:
        raise InputError(f"{who}: the lines {segments} of a face do not form a closed loop")
    return tuple(loop[:-1])
