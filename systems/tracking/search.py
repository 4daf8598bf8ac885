"""One attempt at finding the object in an image from a start pose: texture or normal flow, gradients, and the edges at the end."""

from dataclasses import replace

import numpy as np

from vipr.systems.tracking.diagnosis import weigh
from vipr.systems.tracking.displacements import corner_shift
from vipr.systems.tracking.edge_pass import FOLLOWED, about, edge_pass, find_far
from vipr.systems.tracking.keyframes import Keyframe, choose_keyframe, view_difference
from vipr.systems.tracking.sight import Attempt, Sight
from vipr.systems.tracking.small_algebra import invert
from vipr.systems.tracking.texture import align


def attempt(
    sight: Sight,
    X_CO: np.ndarray,
    keyframe: Keyframe | None,
    depth: int,
    far: bool = False,
    near: bool = False,
) -> Attempt:
    """Search from X_CO.

    depth: coarsest pyramid level for the texture; far: the longest reach; near: X_CO is already at the edges. The prediction, with its
    covariance, decides what neither texture nor edges show.
    """
    texture, prior, led_by = None, None, None
    information = sight.information
    if keyframe is not None and sight.settings.texture:
        texture = _align(sight, X_CO, keyframe, depth, information)
        if texture.significance > FOLLOWED:
            X_CO = texture.X_CO
            own = invert(texture.information + 1e-6 * np.diag(texture.information.diagonal() + 1e-9))
            prior, led_by = invert(own + keyframe.covariance), keyframe
            if sight.goes_steadily(X_CO):
                sight.expect(sight.steady)
                information = sight.information
    if prior is None and not near:
        X_CO = find_far(sight, X_CO, sight.settings.reach * (2.0 if far else 1.0))
    # What is wrong with an edge in one frame is wrong in the next: the keyframe's pose has counted it already.
    X_aim, doubt = X_CO, 1.0 if prior is None else 4.0
    sharp = prior is not None
    for _ in range(3):
        X_before = X_CO
        alone = None if prior is None else about(sight, X_CO, X_CO, None)
        X_CO, fit, matches, shown = edge_pass(
            sight,
            X_CO,
            sight.settings.fine_reach,
            (1.3,) if sharp else (2.0, 1.3),
            about(sight, X_CO, X_aim, prior),
            doubt,
            texture,
            sharp,
            alone,
        )
        near = corner_shift(sight.model, sight.lens, X_before, X_CO) < 1.5
        if near and (sharp or not sight.settings.sharp):
            break  # the profiles were sampled where they should be
        sharp = (near or prior is not None) and sight.settings.sharp
    if prior is None and sight.settings.texture:
        keyframe, texture = _recognise(sight, X_CO, information)
    evidence = weigh(matches, fit, texture, keyframe, shown)
    if sight.keyframes and texture is None:  # an unknown side of it: believed only if it has just turned there
        evidence = replace(evidence, unproven=sight.doubtful > 0 or view_difference(sight.X_CO_last, X_CO) > 0.25)
    covariance = invert(fit.information - information + 1e-3 * information)
    pulls = fit.shared
    if prior is not None:
        pulls = pulls + prior @ (led_by.covariance + led_by.shared) @ prior
    return Attempt(X_CO, covariance, evidence, covariance @ pulls @ covariance, sight.ahead, led_by)


def _recognise(sight, X_CO, information):
    """(Keyframe, its TextureFit) where the edges have led: does it look as it should? (None, None) where it was never seen like this."""
    keyframe = choose_keyframe(sight.keyframes, X_CO, limit=0.45)
    if keyframe is None:
        return None, None
    fit = align(keyframe, sight.pyramid, sight.model, X_CO, sight.lens, (1, 0), 3, information, sight.occluders_C)
    if corner_shift(sight.model, sight.lens, fit.X_CO, X_CO) > 3.0:
        fit = replace(fit, agreement=0.0)  # it looks so somewhere else
    return keyframe, fit


def _align(sight, X_CO, keyframe, depth, information):
    """Texture alignment: from the level below the coarsest, where less of the surroundings is mixed in, then, if it helps, from it."""
    best = None
    for start in (1, depth) if depth > 1 else (depth,):
        levels = tuple(range(start, -1, -1))
        fit = align(keyframe, sight.pyramid, sight.model, X_CO, sight.lens, levels, 4, information, sight.occluders_C)
        if best is None or fit.agreement * fit.patches > best.agreement * best.patches:
            best = fit
        if best.significance > FOLLOWED and (best.agreement > 0.7 or best.correlation > 0.9):
            break  # found; what does not look right is covered
    return best
