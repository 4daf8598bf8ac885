"""What a perfect eye would report: face and hands from an image of labels. Pure; :mod:`~vipr.systems.hands.person_truth` is the shell."""

import numpy as np

from vipr.systems.signals import HandTracks

FACE, LEFT, RIGHT = 1, 2, 3  # labels of the visible parts
SEEN_PIXELS_160 = 12.0  # a part counts as seen from this many pixels at 160 px image width (it scales with the area)


def tracks_from_labels(labels: np.ndarray, time: float, number: int) -> HandTracks:
    """Centres of gravity and areas of the visible face and hands in ``labels`` (h, w) of :data:`FACE`, :data:`LEFT`, :data:`RIGHT`."""
    h, w = labels.shape
    flat = labels.ravel().astype(np.int64)
    index = np.flatnonzero((flat >= FACE) & (flat <= RIGHT))
    kind = flat[index]
    count = np.bincount(kind, minlength=4)[1:4].astype(float)
    x = np.bincount(kind, weights=index % w, minlength=4)[1:4]
    y = np.bincount(kind, weights=index // w, minlength=4)[1:4]
    with np.errstate(invalid="ignore", divide="ignore"):
        centres = np.stack([x, y], axis=1) / count[:, None]
    seen = count >= SEEN_PIXELS_160 * (w / 160.0) ** 2
    return HandTracks(
        *centres.copy(), face_seen=bool(seen[0]), left_seen=bool(seen[1]), right_seen=bool(seen[2]),
        areas=np.where(seen, count, 0.0), size=(w, h), time=time, number=number,
    )  # fmt: skip
