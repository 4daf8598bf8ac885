"""Boards whose corners are found in images: ChArUco boards and chessboards.

Frame B: the outer corner of the first square, x along a row, y down the rows, z into the plate; lengths in m.
"""

from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import cv2
import numpy as np
import yaml

from vipr.systems.errors import InputError

KINDS = ("charuco", "chessboard")
FEWEST = 6  # corners of a view worth using


@dataclass(frozen=True)
class Board:
    """A flat pattern of ``columns`` x ``rows`` squares, those with markers counted in."""

    columns: int
    rows: int
    square_mm: float
    kind: str = "charuco"
    marker_mm: float = 0.0  # of a ChArUco board
    dictionary: str = "4X4_50"

    def __post_init__(self):
        if self.kind not in KINDS:
            raise InputError(f"board: kind must be {' or '.join(KINDS)}, got {self.kind!r}")
        if not (3 <= self.columns <= 100 and 3 <= self.rows <= 100):
            raise InputError(f"board: needs 3 to 100 columns and rows of squares, got {self.columns} x {self.rows}")
        if not 0 < self.square_mm < 10_000:
            raise InputError(f"board: squares must be above 0 and below 10000 mm, got {self.square_mm:g} mm")
        if self.kind == "chessboard":
            if self.columns % 2 == self.rows % 2:
                raise InputError(
                    f"board: a chessboard of {self.columns} x {self.rows} squares looks the same upside down; it needs an odd and an even "
                    "number"
                )
            return
        if not 0 < self.marker_mm < self.square_mm:
            raise InputError(
                f"board: markers must be above 0 and below the square's {self.square_mm:g} mm, got {self.marker_mm:g} mm"
            )
        if not hasattr(cv2.aruco, f"DICT_{self.dictionary}"):
            raise InputError(f"board: unknown dictionary {self.dictionary!r}; 4X4_50, 5X5_100, 6X6_250 are usual ones")

    @cached_property
    def corners_B(self) -> np.ndarray:
        """(n, 3) [m] the inner corners, row by row."""
        x, y = np.meshgrid(np.arange(1, self.columns), np.arange(1, self.rows))
        return 1e-3 * self.square_mm * np.column_stack([x.ravel(), y.ravel(), np.zeros(x.size)])

    @property
    def middle_B(self) -> np.ndarray:
        """(3,) [m] the middle of the print."""
        return 5e-4 * self.square_mm * np.array([self.columns, self.rows, 0.0])


@dataclass(frozen=True, eq=False)
class BoardView:
    """Corners found in one image: ``ids`` (n,) rows of ``Board.corners_B``, ``pixels`` (n, 2)."""

    name: str
    ids: np.ndarray
    pixels: np.ndarray


def load_board(path: str | Path) -> Board:
    """Board of a YAML file with columns, rows, square_mm and, for ChArUco, marker_mm and dictionary."""
    try:
        content = yaml.safe_load(Path(path).read_text())
    except (OSError, UnicodeDecodeError, yaml.YAMLError) as error:
        raise InputError(f"board file {path}: cannot be read ({str(error).splitlines()[0]})") from None
    try:
        return Board(**content)
    except TypeError:
        allowed = ", ".join(Board.__dataclass_fields__)
        raise InputError(f"board file {path}: needs {allowed} as keys with one value each, got {content!r}") from None


def find_board(board: Board, image: np.ndarray, name: str = "image") -> BoardView | None:
    """The board's corners in an image (grey or BGR) to a fraction of a pixel; None where fewer than ``FEWEST`` are seen."""
    grey = cv2.cvtColor(image, cv2.COLOR_BGR2GRAY) if image.ndim == 3 else image
    found = _find_charuco(board, grey) if board.kind == "charuco" else _find_chessboard(board, grey)
    if found is None or len(found[0]) < FEWEST:
        return None
    ids, pixels = found
    return BoardView(name, ids, _refined(board, grey, ids, pixels))


def _find_charuco(board: Board, grey: np.ndarray) -> tuple[np.ndarray, np.ndarray] | None:
    dictionary = cv2.aruco.getPredefinedDictionary(getattr(cv2.aruco, f"DICT_{board.dictionary}"))
    size = (board.columns, board.rows)
    pattern = cv2.aruco.CharucoBoard(size, 1e-3 * board.square_mm, 1e-3 * board.marker_mm, dictionary)
    parameters = cv2.aruco.DetectorParameters()
    parameters.adaptiveThreshWinSizeMax, parameters.adaptiveThreshWinSizeStep = 43, 10
    detector = cv2.aruco.CharucoDetector(pattern, cv2.aruco.CharucoParameters(), parameters)
    corners, ids, _, _ = detector.detectBoard(grey)
    if ids is None or not len(ids):
        return None
    return np.asarray(ids).ravel(), np.asarray(corners, float).reshape(-1, 2)


def _find_chessboard(board: Board, grey: np.ndarray) -> tuple[np.ndarray, np.ndarray] | None:
    size = (board.columns - 1, board.rows - 1)
    there, corners = cv2.findChessboardCornersSB(grey, size, flags=cv2.CALIB_CB_EXHAUSTIVE | cv2.CALIB_CB_ACCURACY)
    if not there:
        return None
    pixels = np.asarray(corners, float).reshape(-1, 2)
    # The first square is dark; found from the other end, it is light.
    H, _ = cv2.findHomography(board.corners_B[:, :2], pixels)
    dark, light = (_brightness(grey, H, np.array(at) * 1e-3 * board.square_mm) for at in ((0.5, 0.5), (1.5, 0.5)))
    return np.arange(len(pixels)), pixels if dark < light else pixels[::-1]


def _brightness(grey: np.ndarray, H: np.ndarray, at: np.ndarray) -> float:
    u, v, w = H @ [*at, 1.0]
    column, row = np.clip([u / w, v / w], 0, np.array(grey.shape[::-1]) - 1).round().astype(int)
    return float(grey[row, column])


def _refined(board: Board, grey: np.ndarray, ids: np.ndarray, pixels: np.ndarray) -> np.ndarray:
    """Each corner to where the grey values are symmetric about it.

    The window must hold the corner's two edges and nothing else: it ends before the next corner, and before the markers.
    """
    H, _ = cv2.findHomography(board.corners_B[ids, :2], pixels)
    if H is None:
        return pixels
    step = 1e-3 * board.square_mm
    near = np.array(
        [board.corners_B[ids, :2], board.corners_B[ids, :2] + [step, 0], board.corners_B[ids, :2] + [0, step]]
    )
    where = cv2.perspectiveTransform(near.reshape(-1, 1, 2), H).reshape(near.shape)
    side = min(np.linalg.norm(where[k] - where[0], axis=1).min() for k in (1, 2))
    free = 1 / 3 if board.kind == "chessboard" else 0.7 * 0.5 * (1.0 - board.marker_mm / board.square_mm)
    window = int(np.clip(free * side, 2, 15))
    criteria = (cv2.TERM_CRITERIA_EPS | cv2.TERM_CRITERIA_MAX_ITER, 50, 1e-4)
    start = np.ascontiguousarray(pixels, np.float32).reshape(-1, 1, 2)
    return cv2.cornerSubPix(grey, start, (window, window), (-1, -1), criteria).reshape(-1, 2).astype(float)
