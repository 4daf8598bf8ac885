"""A drawing as a picture: how much ink lies where and which way it runs, line by line, whatever the order of drawing.

Somebody else may begin a letter at its other end; what he leaves behind looks the same. The picture is read as text is read by optical
hidden Markov models: lines from top to bottom (or columns from left to right) are the observations of a left-right chain.
"""

import numpy as np

LINES, ACROSS = 10, 5  # observations of a picture, and cells of each
FINER = 4  # samples between two points


def ink(points: np.ndarray, axis: int) -> np.ndarray:
    """(N, LINES, 3 ACROSS) of points (N, T, 2) in a box from -1/2 to 1/2, lines along ``axis`` (0: from small x to large, 1: y).

    For each cell: ink, and ink times cosine and sine of twice the angle of its strokes; saturating where strokes overlap.
    """
    N = len(points)
    step = np.diff(points, axis=1)
    length = np.linalg.norm(step, axis=2)
    double = (step[..., 0] + 1j * step[..., 1]) ** 2 / np.maximum(length, 1e-9) ** 2
    share = (np.arange(FINER) + 0.5) / FINER
    at = (points[:, :-1, None] + share[:, None] * step[:, :, None]).reshape(N, -1, 2) + 0.5
    amount = np.repeat(length * (LINES / FINER), FINER, axis=1)
    channels = [amount, *(amount * np.repeat(c, FINER, axis=1) for c in (double.real, double.imag))]
    line, line_share = _cell(at[..., axis], LINES)
    cell, cell_share = _cell(at[..., 1 - axis], ACROSS)
    place = (np.arange(N)[:, None] * LINES + line) * ACROSS + cell
    size = N * LINES * ACROSS
    out = np.zeros((3, size))
    for down, along in ((0, 0), (0, 1), (1, 0), (1, 1)):
        weight = (line_share if down else 1.0 - line_share) * (cell_share if along else 1.0 - cell_share)
        index = (place + down * ACROSS + along).ravel()
        for total, channel in zip(out, channels, strict=True):
            total += np.bincount(index, (channel * weight).ravel(), size)
    picture = np.moveaxis(out.reshape(3, N, LINES, ACROSS), 0, 2)
    picture = picture / (1.0 + picture[:, :, :1])
    return picture.reshape(N, LINES, 3 * ACROSS)


def _cell(x, count):
    """The cell (..., of count) below each x in 0..1 and how far x is on the way to the next one."""
    place = np.clip(x * count - 0.5, 0.0, count - 1.001)
    cell = place.astype(int)
    return cell, place - cell
