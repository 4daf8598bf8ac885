"""Writes the living room: a mesh and a texture atlas a decor (``python -m vipr.models.living_room.generate``).

World frame: the floor below the person, x towards the camera, y to the person's left, z up. One mesh and one texture keep a
frame cheap to render. Decors: ``plain`` cool paint, ``wallpaper``, ``beige`` skin-coloured paint, ``wood`` panels beside the person.
"""

from pathlib import Path

import cv2
import numpy as np

from vipr.models.person.generate import write_obj

FOLDER = Path(__file__).parent
TILES = 4  # tiles a side of the atlas
TILE = 128  # px
NAMES = ("wall", "floor", "side", "cupboard", "sofa", "picture", "lamp", "door", "table", "shelf", "curtain", "ceiling")
DECORS = ("plain", "wallpaper", "beige", "wood")


def _box(tile: str, low, high):
    """Axis-aligned box with one tile of the atlas on each face, outward normals (vertices not shared between faces)."""
    low, high = np.asarray(low, float), np.asarray(high, float)
    k = NAMES.index(tile)
    u0, v0 = (k % TILES) / TILES, 1 - (k // TILES + 1) / TILES
    margin = 1.5 / (TILE * TILES)
    uv = np.array([[0, 0], [1, 0], [1, 1], [0, 1]]) * (1 / TILES - 2 * margin) + (u0 + margin, v0 + margin)
    v, vt, f = [], [], []
    for axis in range(3):
        a, b = ((1, 2), (0, 2), (0, 1))[axis]
        for side in (0, 1):
            corners = []
            for s, t in ((0, 0), (1, 0), (1, 1), (0, 1)):
                p = np.empty(3)
                p[axis] = (low, high)[side][axis]
                p[a], p[b] = (low, high)[s][a], (low, high)[t][b]
                corners.append(p)
            flip = (axis == 1) != (side == 0)
            n = len(v)
            v += corners
            vt += list(uv)
            quad = [(0, 1, 2), (0, 2, 3)] if not flip else [(0, 2, 1), (0, 3, 2)]
            f += [tuple(n + i for i in tri) for tri in quad]
    return np.array(v), np.array(vt), np.array(f)


def room():
    """All the boxes of the room; small pieces at different depths between the person and the back wall."""
    boxes = [
        _box("wall", (-1.30, -2.6, -0.1), (-1.25, 2.6, 2.6)),
        _box("floor", (-1.3, -2.6, -0.12), (4.0, 2.6, -0.005)),
        _box("side", (-1.25, -2.65, 0), (4.0, -2.55, 2.6)),
        _box("side", (-1.25, 2.55, 0), (4.0, 2.65, 2.6)),
        _box("ceiling", (-1.3, -2.6, 2.55), (4.0, 2.6, 2.65)),
        _box("cupboard", (-1.25, -1.75, 0.0), (-0.85, -0.75, 1.35)),
        _box("picture", (-1.25, 0.45, 1.45), (-1.22, 1.10, 1.95)),
        _box("door", (-1.25, 1.35, 0.0), (-1.21, 2.15, 2.05)),
        _box("sofa", (-1.2, -0.55, 0.0), (-0.6, 1.15, 0.85)),
        _box("shelf", (-1.25, -1.7, 1.62), (-1.05, -0.8, 1.66)),
        _box("lamp", (-1.15, -1.45, 1.36), (-0.97, -1.25, 1.62)),
        _box("curtain", (-1.24, -2.5, 0.1), (-1.18, -1.9, 2.4)),
        _box("table", (-0.9, 1.25, 0.55), (-0.3, 1.9, 0.6)),
    ]
    v, vt, f, n = [], [], [], 0
    for a, b, c in boxes:
        v.append(a), vt.append(b), f.append(c + n)
        n += len(a)
    return np.vstack(v), np.vstack(vt), np.vstack(f)


def _noise(rng, strength, blur):
    n = rng.standard_normal((TILE, TILE)).astype(np.float32)
    n = cv2.GaussianBlur(n, (0, 0), blur, borderType=cv2.BORDER_REPLICATE) if blur else n
    return (strength * n / n.std())[..., None]


def _paint(rng, rgb, strength=3.0, blur=6.0):
    return np.full((TILE, TILE, 3), rgb, np.float32) + _noise(rng, strength, blur)


def _wood(rng, rgb, planks=5):
    x = np.arange(TILE)
    grain = cv2.GaussianBlur(rng.standard_normal((TILE, TILE)).astype(np.float32), (0, 0), sigmaX=0.8, sigmaY=14)
    tile = np.array(rgb, np.float32) * (1 + 0.16 * (grain / grain.std())[..., None] * 0.6)
    tile[:, (x % (TILE // planks)) < 2] *= 0.72
    for k in range(planks):
        tile[:, k * (TILE // planks) : (k + 1) * (TILE // planks)] *= 1 + 0.1 * rng.standard_normal()
    return tile


def _books(rng):
    tile, x = np.zeros((TILE, TILE, 3), np.float32), 0
    while x < TILE:
        width = int(rng.integers(5, 14))
        tile[:, x : x + width] = rng.uniform(30, 190, 3)
        x += width
    return tile


def atlas(decor: str) -> np.ndarray:
    """(512, 512, 3) BGR atlas of one decor; a fixed generator a decor."""
    rng = np.random.default_rng(DECORS.index(decor) + 11)
    oak, pine = (176, 128, 84), (205, 160, 112)
    tiles = {
        "wall": _paint(rng, (168, 178, 184)),
        "floor": _wood(rng, (120, 104, 92)),
        "side": _paint(rng, (150, 160, 168)),
        "cupboard": _wood(rng, (92, 76, 66), 3),
        "sofa": _paint(rng, (70, 86, 112), 8, 1.0),
        "picture": np.clip(_paint(rng, (90, 130, 120), 45, 9) + _noise(rng, 20, 3), 0, 255),
        "lamp": _paint(rng, (235, 220, 190), 4, 4),
        "door": _paint(rng, (190, 190, 186)),
        "table": _wood(rng, (104, 84, 70)),
        "shelf": _books(rng),
        "curtain": _paint(rng, (110, 125, 110), 10, 2),
        "ceiling": _paint(rng, (200, 202, 200)),
    }
    if decor == "wallpaper":
        wall = _paint(rng, (150, 168, 140), 4)
        y, x = np.mgrid[0:TILE, 0:TILE]
        wall[((x // 8 + y // 16) % 3) == 0] *= 0.82
        tiles["wall"], tiles["cupboard"] = wall, _wood(rng, oak, 3)
    elif decor == "beige":
        tiles["wall"], tiles["side"] = _paint(rng, (214, 184, 158), 4), _paint(rng, (206, 176, 150), 4)
        tiles["floor"], tiles["curtain"] = _wood(rng, pine), _paint(rng, (196, 160, 130), 8, 2)
    elif decor == "wood":
        tiles["wall"] = _wood(rng, (188, 142, 106), 8)
        tiles |= {name: _wood(rng, oak, planks) for name, planks in (("cupboard", 3), ("floor", 5), ("table", 5))}
        tiles["door"] = _wood(rng, pine, 2)
    picture = np.zeros((TILES * TILE, TILES * TILE, 3), np.uint8)
    for k, name in enumerate(NAMES):
        row, column = divmod(k, TILES)
        picture[row * TILE : (row + 1) * TILE, column * TILE : (column + 1) * TILE] = np.clip(tiles[name], 0, 255)[
            ..., ::-1
        ]
    return picture


def main() -> None:
    """Write the mesh and the atlases."""
    write_obj(FOLDER / "room.obj", room(), smooth=False)
    for decor in DECORS:
        cv2.imwrite(str(FOLDER / f"{decor}.png"), atlas(decor))


if __name__ == "__main__":
    main()
