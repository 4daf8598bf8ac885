"""How much a patch looks like a face from the front, by which parts are darker than which (after Sinha's ratio template).

Brows and eyes are darker than forehead, nose and cheeks under almost any light, and a face is about as symmetric as it is high. No
learning, no cascade: eleven comparisons on a patch of 12 x 14 pixels.
"""

import numpy as np

from vipr.systems.compiled import compiled

WIDTH, HEIGHT = 12, 14
# Cells (row0, row1, column0, column1) of the patch.
_CELLS = {
    "forehead": (0, 3, 3, 9), "left_eye": (4, 6, 1, 5), "right_eye": (4, 6, 7, 11), "nose_bridge": (4, 7, 5, 7),
    "left_cheek": (7, 10, 1, 4), "right_cheek": (7, 10, 8, 11), "nose": (7, 9, 5, 7), "mouth": (10, 12, 4, 8), "chin": (12, 14, 4, 8),
}  # fmt: skip
_DARKER = (
    ("left_eye", "forehead", 1.0), ("right_eye", "forehead", 1.0), ("left_eye", "left_cheek", 1.0), ("right_eye", "right_cheek", 1.0),
    ("left_eye", "nose", 0.8), ("right_eye", "nose", 0.8), ("left_eye", "nose_bridge", 0.7), ("right_eye", "nose_bridge", 0.7),
    ("mouth", "nose", 0.5), ("mouth", "chin", 0.5), ("mouth", "left_cheek", 0.3), ("mouth", "right_cheek", 0.3),
)  # fmt: skip


def _comparisons() -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Cells of the patch that the comparisons take, by how much, where each comparison begins and ends among them, and its weight."""
    means = {}
    for name, (r0, r1, c0, c1) in _CELLS.items():
        m = np.zeros((HEIGHT, WIDTH))
        m[r0:r1, c0:c1] = 1.0 / ((r1 - r0) * (c1 - c0))
        means[name] = m.ravel()
    rows = [(means[light] - means[dark]).astype(np.float32) for dark, light, _ in _DARKER]
    cells = [np.flatnonzero(row) for row in rows]
    weights = np.array([w for *_, w in _DARKER])
    return (
        np.concatenate(cells), np.concatenate([row[c] for row, c in zip(rows, cells, strict=True)]),
        np.cumsum([0, *map(len, cells)]), (weights / weights.sum()).astype(np.float32),
    )  # fmt: skip


_COMPARISONS = _comparisons()


_FRAMES = np.array(
    [(2.0, 0.0), (2.0, -0.3), (2.0, 0.3), (2.4, 0.0), (1.65, 0.0), (1.65, -0.3)]
)  # width of the face, shift down; in core radii


def face_marks(luma: np.ndarray, cores: np.ndarray) -> np.ndarray:
    """(n,) 0 to 1 for luma (h, w) float32 about the cores (n, 3) x y radius [px] of regions; the best of a few heights and widths counts.

    The core of a face is the disc between its cheeks; the face is about 1.25 times as high as wide.
    """
    return np.array([min(_best_marks(luma, core, _FRAMES, *_COMPARISONS), 1.0) for core in np.asarray(cores, float)])


@compiled
def _best_marks(luma, core, frames, cells, shares, begins, weights):
    best = 0.0
    for k in range(len(frames)):
        best = max(best, _marks(luma, core, frames[k, 0], frames[k, 1], cells, shares, begins, weights))
    return best


@compiled
def _marks(luma, core, width, shift, cells, shares, begins, weights):
    """0 to 1 for the patch that is ``width`` radii wide and ``shift`` radii below the core: which parts are darker, and the symmetry."""
    x, y, r = core
    half, tall = 0.5 * width * r, 0.625 * width * r
    x0, x1 = max(round(x - half), 0), min(round(x + half) + 1, luma.shape[1])
    y0, y1 = max(round(y + shift * r - tall), 0), min(round(y + shift * r + tall) + 1, luma.shape[0])
    if x1 - x0 < 6 or y1 - y0 < 7:
        return 0.0
    patch = _reduced(luma[y0:y1, x0:x1])
    patch -= patch.mean()
    variance = (patch**2).mean()
    spread = np.sqrt(variance) + 2.0
    agreed, flat = 0.0, patch.ravel()
    for k in range(len(weights)):
        contrast = 0.0
        for c in range(begins[k], begins[k + 1]):
            contrast += shares[c] * flat[cells[c]]
        contrast /= spread
        agreed += weights[k] * min(max(2.0 * contrast, -1.0), 1.0)
    symmetry = (patch * patch[:, ::-1]).mean() / spread**2
    return agreed * min(
        0.5 + 0.5 * symmetry, 0.3 + 1.17 * max(symmetry, 0.0)
    )  # what is hardly symmetric is hardly a face


@compiled
def _reduced(image):
    """(HEIGHT, WIDTH) means of the image over equal cells, parts of pixels counted by their area."""
    rows, columns = image.shape
    out = np.zeros((HEIGHT, WIDTH))
    for i in range(HEIGHT):
        top, bottom = i * rows / HEIGHT, (i + 1) * rows / HEIGHT
        for j in range(WIDTH):
            left, right = j * columns / WIDTH, (j + 1) * columns / WIDTH
            total = 0.0
            for y in range(int(top), min(int(np.ceil(bottom)), rows)):
                high = min(bottom, y + 1.0) - max(top, float(y))
                for x in range(int(left), min(int(np.ceil(right)), columns)):
                    total += image[y, x] * high * (min(right, x + 1.0) - max(left, float(x)))
            out[i, j] = total / ((bottom - top) * (right - left))
    return out
