"""Views for a calibration, made in the simulated workcell: the arm shows a board to a camera whose lens and place it knows only roughly.

The first views are planned with the rough knowledge, the others with what those gave. The arm is put into each pose and comes to rest under
its joint servo; the pose that goes with the picture is the encoders'.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path

import cv2
import numpy as np
from pydrake.systems.analysis import Simulator

from vipr.diagrams.workcell import Workcell, WorkcellConfig
from vipr.diagrams.workcell_layout import fixed_camera, obstacles, puma_with_hand
from vipr.models import model_path
from vipr.systems import se3
from vipr.systems.arm import puma560
from vipr.systems.arm.puma_body import puma_with_hand_body
from vipr.systems.arm.shapes import box
from vipr.systems.calibration.board import Board, find_board, load_board
from vipr.systems.calibration.calibrate import calibrate
from vipr.systems.calibration.files import write_hand_poses
from vipr.systems.camera.imperfections import Imperfection
from vipr.systems.camera.lens import Lens, load_lens
from vipr.systems.errors import InputError

BOARD = "calibration_board"
FIRST = 8  # views planned with rough knowledge
SETTLE = 0.3  # s, at rest before a picture
ROUGH_MARGIN, MARGIN = 75.0, 15.0  # px, of the board from the image's border
TILT = np.deg2rad(38.0)  # of the board against the line of sight, at most
DEPTH = (1.65, 2.30)  # m, of the board's middle
CLEAR = 0.02  # m, of arm, hand and board from everything
STOP_MARGIN = np.deg2rad(5.0)  # of the joints


@dataclass(frozen=True, eq=False)
class Truth:
    """What the calibration is to find, and the board's place in the hand."""

    lens: Lens
    X_WC: np.ndarray
    X_EB: np.ndarray


def held_board(board: Board) -> np.ndarray:
    """X_EB as the hand is meant to hold it: the plate before the open fingers, its print away from the palm."""
    return se3.pose(np.diag([1.0, -1.0, -1.0]), [0, 0, 0.05]) @ se3.pose(np.eye(3), -board.middle_B)


def truth(seed: int, board: Board, *, other_camera: bool = False) -> Truth:
    """The workcell's camera, or one that the seed has moved and given another lens; the board is held a little askew."""
    rng = np.random.default_rng((seed, 1))
    lens, X_WC = load_lens(model_path("xc77/camera.yaml")), fixed_camera()
    X_EB = _askew(held_board(board), 5.0, 3.0, rng)
    if other_camera:
        fx, fy = np.array([lens.fx, lens.fy]) * (1.0 + 0.03 * rng.uniform(-1, 1, 2))
        cx, cy = np.array([lens.cx, lens.cy]) + rng.uniform(-6, 6, 2)
        lens, X_WC = replace(lens, fx=fx, fy=fy, cx=cx, cy=cy), _askew(X_WC, 30.0, 1.5, rng)
    return Truth(lens, X_WC, X_EB)


def _askew(X: np.ndarray, mm: float, deg: float, rng: np.random.Generator) -> np.ndarray:
    R = se3.exp_so3(np.deg2rad(deg) * rng.uniform(-1, 1, 3) / np.sqrt(3))
    return se3.pose(X[:3, :3] @ R, X[:3, 3] + 1e-3 * mm * rng.uniform(-1, 1, 3))


def simulate_views(
    out: Path,
    seed: int,
    count: int = 20,
    *,
    other_camera: bool = False,
    imperfection: Imperfection = Imperfection(),
    progress: Callable[[int], None] = lambda done: None,
) -> Truth:
    """Write ``images/view_00.png`` ... and ``poses.csv`` to the folder; returns what was true.

    Raises:
        InputError: for a count outside 4 to 200.
    """
    if not 4 <= count <= 200:
        raise InputError(f"calibrate: --views must be 4 to 200, got {count}")
    board = load_board(model_path(f"{BOARD}/board.yaml"))
    true, rng = truth(seed, board, other_camera=other_camera), np.random.default_rng((seed, 2))
    rig = _Rig(true, imperfection, seed)
    lens, X_WC = load_lens(model_path("xc77/camera.yaml")), fixed_camera()  # as on the drawing
    images = out / "images"
    images.mkdir(parents=True, exist_ok=True)
    for old in images.glob("view_*.png"):  # of an earlier run with more views
        old.unlink()
    poses, seen = {}, []
    planner = _Planner(board, rng)
    while len(poses) < count:
        if len(seen) == min(FIRST, count):
            rough = calibrate(board, [view for view, _ in seen], [X for _, X in seen], (lens.width, lens.height))
            lens, X_WC = rough.lens, rough.X_WC
        q = planner.next(lens, X_WC, ROUGH_MARGIN if len(seen) < FIRST else MARGIN)
        image, X_WE = rig.show(q)
        view = find_board(board, image, f"view_{len(poses):02d}.png")
        if view is None:
            continue
        cv2.imwrite(str(images / view.name), image)
        poses[view.name] = X_WE
        seen.append((view, X_WE))
        progress(len(poses))
    write_hand_poses(out / "poses.csv", poses)
    return true


class _Planner:
    """Chooses poses of the arm that show the board all over the image, turned and at different distances, touching nothing."""

    def __init__(self, board: Board, rng: np.random.Generator):
        self._board, self._rng, self._near = board, rng, puma560.NAMED["nominal"]
        self._X_BE = se3.inverse(held_board(board))
        size = 1e-3 * board.square_mm * np.array([board.columns, board.rows]) + 0.03
        X_PE = se3.pose(np.eye(3), [0.0, 0.0, puma_with_hand().X_6E[2, 3] - puma560.FLANGE])
        plate = box("board", (*size, 0.02), X_PE @ held_board(board) @ se3.pose(np.eye(3), board.middle_B))
        self._arm = puma_with_hand()
        self._body = puma_with_hand_body(self._arm, held=(plate,))
        self._outline = np.vstack([board.corners_B, 2 * board.middle_B * [[0, 0, 0], [1, 0, 0], [0, 1, 0], [1, 1, 0]]])

    def next(self, lens: Lens, X_WC: np.ndarray, margin: float) -> np.ndarray:
        rng = self._rng
        for _ in range(3000):
            aim = [rng.uniform(margin, lens.width - margin), rng.uniform(margin, lens.height - margin), 1.0]
            tilt, about, roll = TILT * np.sqrt(rng.uniform()), rng.uniform(-np.pi, np.pi), rng.uniform(-np.pi, np.pi)
            R = se3.exp_so3(tilt * np.array([np.cos(about), np.sin(about), 0.0])) @ se3.exp_so3(np.array([0, 0, roll]))
            middle = np.linalg.solve(lens.K, aim) * rng.uniform(*DEPTH)
            X_CB = se3.pose(R, middle - R @ self._board.middle_B)
            pixels = lens.project(self._outline @ R.T + X_CB[:3, 3])
            if (pixels < margin).any() or (pixels > np.array([lens.width, lens.height]) - margin).any():
                continue
            X_W6 = X_WC @ X_CB @ self._X_BE @ se3.inverse(self._arm.X_6E)
            try:
                q = puma560.inverse_near(X_W6, self._near, STOP_MARGIN)
            except InputError:
                continue
            if self._body.clearance(q, obstacles())[0] > CLEAR:
                return q
        raise InputError("calibrate: no pose of the arm found that shows the board to the camera")


class _Rig:
    """The workcell with the board in its hand."""

    def __init__(self, true: Truth, imperfection: Imperfection, seed: int):
        self._cell = Workcell(
            WorkcellConfig(
                object=BOARD,
                X_EO_held=true.X_EB,
                lens=true.lens,
                X_WC=true.X_WC,
                imperfection=imperfection,
                seed=seed,
                camera_period=SETTLE,
            )
        )
        self._simulator = Simulator(self._cell)
        self._context = self._simulator.get_mutable_context()
        self._cell.GetInputPort("motor_command").FixValue(self._context, np.zeros(4))
        self._cell.GetInputPort("stage_desired_state").FixValue(self._context, np.zeros(6))
        self._pictures = 0

    def show(self, q: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """A picture with the arm at rest near q (6,) [rad], and X_WE by the encoders."""
        cell, plant = self._cell, self._cell.plant
        context = plant.GetMyMutableContextFromRoot(self._context)
        puma = plant.GetModelInstanceByName("puma560")
        plant.SetPositions(context, puma, q)
        plant.SetVelocities(context, puma, np.zeros(6))
        cell.GetInputPort("arm_desired_state").FixValue(self._context, np.concatenate([q, np.zeros(6)]))
        if not self._pictures:
            self._simulator.Initialize()
        self._pictures += 1
        self._simulator.AdvanceTo(self._pictures * SETTLE + 0.001)
        measured = cell.GetOutputPort("joint_state").Eval(self._context)[:6]
        return cell.GetOutputPort("frame").Eval(self._context).image, cell.arm.tool_pose(measured)
