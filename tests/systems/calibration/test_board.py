"""Boards in drawn images: corners where they were drawn, to a small fraction of a pixel."""

import cv2
import numpy as np
import pytest

from vipr.models import model_path
from vipr.models.build import board as model
from vipr.systems.calibration.board import Board, find_board, load_board
from vipr.systems.errors import InputError

SHIPPED = load_board(model_path("calibration_board/board.yaml"))
CHESSBOARD = Board(8, 6 + 1, 30.0, kind="chessboard")


def seen(board, print_, per_metre, border, turn, supersampling=4):
    """Image (480, 640) of a print, turned and tilted, and the homography from the board's plane [m] to its pixels."""
    c, s = 1050 * np.cos(turn), 1050 * np.sin(turn)
    middle = np.array([[1, 0, -board.middle_B[0]], [0, 1, -board.middle_B[1]], [0, 0, 1]])
    H = (
        np.array([[1, 0, 320], [0, 1, 240], [0, 0, 1]])
        @ [[c, -s, 0], [0.9 * s, 0.9 * c, 0], [0.35, -0.25, 1.0]]
        @ middle
    )
    from_print = np.array(
        [[1 / per_metre, 0, 0.5 / per_metre - border], [0, 1 / per_metre, 0.5 / per_metre - border], [0, 0, 1]]
    )
    k = supersampling
    finer = np.array([[k, 0, (k - 1) / 2], [0, k, (k - 1) / 2], [0, 0, 1]])
    size = (640 * k, 480 * k)
    large = cv2.warpPerspective(print_, finer @ H @ from_print, size, flags=cv2.INTER_AREA, borderValue=(110, 120, 130))
    image = cv2.resize(large, (640, 480), interpolation=cv2.INTER_AREA)
    noise = np.random.default_rng(0).normal(0, 1.0, image.shape)
    return np.clip(cv2.GaussianBlur(image, (0, 0), 0.6) + noise, 0, 255).astype(np.uint8), H


def chessboard_print():
    x, y = np.meshgrid(np.arange(CHESSBOARD.columns * 60), np.arange(CHESSBOARD.rows * 60))
    squares = np.where((x // 60 + y // 60) % 2 == 0, 20, 235).astype(np.uint8)
    image = cv2.copyMakeBorder(squares, *(60,) * 4, cv2.BORDER_CONSTANT, value=235)
    return cv2.cvtColor(image, cv2.COLOR_GRAY2BGR)


def offsets(board, view, H):
    expected = cv2.perspectiveTransform(board.corners_B[view.ids, :2].reshape(-1, 1, 2), H).reshape(-1, 2)
    return view.pixels - expected


@pytest.mark.parametrize("turn", [0.3, -0.5, 2.0])
def test_charuco_corners_are_found_where_they_are(turn):
    image, H = seen(SHIPPED, model.print_(), 3000, model.BORDER, turn)
    view = find_board(SHIPPED, image)
    error = offsets(SHIPPED, view, H)
    assert len(view.ids) == 24 and np.sqrt(np.mean(error**2)) < 0.05 and np.abs(error).max() < 0.2


@pytest.mark.parametrize("turn", [0.2, 0.2 + np.pi])
def test_a_chessboard_is_counted_from_its_dark_corner_whichever_way_it_is_turned(turn):
    image, H = seen(CHESSBOARD, chessboard_print(), 2000, 0.03, turn)
    view = find_board(CHESSBOARD, image)
    error = offsets(CHESSBOARD, view, H)
    assert len(view.ids) == 42 and np.sqrt(np.mean(error**2)) < 0.06


def test_an_image_without_the_board_gives_none():
    assert find_board(SHIPPED, np.full((480, 640, 3), 90, np.uint8)) is None
    assert find_board(CHESSBOARD, np.full((480, 640), 90, np.uint8)) is None


def test_the_shipped_board_is_the_model():
    assert (SHIPPED.columns, SHIPPED.rows) == model.SQUARES and SHIPPED.square_mm == 1e3 * model.SQUARE
    kept = cv2.imread(str(model_path("calibration_board/print.png")))
    assert np.array_equal(kept, model.print_())


@pytest.mark.parametrize(
    "change, said",
    [
        ({"columns": 2}, "needs 3 to 100 columns and rows of squares, got 2 x 5"),
        ({"square_mm": -1.0}, "squares must be above 0 and below 10000 mm, got -1 mm"),
        ({"marker_mm": 40.0}, "markers must be above 0 and below the square's 34 mm, got 40 mm"),
        ({"dictionary": "9X9"}, "unknown dictionary '9X9'"),
        ({"kind": "dots"}, "kind must be charuco or chessboard, got 'dots'"),
        ({"kind": "chessboard"}, "looks the same upside down"),
    ],
)
def test_impossible_boards_are_refused(change, said):
    with pytest.raises(InputError, match=said):
        Board(**({"columns": 7, "rows": 5, "square_mm": 34.0, "marker_mm": 25.0} | change))


def test_a_bad_board_file_is_refused(tmp_path):
    path = tmp_path / "board.yaml"
    path.write_text("columns: 7\nrow: 5\n")
    with pytest.raises(InputError, match="needs columns, rows, square_mm"):
        load_board(path)
