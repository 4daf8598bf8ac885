"""What a frame teaches: skin from face and moving hands, the rest from everywhere else, the still scene from what stays."""

from dataclasses import replace

import cv2
import numpy as np

from vipr.systems.compiled import compiled
from vipr.systems.signals import HandTracks
from vipr.systems.skin import colour_model, scene
from vipr.systems.skin.chromaticity import G_BINS, R_BINS, Chromaticity, histogram, lookup
from vipr.systems.skin.colour_model import doubt_table
from vipr.systems.skin.density import large_patches
from vipr.systems.skin.regions import Found, describe
from vipr.systems.skin.scene import Scene

SURE_FACE = 0.25  # looks of a face, from which the person is known
SOME_MARKS, COMPACT = 0.1, 2.2  # of a head that is not known yet; its area over that of the largest disc in it
STIRRED = 0.3  # of a patch that moved in the last seconds, from which all of it is alive


def learn(model, colours, skin, by_colour, labels, found: Found, still, tracks, scale, dt, options):
    """The still scene and the colour model after ``dt`` s; ``by_colour`` (h, w) uint8 is skin before what is still was taken from it.

    Skin is learned from the face and from what moves in the person's regions, the rest from outside them and from the still scene.
    """
    on_person = _person_pixels(labels, found.person)
    if options.still_scene or options.adapt:
        kept = on_person
        if tracks is not None:
            facelike = (found.faceness > 0.2) & (found.person > 0.3)
            kept = _followed(labels, tracks, scale) | _person_pixels(labels, facelike)
            if not tracks.face_seen:
                head = _person_pixels(labels, _may_be_heads(found))
                kept, on_person = kept | head, on_person | head
            if found.faceness.max(initial=0.0) < SURE_FACE:
                awake = stirring(colours, still)
                kept, on_person = kept | awake, on_person | awake
                still = scene.forget(still, awake)
            head = sleeping_head(by_colour, colours, still, found)
            if head is not None:
                kept, on_person = kept | head, on_person | head
                still = scene.forget(still, head)
        still = scene.settle(still, colours, cv2.dilate(kept, np.ones((3, 3), np.uint8)) > 0, dt)
    if not options.adapt:
        return still, model
    bright, person = colours.bright, on_person > 0
    sample, trust = (skin > 60) & (still.motion > 0.25) & person, 0.6
    if found.faceness.max(initial=0.0) > SURE_FACE:
        best = int(np.argmax(found.faceness))
        x, y, r = found.cores[best]
        ellipse = np.zeros_like(skin)
        cv2.ellipse(ellipse, (round(x), round(y)), (max(1, round(0.95 * r)), max(1, round(1.2 * r))), 0, 0, 360, 1, -1)
        face = (ellipse > 0) & (labels == best + 1) & (skin > 40) & bright
        sample = face | (sample & (lookup(_like(histogram(colours.index[face])), colours.index) > 0))
        trust = float(np.clip(found.faceness[best] / 0.4, 0.6, 1.0))
    rest = histogram_of_rest(colours, bright & ~person, still)
    return still, colour_model.adapt(model, histogram(colours.index[sample & bright]), rest, dt, trust)


def stirring(colours: Chromaticity, still: Scene) -> np.ndarray:
    """(h, w) uint8, 1 on patches that may be skin and of which much moved: a hand that folds two fingers is no thing of the room."""
    may_be = (lookup(doubt_table(), colours.index) > 0.2) & colours.bright
    labels = cv2.connectedComponents(cv2.blur(may_be.astype(np.uint8) * 255, (3, 3)) // 128, connectivity=4)[1]
    size = np.bincount(labels.ravel())
    moved = np.bincount(labels.ravel(), still.alive.ravel()) / np.maximum(size, 1)
    awake = (moved > STIRRED) & (size < 0.4 * labels.size)
    awake[0] = False
    return awake.astype(np.uint8)[labels]


def sleeping_head(by_colour: np.ndarray, colours: Chromaticity, still: Scene, found: Found) -> np.ndarray | None:
    """(h, w) uint8, 1 on the patch of skin's colour above all that moves which may be a head, or None; none where a face is on top.

    A head that nobody knew while it kept still, before wood of nearly its colour, has become a thing of the room.
    """
    moves = _moves(found)
    if not moves.any():
        return None
    top = found.centres[moves, 1].min()
    if ((found.faceness > SURE_FACE) & (found.centres[:, 1] <= top)).any():
        return None
    labels, _, boxes = large_patches(by_colour)
    asleep = describe(labels, boxes, by_colour, colours.luma, replace(still, sure=np.zeros_like(still.sure)))
    wide = asleep.cores[:, 2] > 0.9 * found.cores[moves, 2].max()  # heads are wider than hands
    calm = (asleep.moving < 0.1) & (asleep.centres[:, 1] < top)
    looks = asleep.faceness * (_compact(asleep) & wide & calm)
    return None if looks.max(initial=0.0) < SOME_MARKS else np.uint8(labels == int(np.argmax(looks)) + 1)


def _like(face: np.ndarray) -> np.ndarray:
    """Table (R_BINS, G_BINS) uint8, 1 at colours near those in the histogram of a face: hands are much like it, sleeves seldom."""
    near = cv2.GaussianBlur(face, (0, 0), 3.0)
    return (near > 0.02 * near.max()).astype(np.uint8)


def histogram_of_rest(colours: Chromaticity, outside: np.ndarray, still: Scene) -> np.ndarray:
    """Histogram of what is not the person: what could be skin by its colour counts as far as it is known to stand still."""
    return _count_rest(colours.index, outside, doubt_table(), still.sure)


@compiled
def _count_rest(index, outside, doubt, sure):
    out = np.zeros((R_BINS, G_BINS), np.float32)
    for i in range(index.shape[0]):
        for j in range(index.shape[1]):
            r, g = index[i, j] >> 8, index[i, j] & 255
            if outside[i, j] and 0 < r < R_BINS - 1 and 0 < g < G_BINS - 1:
                out[r, g] += np.float32(1.0) - doubt[r, g] * (np.float32(1.0) - sure[i, j])
    return out


def _may_be_heads(found: Found) -> np.ndarray:
    """(n,) bool: compact regions with some marks of a face above all that moves of the person; heads are often still."""
    moves = _moves(found)
    if not moves.any():
        return moves
    return _compact(found) & (found.faceness > SOME_MARKS) & (found.centres[:, 1] < found.centres[moves, 1].min())


def _moves(found: Found) -> np.ndarray:
    """(n,) bool, of regions of the person that move."""
    return (found.person > 0.5) & (found.moving > 0.3)


def _compact(found: Found) -> np.ndarray:
    """(n,) bool, of regions that are about as wide as high."""
    return found.areas < COMPACT * np.pi * np.maximum(found.cores[:, 2], 1.0) ** 2


def _person_pixels(labels: np.ndarray, person: np.ndarray) -> np.ndarray:
    """(h, w) uint8, 1 on regions that are rather the person than not."""
    table = np.zeros(256, np.uint8)
    table[1 : len(person) + 1] = person > 0.5
    return cv2.LUT(labels, table)


def _followed(labels: np.ndarray, tracks: HandTracks, scale: float) -> np.ndarray:
    """(h, w) uint8, 1 on regions that hold a part seen in the frame before, about that part."""
    about = np.zeros_like(labels)
    for name, area in zip(("face", "left", "right"), tracks.areas, strict=True):
        if getattr(tracks, f"{name}_seen"):
            x, y = (getattr(tracks, name) + 0.5) / scale - 0.5
            cv2.circle(
                about, (round(float(x)), round(float(y))), max(2, round(1.1 * float(np.sqrt(area)) / scale)), 1, -1
            )
    return about & np.minimum(labels, 1)
