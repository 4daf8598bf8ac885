"""Patches of keyframes that do not belong to the object: of fingers that held it when it was learnt.

They move with the object, so the texture agrees with itself; but they lie before the surface that they are taken for, and lead the pose
astray as it turns. Where the edges contradict the texture, patches that look wrong at the pose of the edges are given up; and no patch is
learnt where older ones say that something covers the object.
Frames: O object, C camera.
"""

import numpy as np

from vipr.systems.tracking.keyframes import Keyframe, view_difference
from vipr.systems.tracking.sight import Sight
from vipr.systems.tracking.texture import looks_right

# Difference of views up to which patches are given up, and up to which they say what is covered.
SEEN_ALIKE, COMPARABLE = 0.6, 0.8
FEWEST = 8  # patches of a keyframe that is kept
NEARBY = 12.0  # px
SILENT = 0.05  # patches: so little nearby says nothing


def given_up(keyframes: tuple[Keyframe, ...], X_CO: np.ndarray, sight: Sight) -> tuple[Keyframe, ...]:
    """The keyframes without the patches that look wrong at a pose that the edges confirm; those known beforehand stay as they are."""
    kept = []
    for keyframe in keyframes:
        alike = view_difference(keyframe.X_CO, X_CO) <= SEEN_ALIKE
        wrong = _looks(keyframe, X_CO, sight)[1] if alike and not keyframe.lasting else ()
        left = keyframe.without(wrong) if len(wrong) else keyframe
        if left is keyframe or len(left) >= FEWEST:
            kept.append(left)
    return tuple(kept)


def uncovered(new: Keyframe, keyframes: tuple[Keyframe, ...], X_CO: np.ndarray, sight: Sight) -> Keyframe | None:
    """A keyframe just learnt at X_CO without the patches beside which those of older ones look wrong; None if few are left."""
    near = [keyframe for keyframe in keyframes if view_difference(keyframe.X_CO, X_CO) <= COMPARABLE]
    if not near:
        return new
    looks = [(keyframe.p_O, *_looks(keyframe, X_CO, sight)) for keyframe in near]

    def around(p_O):  # how many of the points lie beside each new patch in the image
        new_px, px = (sight.lens.project(p @ X_CO[:3, :3].T + X_CO[:3, 3]) for p in (new.p_O, p_O))
        return np.exp((-0.5 / NEARBY**2) * ((new_px[:, None] - px[None]) ** 2).sum(2)).sum(1)

    right, wrong = (around(np.concatenate([look[0][look[k]] for look in looks])) for k in (1, 2))
    new = new.without(np.flatnonzero(wrong > right + SILENT))
    return new if len(new) >= FEWEST else None


def _looks(keyframe, X_CO, sight):
    return looks_right(keyframe, sight.pyramid, sight.model, X_CO, sight.lens, sight.occluders_C)
