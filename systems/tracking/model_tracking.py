"""The model-based tracker of the paper (III-B, Fig. 6) as two pure functions: ``start`` and ``step``.

One step: predict the motion; project the model and take nodes on its visible edges; find their normal displacements; fit them. Frames: O
object, C camera (x right, y down, z forward); displacements d = (w, v) as in ``pose_fit``.
"""

from dataclasses import dataclass, field, replace

import numpy as np

from vipr.systems import se3
from vipr.systems.camera.lens import Lens
from vipr.systems.errors import InputError
from vipr.systems.tracking.cad_model import CadModel
from vipr.systems.tracking.motion_filter import Motion, at_rest, correct, predict
from vipr.systems.tracking.normal_flow import cut_patch, find_edges
from vipr.systems.tracking.pose_fit import fit_pose, move, normal_jacobian
from vipr.systems.tracking.visible_edges import visible_nodes


@dataclass(frozen=True)
class TrackerSettings:
    """Every part of the tracker; each switch turns one part off for comparison."""

    nodes: int = 200  # tracking nodes, at most
    spacing: float = 3.0  # px, smallest interval of nodes
    reach: float = 14.0  # px, search along the normal in the first pass
    fine_reach: float = 5.0  # px, in the last passes
    contrast: float = 4.0  # grey levels, weakest edge that is looked at
    hypotheses: int = 4  # edges kept for each node
    prediction: bool = True  # constant-velocity filter; else the last pose is the start
    quantised_normals: bool = False  # the paper's 0, 45, 90, 135 degrees and whole pixels
    spin_noise: float = 30.0  # rad/s^2, RMS angular acceleration expected
    speed_noise: float = 4.0  # m/s^2, RMS acceleration expected

    def __post_init__(self):
        for name in ("nodes", "spacing", "reach", "fine_reach", "contrast", "hypotheses", "spin_noise", "speed_noise"):
            value = getattr(self, name)
            if not (np.isfinite(value) and value > 0):
                raise InputError(f"tracker settings: {name} must be positive, got {value}")


@dataclass(frozen=True, eq=False)
class Belief:
    """All that a tracker knows between frames."""

    motion: Motion = field(default_factory=Motion)
    state: str = "lost"  # tracking | uncertain | lost
    score: float = 0.0
    nodes: int = 0
    residual_px: float = float("nan")
    time: float = 0.0  # s, of the last frame that arrived
    number: int = -1
    doubt: int = 0  # frames in a row that were not tracked well
    started: bool = False  # whether an initial pose was given

    def __deepcopy__(self, memo):
        return self  # immutable: a context clone copies nothing

    @property
    def X_CO(self) -> np.ndarray:
        return self.motion.X_CO

    @property
    def V_CO(self) -> np.ndarray:
        return self.motion.V_CO

    @property
    def covariance(self) -> np.ndarray:
        """(6, 6) of (rotation, translation) in C."""
        return self.motion.covariance[:6, :6]


def start(X_CO: np.ndarray, time: float = 0.0, number: int = -1) -> Belief:
    """Belief in an object at rest at a pose given from outside. Raises InputError for what is no pose before the camera."""
    X_CO = np.asarray(X_CO, float)
    if not se3.is_pose(X_CO):
        raise InputError("initial pose: X_CO must be a finite 4x4 rigid motion (rotation orthonormal to 1e-3)")
    if X_CO[2, 3] <= 0:
        raise InputError(f"initial pose: the object must be in front of the camera (z > 0), got z = {X_CO[2, 3]:.4g} m")
    U, _, Vt = np.linalg.svd(X_CO[:3, :3])
    return Belief(at_rest(se3.pose(U @ Vt, X_CO[:3, 3])), "uncertain", time=time, number=number, started=True)


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
    """The belief after one image (h, w) or (h, w, 3) BGR uint8 taken at time [s]; an empty image only predicts."""
    number = belief.number + 1 if number is None else number
    if image.size and image.shape[:2] != (lens.height, lens.width):
        raise InputError(
            f"tracker: the image is {image.shape[1]} x {image.shape[0]} px, its lens is for {lens.width} x {lens.height} px"
        )
    dt = float(np.clip(time - belief.time, 0.0, 1.0)) if belief.number >= 0 else 0.0
    ahead = predict(belief.motion, dt, settings.spin_noise, settings.speed_noise)
    if not image.size:
        state = "uncertain" if belief.state == "tracking" else belief.state
        return replace(belief, motion=ahead, state=state, time=time, number=number, nodes=0, residual_px=float("nan"))
    starts = [ahead.X_CO, belief.X_CO] if settings.prediction else [belief.X_CO]
    patch = _patch(image, model, starts, lens, settings.reach + 8.0)
    for X in starts[:1]:
        X, fit, nodes = _edge_pass(
            model, X, patch, lens, settings, settings.reach, (8.0, 6.0, 4.0, 3.0, 2.0), occluders_C
        )
        for _ in range(2):
            X, fit, nodes = _edge_pass(model, X, patch, lens, settings, settings.fine_reach, (2.0, 1.5), occluders_C)
    share = float((fit.weight > 0.1).sum()) / max(len(nodes), 1)
    state = (
        "tracking" if share > 0.4 and len(nodes) >= 8 else "uncertain" if share > 0.2 and len(nodes) >= 8 else "lost"
    )
    covariance = np.linalg.inv(fit.information + 1e-3 * np.eye(6))
    motion = correct(ahead, X, covariance)
    return Belief(motion, state, share, int((fit.weight > 0.1).sum()), fit.sigma, time, number, started=True)


def _patch(image, model, poses, lens, margin):
    corners = np.concatenate([model.corners @ X[:3, :3].T + X[:3, 3] for X in poses])
    corners = corners[corners[:, 2] > 1e-3]
    if not len(corners):
        return cut_patch(image, np.zeros(2), np.zeros(2))
    pixel = lens.project(corners)
    return cut_patch(image, pixel.min(0) - margin, pixel.max(0) + margin)


def _edge_pass(model, X_CO, patch, lens, settings, reach, widths, occluders_C, prior=None):
    nodes = visible_nodes(model, X_CO, lens, settings.nodes, settings.spacing, occluders_C)
    matches = find_edges(
        patch,
        nodes,
        reach,
        contrast=max(settings.contrast, 2.0 * patch.noise),
        hypotheses=settings.hypotheses,
        quantise=settings.quantised_normals,
    )
    J = normal_jacobian(nodes, X_CO, lens)
    strength = np.abs(matches.strength)
    preference = strength / np.maximum(strength.max(1, keepdims=True, initial=0.0), 1e-9)
    fit = fit_pose(J, matches, preference, widths, prior)
    return move(X_CO, fit.d), fit, nodes
