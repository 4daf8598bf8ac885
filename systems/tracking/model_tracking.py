"""The model-based tracker of the paper (III-B, Fig. 6) as a pure function, ``step``.

One step: predict the motion; align the texture learnt so far, or, without it, fit an affine motion to the normal flow and search the pose
on the gradients; finish by Gauss-Newton on the edges; weigh the evidence; if it is thin, try again from other starts; learn.
Frames: O object, C camera (x right, y down, z forward); displacements d = (w, v) as in ``displacements``.
"""

import math
from dataclasses import replace

import numpy as np

from vipr.systems.camera.lens import Lens
from vipr.systems.errors import InputError
from vipr.systems.tracking.acquire import acquire, elsewhere, look_around, remembered
from vipr.systems.tracking.belief import Belief
from vipr.systems.tracking.cad_model import CadModel
from vipr.systems.tracking.coasting import beyond_doubt, coast, coasted
from vipr.systems.tracking.covered import given_up, uncovered
from vipr.systems.tracking.diagnosis import LOST, TRACKING, Evidence
from vipr.systems.tracking.displacements import corner_shift, corner_spread, move
from vipr.systems.tracking.keyframes import Keyframe, choose_keyframe
from vipr.systems.tracking.learning import learn_keyframe
from vipr.systems.tracking.motion_filter import Motion, at_rest, correct, predict, settle, surprise
from vipr.systems.tracking.overrule import doubt, outdone, overrule, preferred
from vipr.systems.tracking.search import attempt
from vipr.systems.tracking.settings import TrackerSettings
from vipr.systems.tracking.sight import Attempt, Sight
from vipr.systems.tracking.texture import correlation_at

DOUBT_EVERY = 3  # frames between searches for edges that fit better than where the texture leads
# Of the closeness of late: below, rivals are tried; below that where texture led; below that all of them at once.
SLACK, SLACK_LED, COLLAPSED = 0.85, 0.75, 0.5
LASTING = 0.1  # s without a pose beyond doubt
# Share of the closeness of late that is left a frame later, of an object that moves steadily and of one that is shaken.
FADING, FADING_SHAKEN = 0.99, 0.97
LEARN_EVERY = 5  # frames between attempts to learn the texture of an object that has shown none yet
LEARNT = 12  # keyframes, beside those that are known beforehand: the last so many are kept
LESS_STEADY = 0.15  # of the edges that support it: so many fewer may those have that the motion leads to
RECALL_EVERY = 2  # frames between searches of the whole image for an object that was lost
LOOK_EVERY = 5  # frames between searches around the last good pose of an object that was lost


def step(
    belief: Belief,
    image: np.ndarray,
    time: float,
    model: CadModel,
    lens: Lens,
    settings: TrackerSettings = TrackerSettings(),
    occluders_C: np.ndarray | None = None,
    number: int | None = None,
) -> Belief:
    """The belief after one image (h, w) or (h, w, 3) BGR uint8 taken at time [s]; an empty image only predicts.

    occluders_C (S, 3, 3): triangles in C [m] of known bodies that may stand in front. Raises InputError for an image of another size than
    the lens's.
    """
    number = belief.number + 1 if number is None else number
    if image.size and image.shape[:2] != (lens.height, lens.width):
        raise InputError(
            f"tracker: the image is {image.shape[1]} x {image.shape[0]} px, its lens is for {lens.width} x {lens.height} px"
        )
    fresh = belief.X_CO_given is not None
    dt = 0.0 if fresh else min(max(time - belief.time, 0.0), 1.0)
    ahead = predict(belief.motion, dt, settings.spin_noise, settings.speed_noise)
    if not settings.prediction:
        ahead = replace(ahead, X_CO=belief.X_CO)
    if not image.size:
        state = "uncertain" if belief.state == "tracking" else belief.state
        return replace(belief, motion=ahead, state=state, time=time, number=number, nodes=0, residual_px=float("nan"))
    steady = predict(belief.motion, dt, belief.agility * settings.spin_noise, belief.agility * settings.speed_noise)
    steady = steady if settings.prediction else ahead
    sight = Sight(image, model, lens, settings, occluders_C, belief, ahead, dt, steady)
    best = _search(belief, ahead, sight)
    if settings.rivals and not fresh:
        best = _best_of_rivals(belief, ahead, best, sight, time, number)
    return _conclude(belief, ahead, best, sight, time, number)


def _search(belief: Belief, ahead: Motion, sight: Sight) -> Attempt:
    """The best attempt at this frame; more starts and longer searches only while the evidence is thin."""
    spread = corner_spread(sight.model, sight.lens, ahead.X_CO, ahead.covariance[:6, :6])
    sight.open([ahead.X_CO, belief.X_CO], margin=sight.settings.reach + 3.0 * min(spread, 20.0))
    X_start = ahead.X_CO
    keyframe = choose_keyframe(belief.keyframes, ahead.X_CO)
    apart = corner_shift(sight.model, sight.lens, ahead.X_CO, belief.X_CO)
    if keyframe is not None and apart > 3.0:  # is the object where it was heading, or where it was?
        options = [ahead.X_CO, belief.X_CO]
        likeness = [
            correlation_at(keyframe, sight.pyramid, sight.model, X, sight.lens, 2, sight.occluders_C) for X in options
        ]
        X_start = options[int(np.argmax(likeness))]
    depth = 1 if max(spread, apart) < 2.0 else 2
    if belief.X_CO_given is not None:
        return acquire(sight, elsewhere(belief.X_CO_given, belief.doubtful))
    other = None
    if keyframe is None and belief.agility < 1.0:
        other = _where_it_goes(sight, ahead, depth)
        if other.evidence.edges > 1.0 - LESS_STEADY:
            sight.expect(sight.steady)
            return other  # whatever else may be found
    best = attempt(sight, X_start, keyframe, depth)
    now_and_then = belief.number % DOUBT_EVERY == 0
    if best.led_by is None and belief.agility < 1.0:
        # By edges alone, edges nearer to where the motion leads count for more.
        other = other or _where_it_goes(sight, ahead, depth)
        if other.evidence.edges > best.evidence.edges - (LESS_STEADY if sight.goes_steadily(best.X_CO) else 0.3):
            sight.expect(sight.steady)
            return other
    elif best.led_by is not None and (
        doubt(best.evidence) > (0.0 if now_and_then else 1.0) or best.evidence.closeness < SLACK_LED * belief.closeness
    ):
        other = overrule(sight, best, ahead, belief.closeness, widely=now_and_then)
        if other is not None:
            return other
    if best.evidence.score > 0.7 or not sight.settings.second_try:
        return best
    starts = [ahead.X_CO, belief.X_CO] if apart > 1.0 else [ahead.X_CO]
    if belief.X_CO_good is not None and belief.doubtful > 0:
        starts.append(belief.X_CO_good)
    sight.open(starts, margin=3.0 * sight.settings.reach)
    ways = [{"keyframe": keyframe, "far": True}, {"keyframe": None, "far": True}][keyframe is None :]
    sight.expect(ahead)
    for X, way in [(ahead.X_CO, {"keyframe": None, "near": True}), *((X, way) for X in starts for way in ways)]:
        other = attempt(sight, X, depth=3, **way)
        if preferred(other, best):
            best = other
        if best.evidence.score > 0.8:
            break
    if best.evidence.score < TRACKING and belief.doubtful % RECALL_EVERY == 1 and sight.settings.recall:
        best = max([best, *remembered(sight, ahead)], key=lambda one: one.evidence.score)
    if best.evidence.score < TRACKING and belief.doubtful % LOOK_EVERY == 2 and sight.settings.start_search:
        around = belief.X_CO_good if belief.X_CO_good is not None else belief.X_CO
        sight.expect(replace(ahead, X_CO=around, covariance=at_rest(around).covariance))
        best = max([best, *look_around(sight, around)], key=lambda one: one.evidence.score)
    return best


def _where_it_goes(sight: Sight, ahead: Motion, depth: int) -> Attempt:
    """The attempt at the edges nearest to where the steady motion leads."""
    sight.expect(sight.steady)
    found = attempt(sight, sight.steady.X_CO, None, depth, near=True)
    sight.expect(ahead)
    return found


def _best_of_rivals(belief: Belief, ahead: Motion, best: Attempt, sight: Sight, time: float, number: int) -> Attempt:
    """The attempt, or a rival of it whose edges fit more closely, or are as likely to be the object's after its motion so far."""
    share, led = best.evidence.closeness / belief.closeness, best.led_by is not None
    coasting = coast(belief, time, sight.settings)
    if share < (SLACK_LED if led else SLACK):
        widely = best.evidence.score >= TRACKING and (not led or number % DOUBT_EVERY == 0 or share < COLLAPSED)
        lasting = coasting is not None and time - belief.sure.time > LASTING
        best = outdone(sight, best, ahead, belief.closeness, widely, lasting) or best
    return best if coasting is None else coasted(sight, best, coasting) or best


def _conclude(belief: Belief, ahead: Motion, best: Attempt, sight: Sight, time: float, number: int) -> Belief:
    score = best.evidence.score
    good = score >= TRACKING
    state = "tracking" if good else "lost" if score < LOST or belief.doubtful >= 4 else "uncertain"
    keyframes = belief.keyframes
    steady = best.led_by is not None or sight.goes_steadily(best.X_CO) or belief.X_CO_given is not None
    if good or (score > LOST and steady):
        update = correct if belief.X_CO_given is not None else settle
        motion = update(best.ahead or ahead, best.X_CO, best.covariance)
    else:  # not seen: it may have slowed down or stopped
        motion = replace(ahead, V_CO=0.7 * ahead.V_CO)
    if best.prune and sight.settings.covered:
        keyframes = given_up(keyframes, motion.X_CO, sight)
    keyframes = tuple(k for k in keyframes if k.lasting or not any(k is wrong for wrong in best.against))
    if best.led_by is not None:
        keyframes = _doubt(keyframes, best)
    if (
        score > 0.8
        and sight.settings.texture
        and (keyframes or belief.X_CO_given is not None or number % LEARN_EVERY == 0)
    ):
        keyframes = _learn(keyframes, motion, best.shared, sight, best.evidence, belief.closeness)
    return Belief(
        motion=motion,
        state=state,
        score=score,
        nodes=best.evidence.nodes,
        residual_px=best.evidence.sigma,
        time=time,
        number=number,
        keyframes=keyframes,
        X_CO_given=belief.X_CO_given if belief.X_CO_given is not None and not good and score < LOST else None,
        X_CO_good=motion.X_CO if good else belief.X_CO_good,
        doubtful=0 if good else belief.doubtful + 1,
        started=True,
        agility=_agility(belief, ahead, motion) if good else 1.0,
        shared=best.shared,
        closeness=_closeness_of_late(belief, best.evidence.closeness) if good else _faded(belief),
        sure=beyond_doubt(belief, motion, best, sight, time) if good else belief.sure,
    )


def _closeness_of_late(belief: Belief, closeness: float) -> float:
    """How closely edges should fit in the next frame; the first fit counts for half, as models differ in how well they are known."""
    late = _faded(belief) if belief.X_CO_given is None else math.sqrt(belief.closeness * closeness)
    return max(late, closeness)


def _faded(belief: Belief) -> float:
    """The closeness of late, a frame later: blur and light change faster for an object that is shaken."""
    return (FADING + (FADING_SHAKEN - FADING) * belief.agility) * belief.closeness


def _agility(belief: Belief, ahead: Motion, motion: Motion) -> float:
    """How far the object has lately left its predictions, as a share of the accelerations that the settings expect."""
    off = np.sqrt(surprise(ahead.X_CO, ahead.covariance, motion.X_CO) / 6.0)
    grown = min(1.5 * off, 1.5 * belief.agility + 0.1)
    return min(max(0.85 * belief.agility, grown, 0.08), 1.0)


def _doubt(keyframes: tuple[Keyframe, ...], best: Attempt) -> tuple[Keyframe, ...]:
    """Less confidence in the pose of a keyframe that led where the edges do not fit: they may put it right."""
    if best.led_by.lasting or (best.evidence.sigma < 1.0 and best.evidence.edges > 0.4):
        return keyframes
    weaker = replace(best.led_by, covariance=1.5 * best.led_by.covariance, trust=0.93 * best.led_by.trust)
    kept = tuple(weaker if k is best.led_by else k for k in keyframes)
    return tuple(k for k in kept if k.trust > 0.4 or k.lasting or k is kept[0])


def _learn(
    keyframes: tuple[Keyframe, ...],
    motion: Motion,
    shared: np.ndarray,
    sight: Sight,
    evidence: Evidence,
    late: float,
) -> tuple[Keyframe, ...]:
    """Keyframes with one more where the object is seen from a new side, sharply, and its edges confirm the pose."""
    if choose_keyframe(keyframes, motion.X_CO, limit=0.2) is not None:
        return keyframes
    if keyframes:
        speed = corner_shift(sight.model, sight.lens, motion.X_CO, move(motion.X_CO, motion.V_CO * sight.dt))
        served = choose_keyframe(keyframes, motion.X_CO, limit=0.45) is not None
        sound = evidence.edges > 0.6 and evidence.sigma < 1.0 and speed < 5.0
        if not sound and (served or evidence.edges < 0.4 or evidence.closeness < SLACK * late):
            return keyframes  # wait while an older one still serves
    new = learn_keyframe(
        sight.pyramid,
        sight.model,
        motion.X_CO,
        motion.covariance[:6, :6],
        sight.lens,
        sight.settings.patches,
        sight.occluders_C,
        evidence.by_edges if keyframes else evidence.score,
        evidence.sigma,
    )
    if new is not None and keyframes and sight.settings.covered:
        new = uncovered(new, keyframes, motion.X_CO, sight)
    if new is None:
        return keyframes
    new = replace(new, shared=shared)
    lasting, learnt = ([k for k in keyframes if k.lasting is kind] for kind in (True, False))
    return (*lasting, *learnt[1 - LEARNT :], new)
