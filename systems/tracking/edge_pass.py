"""One pass over the edges: nodes, normal flow, robust fit; and the paper's way over a larger distance (Fig. 6)."""

import numpy as np

from vipr.systems.compiled import compiled
from vipr.systems.tracking.affine import fit_affine, move_points
from vipr.systems.tracking.diagnosis import weigh
from vipr.systems.tracking.displacements import difference, move, normal_jacobian
from vipr.systems.tracking.gradient_fit import fit_gradients, search_steps
from vipr.systems.tracking.limbs import at_limbs
from vipr.systems.tracking.normal_flow import find_edges, noise_px
from vipr.systems.tracking.parallel_edges import told_apart
from vipr.systems.tracking.pose_fit import Prior, fit_points, fit_pose
from vipr.systems.tracking.rims import straightened
from vipr.systems.tracking.sight import Sight
from vipr.systems.tracking.small_algebra import solve
from vipr.systems.tracking.texture import TextureFit
from vipr.systems.tracking.visible_edges import Nodes, visible_nodes

CLEAR = 12.0  # grey levels; much stronger edges are all alike
NEARBY = 12.0  # px
SHARP_REACH = 3.0  # px
FOLLOWED = 4.0  # significance from which a texture alignment is followed


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
    settled: bool = False,
):
    """Nodes, edges within reach [px] and one robust fit: (pose, Fit, Matches, how far the texture shows each node uncovered).

    sharp: near the pose the sharp derivative decides, wherever the edge is clear of the noise, and the nearest edge wins.
    alone: the prior without the texture, where there is one. settled: only the edges nearest to where the nodes are count.
    """
    settings = sight.settings
    nodes = visible_nodes(sight.model, X_CO, sight.lens, settings.nodes, settings.spacing, sight.occluders_C)
    matches, noise, certain, common = placed_edges(sight, nodes, X_CO, reach, sharp and settings.sharp)
    J = normal_jacobian(nodes, X_CO, sight.lens)
    shown = uncovered(nodes.pixel, texture) * certain
    likely = preferences(matches.strength, matches.wide)
    model_error = np.where(nodes.edge < len(sight.model.edges), settings.model_error, settings.round_error)
    model_error = np.hypot(model_error, common)
    common = {"edge": nodes.edge, "noise": noise, "model_error": model_error, "node_weight": shown}
    free = None
    if alone is not None:  # how well the edges agree among themselves is not for other cues to spoil
        free = fit_pose(J, matches, likely, widths, alone, anneal=False, **common).spread
    fit = fit_pose(
        J, matches, likely, widths, prior, doubt=doubt, spread=free, anneal=alone is None and not settled, **common
    )
    return move(X_CO, fit.d), fit, matches, shown


def placed_edges(sight: Sight, nodes: Nodes, X_CO: np.ndarray, reach: float, sharp: bool):
    """Edges within reach [px] of the nodes: (Matches, the noise (N, K) [px] of their places, how far each node can be trusted, (N,) or 1,
    what may be wrong with the places of all nodes of an edge, (N,) [px] or 0).

    sharp: those near the pose also by the sharp derivative, each edge of the model its own, limbs and rims where they are.
    """
    matches, certain, common = look(sight, nodes, reach, SHARP_REACH if sharp else 0.0), 1.0, 0.0
    noise = noise_px(matches.strength, matches.wide, sight.patch.noise)
    if sharp:
        matches, certain = told_apart(matches, nodes, len(sight.model.edges))
        matches, noise, placed, common = at_limbs(matches, noise, sight.patch, nodes, sight.model, sight.lens)
        matches, certain = straightened(matches, nodes, sight.model, X_CO, sight.lens), certain * placed
    return matches, noise, certain, common


def uncovered(pixel, texture):
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


def look(sight, nodes, reach, sharp_reach=0.0, hypotheses=None):
    """The edges along the normals of the nodes, as many as the settings say or as given."""
    contrast = max(sight.settings.contrast, 0.8 * sight.patch.noise)
    return find_edges(
        sight.patch,
        nodes,
        reach,
        contrast=contrast,
        hypotheses=hypotheses or sight.settings.hypotheses,
        quantise=sight.settings.quantised_normals,
        sharp_reach=sharp_reach,
    )


def about(sight, X_CO, X_aim, information):
    """Prior of the displacement from X_CO: the prediction, and a pose X_aim of the given information (None: nothing more)."""
    off = difference(X_CO, sight.X_CO_ahead)
    if information is None:
        return Prior(off, sight.information)
    both = sight.information + information
    return Prior(solve(both, sight.information @ off + information @ difference(X_CO, X_aim)), both)


def find_far(sight, X_CO, reach):
    """The paper's way over a larger distance: normal flow, affine motion, POSE, gradient fit; then the edges once more."""
    settings = sight.settings
    nodes = visible_nodes(sight.model, X_CO, sight.lens, settings.nodes, settings.spacing, sight.occluders_C)
    if len(nodes) < 6:
        return X_CO
    matches = look(sight, nodes, reach)
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
        thin = nodes.take(np.arange(0, len(nodes), 2))
        V_CO = sight.V_CO if settings.dynamic_step else None
        steps = search_steps(thin, X_CO, sight.lens, V_CO, sight.dt)
        X_CO = fit_gradients(sight.patch, thin, X_CO, sight.lens, steps).X_CO
    widths = (0.6 * reach, 0.4 * reach, 4.0, 3.0, 2.0)
    starts = (X_start, X_CO) if X_CO is not X_start else (X_start,)
    options = [edge_pass(sight, X, reach, widths, about(sight, X, None, None)) for X in starts]
    return max(options, key=lambda o: weigh(o[2], o[1]).quality)[0]
