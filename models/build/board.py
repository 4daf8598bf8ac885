"""The calibration board: a ChArUco print on a thin plate.

Frame B: the outer corner of the print's first square, x along a row, y down the rows, z into the plate (as OpenCV counts).
"""

from pathlib import Path

import cv2
import numpy as np
import yaml

from vipr.models.build.artwork import PIXELS_PER_MM
from vipr.models.build.mesh import BOX_FACES, Mesh

SQUARES, SQUARE, MARKER, DICTIONARY = (7, 5), 0.034, 0.025, "4X4_50"  # columns and rows; m; m
BORDER, THICKNESS, MASS = 0.010, 0.004, 0.15  # m, m, kg


def print_() -> np.ndarray:
    """The print with its white border, BGR."""
    scale = 1000 * PIXELS_PER_MM
    dictionary = cv2.aruco.getPredefinedDictionary(getattr(cv2.aruco, f"DICT_{DICTIONARY}"))
    board = cv2.aruco.CharucoBoard(SQUARES, SQUARE, MARKER, dictionary)
    inner = board.generateImage(tuple(round(n * SQUARE * scale) for n in SQUARES))
    border = round(BORDER * scale)
    return cv2.cvtColor(cv2.copyMakeBorder(inner, *(border,) * 4, cv2.BORDER_CONSTANT, value=255), cv2.COLOR_GRAY2BGR)


def write(folder: Path, prints: bool = True) -> None:
    """Write the board's files below folder, the print too unless told otherwise."""
    here = folder / "calibration_board"
    here.mkdir(parents=True, exist_ok=True)
    low = np.array([-BORDER, -BORDER, 0.0])
    high = np.array([SQUARES[0] * SQUARE + BORDER, SQUARES[1] * SQUARE + BORDER, THICKNESS])
    p = np.array([(x, y, z) for z in (low[2], high[2]) for y in (low[1], high[1]) for x in (low[0], high[0])])
    mesh = Mesh()
    for face in BOX_FACES[1:]:
        mesh.polygon("card", p[list(face)])
    corners = p[list(BOX_FACES[0])]
    share = (corners - low)[:, :2] / (high - low)[:2]
    mesh.polygon("print", corners, uvs=np.column_stack([share[:, 0], 1.0 - share[:, 1]]))
    mesh.write(here / "visual.obj", {"print": "print.png", "card": (0.8, 0.79, 0.76)})
    spec = {
        "kind": "charuco",
        "columns": SQUARES[0],
        "rows": SQUARES[1],
        "square_mm": 1e3 * SQUARE,
        "marker_mm": 1e3 * MARKER,
        "dictionary": DICTIONARY,
    }
    (here / "board.yaml").write_text(yaml.safe_dump(spec, sort_keys=False))
    x, y, z = high - low
    moments = MASS / 12 * np.array([y**2 + z**2, x**2 + z**2, x**2 + y**2])
    middle = " ".join(f"{v:g}" for v in (low + high) / 2)
    values = dict(zip(("ixx", "iyy", "izz"), (f"{v:.6g}" for v in moments), strict=True))
    (here / "calibration_board.sdf").write_text(SDF.format(middle=middle, mass=MASS, **values))
    if prints:
        cv2.imwrite(str(here / "print.png"), print_(), [cv2.IMWRITE_PNG_COMPRESSION, 9])


SDF = """<?xml version="1.0"?>
<!-- Written by vipr.models.build. Frame B: outer corner of the print's first square, x along a row, y down, z into the plate. For show:
     nothing collides with it. -->
<sdf version="1.9">
  <model name="calibration_board">
    <link name="calibration_board">
      <inertial>
        <pose>{middle} 0 0 0</pose>
        <mass>{mass}</mass>
        <inertia><ixx>{ixx}</ixx><ixy>0</ixy><ixz>0</ixz><iyy>{iyy}</iyy><iyz>0</iyz><izz>{izz}</izz></inertia>
      </inertial>
      <visual name="visual"><geometry><mesh><uri>visual.obj</uri></mesh></geometry></visual>
    </link>
  </model>
</sdf>
"""
