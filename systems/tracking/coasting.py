"""Coasting: what an object does that has moved on as it did when it was last seen beyond doubt.

Frames: O object, C camera.
"""

import numpy as np

from vipr.systems.tracking.belief import Belief, Sure
from vipr.systems.tracking.diagnosis import weigh
from vipr.systems.tracking.displacements import corner_shift, corner_spread
from vipr.systems.tracking.motion_filter import Motion, predict, surprise
from vipr.systems.tracking.overrule import AS_EXPECTED, CLOSER, ELSEWHERE_PX, rival_attempt
from vipr.systems.tracking.rivals import UNEXPECTED, settle_on
from vipr.systems.tracking.search import attempt
from vipr.systems.tracking.settings import TrackerSettings
from vipr.systems.tracking.sight import Attempt, Sight

COASTING = 0.4  # s, how long an object may be thought to have moved on as it did
STEADY = 0.5  # agility up to which its motion may be thought to go on
SURE_PX = 0.5  # RMS of the corners: how well a pose beyond doubt is known
SURE_OF_LATE = 0.9  # share of the closeness of late at which edges fit beyond doubt


def beyond_doubt(belief: Belief, motion: Motion, best: Attempt, sight: Sight, time: float) -> Sure | None:
    """The motion, if this frame leaves nothing in doubt; else when it last was so."""
    told = corner_spread(sight.model, sight.lens, motion.X_CO, best.covariance + best.shared)
    close = best.evidence.closeness > SURE_OF_LATE * belief.closeness
    if belief.agility < STEADY and 0 < told < SURE_PX and close and sight.goes_steadily(best.X_CO, AS_EXPECTED):
        return Sure(motion, time, belief.agility)
    return belief.sure


def coast(belief: Belief, time: float, settings: TrackerSettings) -> Motion | None:
    """Where the object is now if it has moved on since it was last seen beyond doubt; None if that was just now or too long ago."""
    sure = belief.sure
    if sure is None or not settings.prediction or not sure.time < belief.time < sure.time + COASTING:
        return None
    spin, speed = sure.agility * settings.spin_noise, sure.agility * settings.speed_noise
    return predict(sure.motion, time - sure.time, spin, speed)


def coasted(sight: Sight, best: Attempt, coasting: Motion) -> Attempt | None:
    """Where an object would be that has moved on as when it was last seen beyond doubt, if its edges fit there and the best attempt's do
    not fit more closely than they would have to, to be believed in spite of that motion.

    Seen end on, a box shows one face: it may have turned either way, and the wrong one is as good until its sides are seen.
    """
    ahead = sight.ahead
    sight.expect(coasting)
    information, found = sight.information, None
    least = best.evidence.closeness - _unexpected(coasting, best.X_CO) + (0.0 if best.led_by is None else CLOSER)
    for start in (lambda: coasting.X_CO, lambda: attempt(sight, coasting.X_CO, None, 1, near=True).X_CO):
        X, fit, matches = settle_on(sight, start())
        evidence = weigh(matches, fit)
        merit = evidence.closeness - _unexpected(coasting, X)
        if merit >= least and corner_shift(sight.model, sight.lens, X, best.X_CO) > ELSEWHERE_PX:
            found = rival_attempt(X, fit, evidence, coasting, information, prune=True)
            least = merit
    sight.expect(ahead)
    return found


def _unexpected(ahead: Motion, X_CO: np.ndarray) -> float:
    """How much less closely edges fit, as it were, at a pose that is not where the motion leads."""
    return UNEXPECTED * surprise(ahead.X_CO, ahead.covariance, X_CO)
