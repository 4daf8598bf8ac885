"""Finding an object whose place is known roughly: a pose given from outside, or the last good one of an object that was lost."""

from dataclasses import replace

import numpy as np

from vipr.systems import se3
from vipr.systems.tracking.diagnosis import weigh
from vipr.systems.tracking.displacements import corner_information, difference
from vipr.systems.tracking.edge_pass import about, edge_pass
from vipr.systems.tracking.keyframes import choose_keyframe
from vipr.systems.tracking.motion_filter import Motion, at_rest
from vipr.systems.tracking.pose_fit import Prior
from vipr.systems.tracking.recall import recall
from vipr.systems.tracking.rivals import closest, nudged
from vipr.systems.tracking.search import attempt
from vipr.systems.tracking.sight import Attempt, Sight
from vipr.systems.tracking.small_algebra import invert
from vipr.systems.tracking.start_search import field_around, pose_cost, search_start

# Share of the distance, degrees about the camera's x and y.
ELSEWHERE = (
    (0, 0, 0),
    (0.01, 0, 0),
    (-0.01, 0, 0),
    (0, 5, 0),
    (0, -5, 0),
    (0, 0, 5),
    (0, 0, -5),
    (0.02, 0, 0),
    (-0.02, 0, 0),
)
GIVEN_IS_GOOD = 0.6  # score at which a pose given from outside is believed at once


def acquire(sight: Sight, X_CO_given: np.ndarray) -> Attempt:
    """The first frame after a pose was given from outside.

    If the edges are where the pose says, it is taken. Otherwise its error may be tens of pixels: many starts about it, and the best by a
    margin; then rivals of that one. The pose given counts as a measurement of its own, the less the further the image is from it.
    """
    sight.open([X_CO_given], margin=3.0 * sight.settings.reach)
    best = attempt(sight, X_CO_given, None, 0, near=True)
    agreement = _agreement(sight, best.X_CO, X_CO_given)[2]
    believed = best.evidence.score > GIVEN_IS_GOOD and (agreement > 0.5 or best.evidence.edges > 0.8)
    if not believed and sight.settings.start_search:
        best = _acquire_far(sight, X_CO_given, best, agreement)
    X = nudged(sight, closest(sight, best.X_CO)) if sight.settings.rivals else best.X_CO
    off, aim, agreement = _agreement(sight, X, X_CO_given)
    prior = Prior(off, agreement * aim)
    alone = about(sight, X, X, None)
    X, fit, matches, _ = edge_pass(sight, X, sight.settings.fine_reach, (1.3,), prior, 6.0, sharp=True, alone=alone)
    evidence = replace(weigh(matches, fit), given=agreement)
    covariance = invert(fit.information + 1e-3 * sight.information)
    return Attempt(X, covariance, evidence, covariance @ fit.shared @ covariance)


def elsewhere(X_CO: np.ndarray, tries: int) -> np.ndarray:
    """Where to begin after so many tries in vain from a pose that was given: there, nearer, farther, tilted; then again."""
    further, w_x, w_y = ELSEWHERE[tries % len(ELSEWHERE)]
    return se3.pose(se3.exp_so3(np.deg2rad([w_x, w_y, 0.0])) @ X_CO[:3, :3], (1.0 + further) * X_CO[:3, 3])


def _agreement(sight, X_CO, X_CO_given):
    """Displacement to the pose given, its information, and how well they agree: 1 to 0, Geman-McClure, half at some 3 px."""
    aim = corner_information(sight.model, X_CO, sight.lens, sight.settings.initial_px)
    off = difference(X_CO, X_CO_given)
    return off, aim, 1.0 / (1.0 + float(off @ aim @ off) / 150.0) ** 2


def _acquire_far(sight, X_CO_given, near, agreement):
    """The best of the attempts from the places that a search over tens of pixels finds, and of the near one, by chamfer cost."""
    model, lens, hidden_by = sight.model, sight.lens, sight.occluders_C
    field = field_around(sight.image, model, lens, X_CO_given)
    if field is None:
        return near
    poses = search_start(field, model, lens, X_CO_given, occluders_C=hidden_by)
    sight.open([X_CO_given, *poses], margin=3.0 * sight.settings.reach)
    tries = [near, *(attempt(sight, X, None, 0, near=True) for X in poses)]
    costs = [pose_cost(field, model, lens, one.X_CO, hidden_by) for one in tries]
    costs[0] -= 0.25 * agreement  # px: what is given and found again needs less proof
    return tries[int(np.argmin(costs))]


def look_around(sight: Sight, X_CO: np.ndarray) -> list[Attempt]:
    """Attempts from the places about X_CO, tens of pixels around, whose edges look most like the object's: for one that was lost."""
    field = field_around(sight.image, sight.model, sight.lens, X_CO)
    if field is None:
        return []
    poses = search_start(field, sight.model, sight.lens, X_CO, occluders_C=sight.occluders_C)
    sight.open([X_CO, *poses], margin=3.0 * sight.settings.reach)
    keyframes = [choose_keyframe(sight.keyframes, X) for X in poses]
    return [attempt(sight, X, k, 2, near=True) for X, k in zip(poses, keyframes, strict=True)]


def remembered(sight: Sight, ahead: Motion) -> list[Attempt]:
    """Attempts from wherever in the image the object looks as it was learnt."""
    found = []
    for X in recall(sight.keyframes, sight.image, sight.model, sight.lens):
        sight.open([X], margin=3.0 * sight.settings.reach)
        sight.expect(replace(ahead, X_CO=X, covariance=at_rest(X).covariance))
        found.append(attempt(sight, X, choose_keyframe(sight.keyframes, X), 2, near=True))
    return found
