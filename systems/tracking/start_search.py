"""Search for an object around a pose that is given but not trusted: directional chamfer matching over a grid, then a discrete descent.

Edge pixels of the image are sorted into orientations; each orientation has its truncated distance transform. The cost of a pose is the
mean, over the nodes of its visible edges, of the distance to the nearest image edge of the node's own orientation (directional chamfer
matching: Liu, Tuzel, Veeraraghavan, Chellappa, CVPR 2010). A grid over the image shift, the roll and the two tilts finds the basins; the
best of them are followed down in all six displacements by halving steps (as in eq. 35 of the paper).
Frames: O object, C camera; displacements (w, v) as in ``displacements``.
"""

from dataclasses import dataclass

import cv2
import numpy as np

from vipr.systems.camera.lens import Lens
from vipr.systems.tracking.cad_model import CadModel
from vipr.systems.tracking.displacements import corner_shift, move, point_jacobian
from vipr.systems.tracking.visible_edges import visible_nodes

ORIENTATIONS = 12  # channels of the edge map, 15 degrees each


@dataclass(frozen=True)
class SearchRange:
    """How far from the given pose the object may be, and how finely that is looked through."""

    shift_px: float = 28.0  # in the image, each way
    turn_deg: float = 6.0  # roll and each tilt, each way
    step_px: float = 4.0  # of the grid
    basins: int = 24  # followed down
    kept: int = 6  # returned


@dataclass(frozen=True, eq=False)
class EdgeField:
    """Truncated distances to the image's edges by orientation, in a patch: ``pixel - origin`` is the position in it."""

    distance: np.ndarray  # (ORIENTATIONS, h, w) px
    origin: np.ndarray  # (2,) px
    limit: float  # px, where distances are cut


def edge_field(image: np.ndarray, low: np.ndarray, high: np.ndarray, limit: float = 10.0) -> EdgeField:
    """Edges of the image (h, w[, 3]) uint8 between pixels low and high (2,).

    What counts as an edge adapts to the patch: the steeper third of its local maxima, and nothing below the noise.
    """
    height, width = image.shape[:2]
    x0, y0 = np.clip(np.floor(low).astype(int), 0, (width - 8, height - 8))
    x1, y1 = np.clip(np.ceil(high).astype(int), (x0 + 8, y0 + 8), (width, height))
    part = image[y0:y1, x0:x1]
    smooth = cv2.GaussianBlur(part, (0, 0), 1.0).astype(np.float32)
    gx, gy = cv2.Sobel(smooth, cv2.CV_32F, 1, 0) / 8.0, cv2.Sobel(smooth, cv2.CV_32F, 0, 1) / 8.0
    if part.ndim == 3:  # of the three colours the one with the steepest step
        strongest = (gx * gx + gy * gy).argmax(2)[..., None]
        gx, gy = (np.take_along_axis(g, strongest, 2)[..., 0] for g in (gx, gy))
    magnitude, angle = cv2.cartToPolar(gx, gy)
    direction = np.round(angle / (np.pi / 4)).astype(int) % 4  # of the gradient: where its neighbours are
    padded = cv2.copyMakeBorder(magnitude, 1, 1, 1, 1, cv2.BORDER_REPLICATE)
    dy, dx = np.array([[0, 1, 1, 1], [1, 1, 0, -1]])[:, direction]
    rows, columns = np.indices(magnitude.shape)
    ahead = padded[rows + 1 + dy, columns + 1 + dx]
    behind = padded[rows + 1 - dy, columns + 1 - dx]
    threshold = max(1.5, 3.0 * float(np.median(magnitude)) if magnitude.size else 1.5)
    edge = (magnitude >= ahead) & (magnitude >= behind) & (magnitude > min(threshold, 6.0))
    channel = np.floor(angle % np.pi / np.pi * ORIENTATIONS).astype(int) % ORIENTATIONS
    fields = np.empty((ORIENTATIONS, *edge.shape), np.float32)
    for k in range(ORIENTATIONS):
        near = (channel == k) | (channel == (k + 1) % ORIENTATIONS) | (channel == (k - 1) % ORIENTATIONS)
        blank = np.where(edge & near, 0, 255).astype(np.uint8)
        fields[k] = cv2.distanceTransform(blank, cv2.DIST_L2, 3) if (blank == 0).any() else limit
    fields = np.minimum(fields, limit)
    fields = np.pad(fields, ((0, 0), (1, 1), (1, 1)), constant_values=limit)  # what lies outside is as far as can be
    return EdgeField(fields, np.array([x0, y0], float) - 1.0, limit)


def channels(normal: np.ndarray, turn: float = 0.0) -> np.ndarray:
    """Orientation channel (N,) of edges with image normals (N, 2), turned by ``turn`` [rad]."""
    angle = np.arctan2(normal[:, 1], normal[:, 0]) + turn
    return np.floor(angle % np.pi / np.pi * ORIENTATIONS).astype(np.int32) % ORIENTATIONS


def chamfer(field: EdgeField, pixel: np.ndarray, channel: np.ndarray, limit: float) -> np.ndarray:
    """Mean distance (...,) [px], cut at ``limit``, of nodes at pixel (..., N, 2) in orientation channels (N,)."""
    h, w = field.distance.shape[1:]
    x = np.clip(np.rint(pixel[..., 0] - field.origin[0]), 0, w - 1)
    y = np.clip(np.rint(pixel[..., 1] - field.origin[1]), 0, h - 1)
    place = (y * w + x).astype(np.int32) + channel * np.int32(h * w)
    return np.minimum(np.take(field.distance.ravel(), place), limit).mean(-1)


def field_around(
    image: np.ndarray, model: CadModel, lens: Lens, X_CO: np.ndarray, around: SearchRange = SearchRange()
) -> EdgeField | None:
    """Edges of the image wherever the model may be; None if it is behind the camera or out of view."""
    corners = model.corners @ X_CO[:3, :3].T + X_CO[:3, 3]
    if (corners[:, 2] <= 1e-3).any() or min(image.shape[:2]) < 16:
        return None
    pixel = lens.project(corners)
    margin = around.shift_px + 0.12 * np.ptp(pixel, axis=0).max() + 12.0
    if (pixel.max(0) < -margin).any() or (pixel.min(0) > np.array([lens.width, lens.height]) + margin).any():
        return None
    return edge_field(image, pixel.min(0) - margin, pixel.max(0) + margin)


def search_start(
    field: EdgeField,
    model: CadModel,
    lens: Lens,
    X_CO: np.ndarray,
    around: SearchRange = SearchRange(),
    occluders_C: np.ndarray | None = None,
) -> list[np.ndarray]:
    """Poses near X_CO at which the model's edges lie on edges of the image, the likeliest first."""
    cells = _grid(field, model, lens, X_CO, around, occluders_C)
    found = [_descend(field, model, lens, X, occluders_C) for _, X in cells]
    found.sort(key=lambda item: item[0])
    distinct: list[np.ndarray] = []
    for _, X in found:
        if all(corner_shift(model, lens, X, other) > 1.5 for other in distinct):
            distinct.append(X)
    return distinct[: around.kept]


def pose_cost(
    field: EdgeField,
    model: CadModel,
    lens: Lens,
    X_CO: np.ndarray,
    occluders_C: np.ndarray | None = None,
    limit: float = 4.0,
) -> float:
    """Chamfer cost of a pose [px], distances cut at ``limit``: what starts are compared by; infinite if next to nothing is visible."""
    nodes = visible_nodes(model, X_CO, lens, 150, 2.0, occluders_C)
    if len(nodes) < 8:
        return float("inf")
    return float(chamfer(field, nodes.pixel, channels(nodes.normal), limit))


def _grid(field, model, lens, X_CO, around, occluders_C) -> list[tuple[float, np.ndarray]]:
    """(cost, pose) of the best cells over shift, roll and tilts, no two of them neighbours."""
    turns = np.deg2rad(around.turn_deg) * np.array([-1.0, -0.5, 0.0, 0.5, 1.0])
    shifts = np.arange(-around.shift_px, around.shift_px + 1e-9, around.step_px)
    dx, dy = (s.ravel() for s in np.meshgrid(shifts, shifts))
    scale = np.array([lens.fx, lens.fy]) / X_CO[2, 3]
    cells = []
    for tilt_x in turns[::2]:
        for tilt_y in turns[::2]:
            X_tilted = move(X_CO, np.array([tilt_x, tilt_y, 0.0, 0, 0, 0]))
            nodes = visible_nodes(model, X_tilted, lens, 120, 3.0, occluders_C)
            if len(nodes) < 8:
                continue
            centre = lens.project(X_tilted[:3, 3])
            for roll in turns:
                c, s = np.cos(roll), np.sin(roll)
                rolled = (nodes.pixel - centre) @ np.array([[c, s], [-s, c]]) + centre
                pixel = rolled + np.stack([dx, dy], 1)[:, None]
                cost = chamfer(field, pixel, channels(nodes.normal, roll), field.limit)
                for k in np.argsort(cost)[:4]:
                    d = np.array([0, 0, roll, dx[k] / scale[0], dy[k] / scale[1], 0.0])
                    cells.append((float(cost[k]), move(X_tilted, d)))
    cells.sort(key=lambda cell: cell[0])
    return cells[: around.basins]


def _descend(field, model, lens, X_CO, occluders_C, levels: int = 5) -> tuple[float, np.ndarray]:
    """(cost, pose) at the foot of the basin: steps that move the nodes by 4 px at first, halved from level to level."""
    for far in (1.0, 0.5):  # the visible edges are worked out anew half way
        nodes = visible_nodes(model, X_CO, lens, 150, 2.0, occluders_C)
        if len(nodes) < 8:
            return field.limit, X_CO
        channel, limit = channels(nodes.normal), far * field.limit
        J = point_jacobian(nodes.p_O, X_CO, lens)
        steps = far * 4.0 / np.maximum(np.sqrt((J * J).sum(1).mean(0)), 1e-9)
        moves = np.concatenate([np.diag(steps), -np.diag(steps)])
        shifts = np.einsum("nij,mj->mni", J, moves)
        pixel, d = nodes.pixel, np.zeros(6)
        best = chamfer(field, pixel, channel, limit)
        for level in range(levels):
            for _ in range(6):
                around = pixel + 0.5**level * shifts
                costs = chamfer(field, around, channel, limit)
                k = int(np.argmin(costs))
                if costs[k] >= best:
                    break
                best, pixel, d = costs[k], around[k], d + 0.5**level * moves[k]
        X_CO = move(X_CO, d)
    return pose_cost(field, model, lens, X_CO, occluders_C), X_CO
