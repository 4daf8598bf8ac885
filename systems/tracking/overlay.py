"""The model drawn over the image, with the tracker's state: what a person looks at to see whether it tracks."""

import cv2
import numpy as np

from vipr.systems.camera.lens import Lens
from vipr.systems.tracking.cad_model import CadModel
from vipr.systems.tracking.visible_edges import visible_nodes

COLOURS = {"tracking": (60, 220, 60), "uncertain": (0, 190, 255), "lost": (60, 60, 255)}  # BGR


def draw_overlay(
    image: np.ndarray,
    model: CadModel,
    lens: Lens,
    X_CO: np.ndarray,
    state: str,
    text: str = "",
    occluders_C=None,
    line: int = 0,
) -> np.ndarray:
    """A copy of the image (h, w[, 3]) as BGR with the visible edges at X_CO in the state's colour; of a lost object no edges.

    The text and the state stand in the ``line``-th line of the corner.
    """
    canvas = cv2.cvtColor(image, cv2.COLOR_GRAY2BGR) if image.ndim == 2 else image.copy()
    colour = COLOURS.get(state, (255, 255, 255))
    if state != "lost":
        nodes = visible_nodes(model, X_CO, lens, 4000, 1.0, occluders_C, border=1.0)
        x, y = np.round(nodes.pixel).astype(int).T
        for dx, dy in ((0, 0), (1, 0), (0, 1)):
            canvas[np.minimum(y + dy, len(canvas) - 1), np.minimum(x + dx, canvas.shape[1] - 1)] = colour
    _write(canvas, f"{text} {state}".strip(), colour, line)
    return canvas


def _write(canvas: np.ndarray, text: str, colour: tuple[int, int, int], line: int) -> None:
    """Text in the corner with a dark rim: the same glyphs shifted, as a bolder font may be wider."""
    scale = max(canvas.shape[1] / 1280.0, 0.4)
    x, y = int(12 * scale) + 2, int((34 + 40 * line) * scale) + 4
    rim = [((dx, dy), (0, 0, 0)) for dx in (-1, 0, 1) for dy in (-1, 0, 1)]
    for (dx, dy), shade in (*rim, ((0, 0), colour)):
        cv2.putText(canvas, text, (x + dx, y + dy), cv2.FONT_HERSHEY_SIMPLEX, 1.1 * scale, shade, 1, cv2.LINE_AA)
