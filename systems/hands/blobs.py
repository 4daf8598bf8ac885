"""From a region to the hand or face in it: the end of a bare arm, the parts of a merged region. Pixels of the labels."""

import numpy as np

ARM_SLENDERNESS = 3.0  # length over width from which a region is an arm with a hand at one end
HAND_LENGTH_IN_WIDTHS = 2.3  # a hand is about this much longer than its arm is wide


def pixels_of(labels: np.ndarray, row: int) -> np.ndarray:
    """(n, 2) float x, y of the pixels of region ``row``."""
    y, x = np.divmod(np.flatnonzero(labels == row + 1), labels.shape[1])
    return np.column_stack([x, y]).astype(float)


def ends(p: np.ndarray) -> tuple[np.ndarray, np.ndarray, float, float]:
    """The two ends (2,) of a blob p (n, 2), its length and its mean width [px]."""
    a = p[np.argmax(((p - p.mean(0)) ** 2).sum(1))]
    b = p[np.argmax(((p - a) ** 2).sum(1))]
    length = float(np.hypot(*(a - b))) + 1.0
    return a, b, length, len(p) / length


def hand_end(p: np.ndarray, expected, root, shape) -> tuple[np.ndarray, float]:
    """Centre (2,) of the hand in blob p (n, 2), and the number of its pixels.

    A compact blob is the hand. Of a slender one, the hand is the end nearer to ``expected`` (2,) or None, or else farther from ``root``
    (2,), the shoulder; where that is None too, the end farther from the border of the image of ``shape`` (h, w).
    """
    a, b, length, width = ends(p)
    if length < ARM_SLENDERNESS * width or len(p) < 12:
        return p.mean(0), float(len(p))
    if expected is not None:
        tip, _ = (a, b) if ((a - expected) ** 2).sum() < ((b - expected) ** 2).sum() else (b, a)
    elif root is not None:
        tip, _ = (a, b) if ((a - root) ** 2).sum() > ((b - root) ** 2).sum() else (b, a)
    else:
        tip, _ = (a, b) if _inside(a, shape) > _inside(b, shape) else (b, a)
    reach = min(HAND_LENGTH_IN_WIDTHS * width, 0.6 * length)
    hand = p[((p - tip) ** 2).sum(1) < reach**2]
    return hand.mean(0), float(len(hand))


def _inside(p: np.ndarray, shape) -> float:
    return min(p[0], p[1], shape[1] - 1 - p[0], shape[0] - 1 - p[1])


def split(p: np.ndarray, centres: np.ndarray, radii: np.ndarray, rounds: int = 3) -> tuple[np.ndarray, np.ndarray]:
    """Share the pixels p (n, 2) of a merged region between parts expected at centres (k, 2) with radii (k,).

    Returns the parts' centres (k, 2) and pixel counts (k,); a part without pixels keeps its expected centre. Pixels far from every part
    (a bare arm) belong to none.
    """
    c = centres.astype(float).copy()
    count = np.zeros(len(c))
    for _ in range(rounds):
        d = np.sqrt(((p[:, None] - c[None]) ** 2).sum(2)) / radii
        nearest = d.argmin(1)
        near = d[np.arange(len(p)), nearest] < 1.6
        for k in range(len(c)):
            mine = p[near & (nearest == k)]
            count[k] = len(mine)
            if len(mine):
                c[k] = 0.5 * c[k] + 0.5 * mine.mean(0)
    return c, count
