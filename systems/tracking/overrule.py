"""When the edges overrule a texture that leads where they do not fit."""

from dataclasses import replace

import numpy as np

from vipr.systems.tracking.diagnosis import Evidence, weigh
from vipr.systems.tracking.displacements import corner_information, corner_shift, move
from vipr.systems.tracking.edge_pass import about, edge_pass
from vipr.systems.tracking.motion_filter import Motion, at_rest
from vipr.systems.tracking.pose_fit import Fit
from vipr.systems.tracking.rivals import closest, settle_on
from vipr.systems.tracking.search import attempt
from vipr.systems.tracking.sight import Attempt, Sight
from vipr.systems.tracking.small_algebra import invert

CLOSE_PX = 0.3  # residual of edges that fit closely
WELL_PX, WELL_SHARE = 0.5, 0.7  # residual and share of edges of a pose that is not questioned
OVERRULE_PX = (4.0, 8.0)  # RMS of the corners: how far from a doubtful pose others are tried
CERTAIN = 10.0  # significance of a texture that is hardly mistaken
MUCH_CLOSER = 0.25  # of closeness: what the motion so far does not lead to must fit so much more closely
AS_EXPECTED = 12.6  # squared Mahalanobis distance of six parameters that 95 % of motions stay below
TIGHT = 0.65  # closeness of edges from which a rival found anywhere is taken
AS_OF_LATE = 0.75  # share of the closeness of late from which edges fit as they should
ELSEWHERE_PX = 1.0  # RMS of the corners: nearer, a rival is the same pose
CLOSER, BETTER = 0.1, 0.15  # of a fit's quality: edges that fit so much better, closely or not, overrule a texture


def doubt(evidence: Evidence) -> float:
    """How little the edges fit where texture has led: 0 leaves nothing to be asked, above 1 is as if they were somewhere else."""
    return max(evidence.sigma / WELL_PX, (1.0 - evidence.edges) / (1.0 - WELL_SHARE)) - 1.0


def overrule(sight: Sight, best: Attempt, ahead: Motion, late: float, widely: bool) -> Attempt | None:
    """What the edges say alone where texture led to a pose that they do not fit: blurred, it leads astray; or it is a hand's, or was
    learnt at a wrong pose, with lines of print taken for edges. None unless the edges fit much better elsewhere: where the motion leads,
    or, if asked to look widely, along the directions that the image shows least of.
    """
    sight.expect(sight.steady)
    other = _if_better(attempt(sight, sight.steady.X_CO, None, 1, near=True), best, sight, late)
    if other is not None or not widely:
        sight.expect(ahead)
        return other
    shape = corner_information(sight.model, best.X_CO, sight.lens, 1.0)
    L = np.linalg.cholesky(shape + 1e-9 * np.diag(shape.diagonal()))
    _, directions = np.linalg.eigh(L.T @ best.covariance @ L)  # in units of pixels of the corners
    weakest = np.linalg.solve(L.T, directions[:, -2:]) * np.sqrt(len(sight.model.corners))
    for step in OVERRULE_PX:
        for way in (*weakest.T, *-weakest.T):
            X = move(best.X_CO, step * way)
            sight.expect(replace(ahead, X_CO=X, covariance=at_rest(X).covariance))
            X, fit, matches, _ = edge_pass(sight, X, sight.settings.fine_reach, (3.0, 1.3), about(sight, X, X, None))
            if weigh(matches, fit).quality > best.evidence.quality + CLOSER:
                other = _if_better(attempt(sight, X, None, 0, near=True), best, sight, late)
                if other is not None:
                    sight.expect(ahead)
                    return other
    sight.expect(ahead)
    return None


def outdone(
    sight: Sight, best: Attempt, ahead: Motion, late: float, widely: bool, lasting: bool = False
) -> Attempt | None:
    """A rival of a pose whose edges fit much more closely than its own: where the motion leads, where its own edges lead if nothing else
    pulls, or, if asked to look widely, anywhere near. late: how closely its edges have fitted of late.

    What is found anywhere near must fit more closely still: seen end on, few edges fit well in many places. It is not even looked for where
    edges fit as of late already, unless doubt is lasting.
    """
    sight.expect(replace(ahead, X_CO=best.X_CO, covariance=at_rest(best.X_CO).covariance))
    expected, information = sight.ahead, sight.information
    found, least = None, best.evidence.closeness
    ways = (lambda: sight.steady.X_CO, lambda: best.X_CO, lambda: closest(sight, best.X_CO))
    for n, rival in enumerate(ways[: 2 + widely]):
        if n == 2 and not lasting and least > AS_OF_LATE * late:
            break  # where the motion leads, edges fit as they should
        X, fit, matches = settle_on(sight, rival())
        evidence = weigh(matches, fit)
        elsewhere = corner_shift(sight.model, sight.lens, X, best.X_CO) > ELSEWHERE_PX
        near = n < 2 or sight.goes_steadily(X, AS_EXPECTED)
        gain = CLOSER if near and elsewhere else MUCH_CLOSER
        enough = min(TIGHT, AS_OF_LATE * late) if near else TIGHT
        if (elsewhere or n < 2) and evidence.closeness >= max(best.evidence.closeness + gain, enough):
            found = rival_attempt(X, fit, evidence, expected, information, prune=elsewhere)
            break
        least = max(least, evidence.closeness)
    sight.expect(ahead)
    return found


def rival_attempt(
    X_CO: np.ndarray, fit: Fit, evidence: Evidence, expected: Motion, information: np.ndarray, prune: bool
) -> Attempt:
    """An attempt of a pose that edges alone have settled on, weighed against a motion expected with this information (6, 6) of its pose."""
    covariance = invert(fit.information - 0.999 * information)
    return Attempt(X_CO, covariance, evidence, covariance @ fit.shared @ covariance, expected, prune=prune)


def _if_better(other, best, sight, late):
    """The other attempt if its edges fit so much better that the texture must be wrong; its keyframe is named if it is beyond doubt.

    Motion blur has two edges, and one side of it may fit better than its middle: only a close fit overrules a keyframe that
    was learnt where the edges did fit.
    """
    gain = other.evidence.quality - best.evidence.quality
    close, many = other.evidence.sigma < CLOSE_PX, other.evidence.edges > WELL_SHARE
    few_agree = best.evidence.texture < CERTAIN
    unsure = best.led_by.fit_px > WELL_PX
    closeness = other.evidence.closeness
    elsewhere = corner_shift(sight.model, sight.lens, other.X_CO, best.X_CO) > ELSEWHERE_PX
    if elsewhere and closeness > max(best.evidence.closeness + CLOSER, AS_OF_LATE * late):
        return replace(other, prune=True)
    if not ((close and gain > CLOSER) or (many and (unsure or few_agree) and gain > BETTER)):
        return None
    wrong = (best.led_by,) if many else ()
    evidence = replace(other.evidence, texture=0.0, patches=0) if many else other.evidence
    return replace(other, evidence=evidence, against=wrong)


def preferred(other: Attempt, best: Attempt) -> bool:
    """Whether another attempt at the same image is to be believed rather: by its score, but texture does not count against edges that fit
    much better, the less the fewer patches agree.
    """
    gain = other.evidence.quality - best.evidence.quality
    if other.led_by is not None and best.led_by is None and -gain > _needed(other):
        return False
    if best.led_by is not None and other.led_by is None and gain > _needed(best):
        return True
    return other.evidence.score > best.evidence.score


def _needed(led):
    """By how much edges must fit better than those of an attempt that texture led."""
    return BETTER if led.evidence.texture < CERTAIN else 2.0 * BETTER
