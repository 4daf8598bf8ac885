"""A frame with what was seen in it drawn over: regions, tracks, trails. For people to look at; pure."""

import cv2
import numpy as np

from vipr.systems.hands.parts import PARTS
from vipr.systems.signals import HandTracks, SkinRegions

COLOURS = {"face": (80, 220, 80), "left": (255, 140, 40), "right": (60, 80, 255)}  # BGR


def draw_people(
    image: np.ndarray, regions: SkinRegions, tracks: HandTracks, trail: list[HandTracks] = ()
) -> np.ndarray:
    """A copy of image (h, w, 3) BGR with outlines of the regions, a ring on each part that is seen, and the parts' trails."""
    out = image.copy()
    thick = max(1, round(min(image.shape[:2]) / 240))
    if regions.labels.size:
        mask = cv2.resize(
            np.minimum(regions.labels, 1), (image.shape[1], image.shape[0]), interpolation=cv2.INTER_NEAREST
        )
        outlines, _ = cv2.findContours(mask, cv2.RETR_LIST, cv2.CHAIN_APPROX_SIMPLE)
        cv2.drawContours(out, outlines, -1, (255, 255, 255), thick)
    for name in PARTS:
        path = [getattr(t, name) for t in (*trail, tracks) if getattr(t, f"{name}_seen")]
        if len(path) > 1:
            cv2.polylines(out, [np.rint(path).astype(np.int32)], False, COLOURS[name], thick, cv2.LINE_AA)
        if getattr(tracks, f"{name}_seen"):
            centre = tuple(int(v) for v in np.rint(getattr(tracks, name)))
            cv2.circle(out, centre, round(0.035 * min(image.shape[:2])), COLOURS[name], 2 * thick, cv2.LINE_AA)
            cv2.putText(
                out,
                name,
                (centre[0] + 8 * thick, centre[1]),
                cv2.FONT_HERSHEY_SIMPLEX,
                0.4 * thick,
                COLOURS[name],
                thick,
                cv2.LINE_AA,
            )
    return out
