"""Rival poses: others nearby whose edges also lie on edges of the image. A band of print beside a rim is as long and as strong as the
rim; what tells them apart is that at the right pose all edges fit to a fraction of a pixel at once.

A few nodes drawn at random, each with one of the edges along its normal, give a pose; the poses to which most other nodes agree are kept
(random sample consensus) and settled on the image. Same inputs, same draws.
"""

import numpy as np

from vipr.systems.compiled import compiled
from vipr.systems.tracking.diagnosis import weigh
from vipr.systems.tracking.displacements import corner_information, difference, move, normal_jacobian
from vipr.systems.tracking.edge_pass import about, edge_pass, look
from vipr.systems.tracking.normal_flow import Matches
from vipr.systems.tracking.pose_fit import Fit, add_row
from vipr.systems.tracking.sight import Sight
from vipr.systems.tracking.small_algebra import dot6, invert, mirror, solve
from vipr.systems.tracking.visible_edges import visible_nodes

REACH = 10.0  # px, how far from its node an edge may be
HYPOTHESES = 8  # edges of a node, at most
DRAWS = 500
DRAWN = 6  # nodes
DRAWN_PX = 0.5  # how well a drawn edge is known
# px, about a drawn pose, within which other nodes agree, from pass to pass
WIDTHS = np.array([1.5, 1.5, 1.0, 0.6, 0.4])
PROMISING = 0.75  # share of the best agreement so far below which a draw is given up
APART = 0.5  # px RMS of the nodes between rivals
KEPT = 8  # rivals
ROUNDS = 3  # at most; each starts from the best of the one before
BETTER = 0.1  # of merit: a rival that is clearly to be preferred; where the model is not exact, wrong poses fit a little closer too
NUDGE_BETTER = 0.03  # of merit: the same pose, a little moved
EXACT = 0.1  # px: residuals of edges that lie where they seem to, and not of a line of print beside them
NUDGE_PX = 0.7  # RMS of the corners: how far nudges are
UNEXPECTED = 0.015  # of merit, lost for each unit of the squared Mahalanobis distance from what was expected


def settle_on(sight: Sight, X_CO: np.ndarray, passes: int = 3) -> tuple[np.ndarray, Fit, Matches]:
    """The pose at which the edges nearest to X_CO fit, and how they do."""
    for _ in range(passes):
        prior = about(sight, X_CO, X_CO, None)
        X_CO, fit, matches, _ = edge_pass(
            sight, X_CO, sight.settings.fine_reach, (0.7,), prior, sharp=True, settled=True
        )
    return X_CO, fit, matches


def closest(sight: Sight, X_CO: np.ndarray) -> np.ndarray:
    """The pose near X_CO whose edges fit most closely; X_CO itself unless others are clearly better.

    A line of print along an edge may fit as closely as the edge: what is farther from the pose expected must fit closer.
    """
    best, most = X_CO, _merit(sight, *settle_on(sight, X_CO))
    for _ in range(ROUNDS):
        settled = [settle_on(sight, X) for X in rivals(sight, best)]
        merit, X = max(((_merit(sight, *one), one[0]) for one in settled), key=lambda one: one[0], default=(0.0, best))
        if merit < most + BETTER:
            break
        best, most = X, merit
    return best


def nudged(sight: Sight, X_CO: np.ndarray) -> np.ndarray:
    """The pose, or one a fraction of a pixel away along the directions that the image shows least of, if its edges fit clearly closer.

    Where print runs along an edge within a pixel, nearest edges lead no farther than to the nearest of several poses.
    """
    settled = [settle_on(sight, X_CO)]
    fit = settled[0][1]
    if not fit.weight.any():
        return X_CO
    shape = corner_information(sight.model, X_CO, sight.lens, np.sqrt(len(sight.model.corners)))
    L = np.linalg.cholesky(shape + 1e-9 * np.diag(shape.diagonal()))
    weakest = np.linalg.solve(L.T, np.linalg.eigh(L.T @ invert(fit.information) @ L)[1][:, -3:])
    settled += [settle_on(sight, move(X_CO, NUDGE_PX * way)) for way in (*weakest.T, *-weakest.T)]
    merits = [0.5 * (_merit(sight, *one) + _exactness(one[1])) for one in settled]
    best = int(np.argmax(merits))
    return settled[best][0] if merits[best] > merits[0] + NUDGE_BETTER else X_CO


def _exactness(fit: Fit) -> float:
    """Closeness to a tenth of a pixel. Far from the pose, few edges may be so close and the others missing: it compares neighbours only."""
    return float(np.nan_to_num(np.exp(-0.5 * (fit.residual / EXACT) ** 2)).mean())


def _merit(sight: Sight, X_CO: np.ndarray, fit: Fit, matches: Matches) -> float:
    off = difference(sight.X_CO_ahead, X_CO)
    return weigh(matches, fit).closeness - UNEXPECTED * float(off @ sight.information @ off)


def rivals(sight: Sight, X_CO: np.ndarray) -> list[np.ndarray]:
    """Poses near X_CO at which many nodes have an edge, the likeliest first; X_CO is one of them if its own do."""
    settings = sight.settings
    nodes = visible_nodes(sight.model, X_CO, sight.lens, settings.nodes, settings.spacing, sight.occluders_C)
    if len(nodes) < DRAWN:
        return []
    matches = look(sight, nodes, REACH, REACH, HYPOTHESES)
    # Where there is none, the wide derivative must do.
    sharp = (matches.strength[:, matches.wide :] != 0).any(1)[:, None]
    offset, strength = (
        np.where(sharp, part[:, matches.wide :], part[:, : matches.wide]) for part in (matches.offset, matches.strength)
    )
    pull = sight.information @ difference(X_CO, sight.X_CO_ahead)
    J = normal_jacobian(nodes, X_CO, sight.lens)
    return [move(X_CO, d) for d in _agreed(J, offset, strength != 0, sight.information, pull)]


@compiled
def _agreed(J, offset, present, prior, pull):
    """(M, 6) displacements on which most nodes agree, the best first."""
    N, K = offset.shape
    count = np.zeros(N, np.int64)
    for n in range(N):
        for k in range(K):
            count[n] += present[n, k]
    found, agreement = np.zeros((KEPT, 6)), np.full(KEPT, -1.0)
    state, most = np.uint64(88172645463325252), 0.0
    for _ in range(DRAWS):
        H, g = prior.copy(), pull.copy()
        for _ in range(DRAWN):
            state = _next(state)
            n = int(state % np.uint64(N))
            if count[n] == 0:
                continue
            state = _next(state)
            left, k = int(state % np.uint64(count[n])), 0
            while left > 0 or not present[n, k]:
                left -= present[n, k]
                k += 1
            add_row(H, g, J[n], 1.0 / DRAWN_PX**2, offset[n, k])
        mirror(H)
        d, score = solve(H, g), 0.0
        for turn in range(len(WIDTHS)):
            H, g, score = prior.copy(), pull.copy(), 0.0
            for n in range(N):
                predicted, nearest = dot6(J[n], d), np.inf
                for k in range(K):
                    if present[n, k] and abs(offset[n, k] - predicted) < abs(nearest):
                        nearest = offset[n, k] - predicted
                if abs(nearest) < 3.0 * WIDTHS[turn]:
                    agrees = np.exp(-0.5 * (nearest / WIDTHS[turn]) ** 2)
                    score += agrees / N
                    add_row(H, g, J[n], agrees / WIDTHS[turn] ** 2, nearest + predicted)
            if turn == 0:
                if score < PROMISING * most:
                    break
                most = max(most, score)
            if turn + 1 < len(WIDTHS):
                mirror(H)
                d = solve(H, g)
        else:
            _keep(found, agreement, J, d, score)
    order = np.argsort(-agreement)
    return found[order][: (agreement > 0.0).sum()]


@compiled
def _next(state):
    """Marsaglia's xorshift."""
    state ^= state << np.uint64(13)
    state ^= state >> np.uint64(7)
    return state ^ (state << np.uint64(17))


@compiled
def _keep(found, agreement, J, d, score):
    """Puts d among those found, in the place of one that is the same or of the worst, if it is better."""
    place, same = 0, False
    for i in range(len(found)):
        if agreement[i] < 0.0:
            continue
        square = 0.0
        for n in range(len(J)):
            square += dot6(J[n], d - found[i]) ** 2
        if square < APART**2 * len(J):
            place, same = i, True
            break
    if not same:
        place = agreement.argmin()
    if score > agreement[place]:
        agreement[place], found[place] = score, d
