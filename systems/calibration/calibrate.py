"""The calibration of a fixed camera by a board in the hand: from views and arm poses to a lens and X_WC, with their standard errors."""

from dataclasses import dataclass

import numpy as np

from vipr.systems import se3
from vipr.systems.calibration.board import Board, BoardView
from vipr.systems.calibration.bundle import INTRINSICS, ArmAccuracy, Fit, Model, Observations, adjust
from vipr.systems.calibration.closed_form import camera_and_board, focal_lengths, homography, plane_pose
from vipr.systems.camera.lens import Lens
from vipr.systems.errors import InputError

FEWEST_VIEWS = 4


@dataclass(frozen=True, eq=False)
class Calibration:
    """A calibrated camera. Standard errors are of one sigma."""

    lens: Lens
    X_WC: np.ndarray  # (4, 4)
    X_EB: np.ndarray  # (4, 4) the board in the hand
    intrinsics_error: dict[str, float]  # px for fx, fy, cx, cy; of the coefficients
    X_WC_covariance: np.ndarray  # (6, 6) of (rotation, translation) in W, rad^2, rad m, m^2: of C's origin
    rms_px: float  # distance of a corner from where the fit puts it
    noise_px: float  # of a corner's coordinate, as the residuals show it
    residuals: np.ndarray  # (N, 2) px, of the corners used
    pixels: np.ndarray  # (N, 2)
    views: tuple[str, ...]
    corners: int  # used
    left_out: int

    @property
    def position_error_mm(self) -> np.ndarray:
        """(3,) standard errors of the camera's position along x, y, z of W."""
        return 1e3 * np.sqrt(np.diag(self.X_WC_covariance)[3:])

    @property
    def rotation_error_deg(self) -> np.ndarray:
        """(3,) standard errors of its rotation about x, y, z of W."""
        return np.rad2deg(np.sqrt(np.diag(self.X_WC_covariance)[:3]))


def calibrate(
    board: Board,
    views: list[BoardView],
    X_WE: list[np.ndarray],
    size: tuple[int, int],
    *,
    radial: int = 0,
    arm: ArmAccuracy = ArmAccuracy(),
) -> Calibration:
    """Calibrate from views of the board, X_WE of the hand in each, and the image's size (width, height) [px].

    Raises:
        InputError: too few views, poses that are none, or views too alike.
    """
    if len(views) != len(X_WE):
        raise InputError(f"calibrate: {len(views)} views but {len(X_WE)} poses of the hand")
    if len(views) < FEWEST_VIEWS:
        raise InputError(f"calibrate: needs at least {FEWEST_VIEWS} views that show the board, got {len(views)}")
    if radial not in (0, 1, 2):
        raise InputError(f"calibrate: 0, 1 or 2 coefficients of radial distortion can be estimated, got {radial}")
    for view, X in zip(views, X_WE, strict=True):
        if not se3.is_pose(X):
            raise InputError(f"calibrate: the pose of the hand for {view.name} is not a rigid 4x4 pose")
    observations = Observations(
        np.repeat(np.arange(len(views)), [len(view.ids) for view in views]),
        np.concatenate([board.corners_B[view.ids] for view in views]),
        np.concatenate([view.pixels for view in views]),
        np.array(X_WE, float),
    )
    fit = adjust(observations, _start(board, views, observations.X_WE, size), radial=radial, arm=arm)
    return _told(fit, observations, views, size)


def _start(board: Board, views: list[BoardView], X_WE: np.ndarray, size: tuple[int, int]) -> Model:
    centre = 0.5 * (np.array(size) - 1.0)
    homographies = [homography(board.corners_B[view.ids, :2], view.pixels) for view in views]
    fx, fy = focal_lengths(homographies, tuple(centre))
    K = np.array([[fx, 0, centre[0]], [0, fy, centre[1]], [0, 0, 1]])
    X_CB = np.array([plane_pose(H, K) for H in homographies])
    X_CW, X_EB = camera_and_board(X_CB, X_WE)
    return Model(np.array([fx, fy, *centre, 0.0, 0.0]), X_CW, X_EB, np.zeros((len(views), 6)))


def _told(fit: Fit, observations: Observations, views: list[BoardView], size: tuple[int, int]) -> Calibration:
    k, X_CW = len(fit.free), fit.model.X_CW
    fx, fy, cx, cy, *radial = (float(v) for v in fit.model.intrinsics)
    errors = np.sqrt(np.diag(fit.covariance))
    distortion = (*radial, 0.0, 0.0, 0.0) if k > 4 else ()
    X_WC = se3.inverse(X_CW)
    # X_CW moved by exp(x) moves C by -x, given in C at C's origin.
    T = np.kron(np.eye(2), X_WC[:3, :3])
    residuals = fit.residuals[fit.used]
    return Calibration(
        lens=Lens(*size, fx, fy, cx, cy, distortion),
        X_WC=X_WC,
        X_EB=fit.model.X_EB,
        intrinsics_error={INTRINSICS[i]: float(errors[i]) for i in fit.free},
        X_WC_covariance=T @ fit.covariance[k : k + 6, k : k + 6] @ T.T,
        rms_px=float(np.sqrt(np.mean(np.sum(residuals**2, axis=1)))),
        noise_px=fit.noise,
        residuals=residuals,
        pixels=observations.pixels[fit.used],
        views=tuple(view.name for view in views),
        corners=int(fit.used.sum()),
        left_out=int((~fit.used).sum()),
    )
