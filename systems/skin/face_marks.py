"""How much a patch looks like a face from the front, by which parts are darker than which (after Sinha's ratio template).

Brows and eyes are darker than forehead, nose and cheeks under almost any light, and a face is about as symmetric as it is high. No
learning, no cascade: eleven comparisons on a patch of 12 x 14 pixels.
"""

import cv2
import numpy as np

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


def _operator() -> tuple[np.ndarray, np.ndarray]:
    means = {}
    for name, (r0, r1, c0, c1) in _CELLS.items():
        m = np.zeros((HEIGHT, WIDTH))
        m[r0:r1, c0:c1] = 1.0 / ((r1 - r0) * (c1 - c0))
        means[name] = m.ravel()
    weights = np.array([w for *_, w in _DARKER])
    return np.array([means[light] - means[dark] for dark, light, _ in _DARKER], np.float32), (
        weights / weights.sum()
    ).astype(np.float32)


_CONTRAST, _WEIGHT = _operator()


_FRAMES = (
    (2.0, 0.0),
    (2.0, -0.3),
    (2.0, 0.3),
    (2.4, 0.0),
    (1.65, 0.0),
    (1.65, -0.3),
)  # width of the face, shift down; in core radii


def face_marks(luma: np.ndarray, cores: np.ndarray) -> np.ndarray:
    """(n,) 0 to 1 for luma (h, w) float32 about the cores (n, 3) x y radius [px] of regions; the best of a few heights and widths counts.

    The core of a face is the disc between its cheeks; the face is about 1.25 times as high as wide.
    """
    rows, columns = luma.shape
    patches, owner = [], []
    for i, (x, y, r) in enumerate(cores):
        for width, shift in _FRAMES:
            half, tall = 0.5 * width * r, 0.625 * width * r
            x0, x1 = max(round(x - half), 0), min(round(x + half) + 1, columns)
            y0, y1 = max(round(y + shift * r - tall), 0), min(round(y + shift * r + tall) + 1, rows)
            if x1 - x0 >= 6 and y1 - y0 >= 7:
                patches.append(cv2.resize(luma[y0:y1, x0:x1], (WIDTH, HEIGHT), interpolation=cv2.INTER_AREA))
                owner.append(i)
    best = np.zeros(len(cores))
    if patches:
        p = np.array(patches)
        p -= p.mean(axis=(1, 2), keepdims=True)
        spread = np.sqrt(np.einsum("kij,kij->k", p, p) / (WIDTH * HEIGHT)) + 2.0
        contrast = p.reshape(len(p), -1) @ _CONTRAST.T / spread[:, None]
        agreed = np.clip(contrast * 2.0, -1.0, 1.0) @ _WEIGHT
        symmetry = np.einsum("kij,kij->k", p, p[:, :, ::-1]) / (WIDTH * HEIGHT * spread**2)
        np.maximum.at(best, owner, agreed * (0.5 + 0.5 * np.maximum(symmetry, 0.0)))
    return best
