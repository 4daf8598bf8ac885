"""One attempt at finding the object in an image from a start pose: texture or normal flow, gradients, and the edges at the end."""

from dataclasses import dataclass, replace

import numpy as np

from vipr.systems.camera.lens import Lens
from vipr.systems.compiled import compiled
from vipr.systems.tracking.affine import fit_affine, move_points
from vipr.systems.tracking.cad_model import CadModel
from vipr.systems.tracking.diagnosis import Evidence, weigh
from vipr.systems.tracking.displacements import corner_information, corner_shift, difference, move, normal_jacobian
from vipr.systems.tracking.gradient_fit import fit_gradients, search_steps
from vipr.systems.tracking.keyframes import Keyframe, choose_keyframe, pyramid, view_difference
from vipr.systems.tracking.motion_filter import Motion, at_rest, surprise
from vipr.systems.tracking.normal_flow import cut_patch, find_edges
from vipr.systems.tracking.pose_fit import Prior, fit_points, fit_pose
from vipr.systems.tracking.small_algebra import invert, solve
from vipr.systems.tracking.start_search import field_around, pose_cost, search_start
from vipr.systems.tracking.texture import TextureFit, align
from vipr.systems.tracking.visible_edges import visible_nodes

CLEAR = 12.0  # grey levels; much stronger edges are all alike
GIVEN_IS_GOOD = 0.6  # score at which a pose given from outside is believed at once
NEARBY = 12.0  # px
SHARP_REACH = 3.0  # px
CLOSE_PX = 0.3  # residual of edges that fit closely
WELL_PX, WELL_SHARE = 0.5, 0.7  # residual and share of edges of a pose that is not questioned
OVERRULE_PX = (4.0, 8.0)  # RMS of the corners: how far from a doubtful pose others are tried
CLOSER, BETTER = 0.1, 0.15  # of a fit's quality: edges that fit so much better, closely or not, overrule a texture
FOLLOWED = 4.0  # significance from which a texture alignment is followed


@dataclass(frozen=True, eq=False)
class Attempt:
    """Where the object was found, and what speaks for it."""

    X_CO: np.ndarray
    covariance: np.ndarray  # (6, 6) of what the image says, without the prediction
    evidence: Evidence
    ahead: Motion | None = None  # the prediction that it was weighed against
    led_by: Keyframe | None = None  # whose texture led there
    against: Keyframe | None = None  # whose texture led elsewhere, and was overruled by the edges


class Sight:
    """What one step looks at and with: the image, the model, what is known, and the patch of the image that the search needs."""

    def __init__(
        self,
        image,
        model: CadModel,
        lens: Lens,
        settings,
        occluders_C,
        belief,
        ahead: Motion,
        dt: float,
        steady: Motion,
    ):
        self.image, self.model, self.lens, self.settings, self.occluders_C = image, model, lens, settings, occluders_C
        self.keyframes, self.doubtful = belief.keyframes, belief.doubtful
        self.X_CO_last, self.V_CO, self.dt = belief.X_CO, belief.V_CO, dt
        self.steady = steady
        self.expect(ahead)
        self.patch, self._pyramid = None, None

    def expect(self, ahead: Motion) -> None:
        """Take this prediction as the prior of the fits."""
        self.ahead = ahead
        self.X_CO_ahead, self.information = ahead.X_CO, invert(np.ascontiguousarray(ahead.covariance[:6, :6]))

    def goes_steadily(self, X_CO: np.ndarray, limit: float = 25.0) -> bool:
        """Whether a pose is what the motion so far leads to (squared Mahalanobis distance of six parameters below the limit)."""
        return surprise(self.steady.X_CO, self.steady.covariance, X_CO) < limit

    def open(self, poses: list[np.ndarray], margin: float) -> None:
        """Cut the patch that holds the model at all the poses, and margin [px] around it."""
        corners = np.concatenate([self.model.corners @ X[:3, :3].T + X[:3, 3] for X in poses])
        corners = corners[corners[:, 2] > 1e-3]
        pixel = self.lens.project(corners) if len(corners) else np.full((1, 2), -1e6)
        self.patch = cut_patch(self.image, pixel.min(0) - margin, pixel.max(0) + margin, self.settings.colour)
        self._pyramid = None

    @property
    def pyramid(self):
        if self._pyramid is None:
            self._pyramid = pyramid(self.patch)
        return self._pyramid


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
        X_CO = _find_far(sight, X_CO, sight.settings.reach * (2.0 if far else 1.0))
    # What is wrong with an edge in one frame is wrong in the next: the keyframe's pose has counted it already.
    X_aim, doubt = X_CO, 1.0 if prior is None else 4.0
    sharp = prior is not None
    for _ in range(3):
        X_before = X_CO
        alone = None if prior is None else _about(sight, X_CO, X_CO, None)
        X_CO, fit, matches, shown = edge_pass(
            sight,
            X_CO,
            sight.settings.fine_reach,
            (1.3,) if sharp else (2.0, 1.3),
            _about(sight, X_CO, X_aim, prior),
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
    return Attempt(X_CO, covariance, evidence, sight.ahead, led_by)


def doubt(evidence: Evidence) -> float:
    """How little the edges fit where texture has led: 0 leaves nothing to be asked, above 1 is as if they were somewhere else."""
    return max(evidence.sigma / WELL_PX, (1.0 - evidence.edges) / (1.0 - WELL_SHARE)) - 1.0


def overrule(sight: Sight, best: Attempt, ahead: Motion, widely: bool) -> Attempt | None:
    """What the edges say alone where texture led to a pose that they do not fit: blurred, it leads astray; or it is a hand's, or was
    learnt at a wrong pose, with lines of print taken for edges. None unless the edges fit much better elsewhere: where the motion leads,
    or, if asked to look widely, along the directions that the image shows least of.
    """
    sight.expect(sight.steady)
    other = _if_better(attempt(sight, sight.steady.X_CO, None, 1, near=True), best)
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
            X, fit, matches, _ = edge_pass(sight, X, sight.settings.fine_reach, (3.0, 1.3), _about(sight, X, X, None))
            if weigh(matches, fit).quality > best.evidence.quality + CLOSER:
                other = _if_better(attempt(sight, X, None, 0, near=True), best)
                if other is not None:
                    sight.expect(ahead)
                    return other
    sight.expect(ahead)
    return None


def _if_better(other, best):
    """The other attempt if its edges fit so much better that the texture must be wrong; its keyframe is named if it is beyond doubt.

    Motion blur has two edges, and one side of it may fit better than its middle: only a close fit overrules a keyframe that
    was learnt where the edges did fit.
    """
    gain = other.evidence.quality - best.evidence.quality
    close, many = other.evidence.sigma < CLOSE_PX, other.evidence.edges > WELL_SHARE
    if not ((close and gain > CLOSER) or (many and gain > BETTER and best.led_by.fit_px > WELL_PX)):
        return None
    wrong = best.led_by if many else None
    evidence = replace(other.evidence, texture=0.0, patches=0) if many else other.evidence
    return replace(other, evidence=evidence, against=wrong)


def _recognise(sight, X_CO, information):
    """(Keyframe, its TextureFit) where the edges have led: does it look as it should? (None, None) where it was never seen like this."""
    keyframe = choose_keyframe(sight.keyframes, X_CO, limit=0.45)
    if keyframe is None:
        return None, None
    fit = align(keyframe, sight.pyramid, sight.model, X_CO, sight.lens, (1, 0), 3, information, sight.occluders_C)
    if corner_shift(sight.model, sight.lens, fit.X_CO, X_CO) > 3.0:
        fit = replace(fit, agreement=0.0)  # it looks so somewhere else
    return keyframe, fit


def acquire(sight: Sight, X_CO_given: np.ndarray) -> Attempt:
    """The first frame after a pose was given from outside.

    If the edges are where the pose says, it is taken. Otherwise its error may be tens of pixels: many starts about it, and the best by a
    margin. The pose given counts as a measurement of its own, the less the further the image is from it.
    """
    sight.open([X_CO_given], margin=3.0 * sight.settings.reach)
    best = attempt(sight, X_CO_given, None, 0, near=True)
    off, aim, agreement = _agreement(sight, best.X_CO, X_CO_given)
    believed = best.evidence.score > GIVEN_IS_GOOD and (agreement > 0.5 or best.evidence.edges > 0.8)
    if not believed and sight.settings.start_search:
        best = _acquire_far(sight, X_CO_given, best, agreement)
        off, aim, agreement = _agreement(sight, best.X_CO, X_CO_given)
    X, fit, matches, _ = edge_pass(
        sight, best.X_CO, sight.settings.fine_reach, (1.3,), Prior(off, agreement * aim), 2.0, sharp=True
    )
    evidence = replace(weigh(matches, fit), given=agreement)
    return Attempt(X, invert(fit.information + 1e-3 * sight.information), evidence)


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


def _about(sight, X_CO, X_aim, information):
    """Prior of the displacement from X_CO: the prediction, and a pose X_aim of the given information (None: nothing more)."""
    off = difference(X_CO, sight.X_CO_ahead)
    if information is None:
        return Prior(off, sight.information)
    both = sight.information + information
    return Prior(solve(both, sight.information @ off + information @ difference(X_CO, X_aim)), both)


def edge_pass(
    sight: Sight,
    X_CO: np.ndarray,
    reach: float,
    widths: tuple[float, ...],
    prior: Prior | None = None,
    doubt: float = 1.0,
    texture: TextureFit | None = None,
    sharp: bool = False,
    alone: Prior | None = None,
):
    """Nodes, edges within reach [px] and one robust fit: (pose, Fit, Matches, how far the texture shows each node uncovered).

    sharp: near the pose the sharp derivative decides, wherever the edge is clear of the noise, and the nearest edge wins.
    alone: the prior without the texture, where there is one.
    """
    settings = sight.settings
    nodes = visible_nodes(sight.model, X_CO, sight.lens, settings.nodes, settings.spacing, sight.occluders_C)
    matches = _look(sight, nodes, reach, SHARP_REACH if sharp and settings.sharp else 0.0)
    J = normal_jacobian(nodes, X_CO, sight.lens)
    shown = _shown(nodes.pixel, texture)
    likely = preferences(matches.strength, matches.wide)
    common = {"edge": nodes.edge, "model_error": settings.model_error, "node_weight": shown}
    free = None
    if alone is not None:  # how well the edges agree among themselves is not for other cues to spoil
        free = fit_pose(J, matches, likely, widths, alone, anneal=False, **common).spread
    fit = fit_pose(J, matches, likely, widths, prior, doubt=doubt, spread=free, anneal=alone is None, **common)
    return move(X_CO, fit.d), fit, matches, shown


def _shown(pixel, texture):
    """(N,) 0.1 to 1: how far the texture patches near each node say that nothing covers it; 1 where all look right or nothing is known."""
    if texture is None or texture.significance <= FOLLOWED or texture.right.mean() > 0.85 or not len(pixel):
        return 1.0
    off = pixel[:, None, :] - texture.pixel[None]
    near = np.exp((-0.5 / NEARBY**2) * (off * off).sum(2))
    return np.maximum((near @ texture.right + 0.05 * texture.right.mean()) / (near.sum(1) + 0.05), 0.02)


@compiled
def preferences(strength, wide):
    """(N, K) 0 to 1: the strongest edge of a node counts fully, others by how clear they are beside it; sharp ones, from column wide on,
    count all alike, and where there is one, the others count little.
    """
    N, K = strength.shape
    likely = np.zeros((N, K))
    for n in range(N):
        clearest, sharp = 1e-9, False
        for k in range(K):
            certain = abs(strength[n, k]) / (abs(strength[n, k]) + CLEAR)
            if k < wide:
                likely[n, k] = certain
                clearest = max(clearest, certain)
            elif certain > 0.0:
                likely[n, k] = 1.0
                sharp = True
        for k in range(wide):
            likely[n, k] *= (0.3 if sharp else 1.0) / clearest
    return likely


def _look(sight, nodes, reach, sharp_reach=0.0):
    contrast = max(sight.settings.contrast, 0.8 * sight.patch.noise)
    return find_edges(
        sight.patch,
        nodes,
        reach,
        contrast=contrast,
        hypotheses=sight.settings.hypotheses,
        quantise=sight.settings.quantised_normals,
        sharp_reach=sharp_reach,
    )


def _find_far(sight, X_CO, reach):
    """The paper's way over a larger distance: normal flow, affine motion, POSE, gradient fit; then the edges once more."""
    settings = sight.settings
    nodes = visible_nodes(sight.model, X_CO, sight.lens, settings.nodes, settings.spacing, sight.occluders_C)
    if len(nodes) < 6:
        return X_CO
    matches = _look(sight, nodes, reach)
    X_start = X_CO
    if settings.affine:
        strongest = np.abs(matches.strength).argmax(1)
        rows = np.arange(len(nodes))
        displacement = np.where(matches.strength[rows, strongest] != 0, matches.offset[rows, strongest], np.nan)
        motion = fit_affine(
            nodes.pixel, nodes.normal, displacement, model="quadratic" if settings.quadratic else "affine"
        )
        if motion.valid:
            X_CO = fit_points(nodes.p_O, move_points(motion, nodes.pixel), np.ones(len(nodes)), X_CO, sight.lens)
    if settings.gradient_fit:
        thin = nodes.take(slice(None, None, 2))
        V_CO = sight.V_CO if settings.dynamic_step else None
        steps = search_steps(thin, X_CO, sight.lens, V_CO, sight.dt)
        X_CO = fit_gradients(sight.patch, thin, X_CO, sight.lens, steps).X_CO
    widths = (0.6 * reach, 0.4 * reach, 4.0, 3.0, 2.0)
    starts = (X_start, X_CO) if X_CO is not X_start else (X_start,)
    options = [edge_pass(sight, X, reach, widths, _about(sight, X, None, None)) for X in starts]
    return max(options, key=lambda o: weigh(o[2], o[1]).quality)[0]
