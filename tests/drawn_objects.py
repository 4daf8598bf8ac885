"""Pictures of plain objects at known poses, for tests of what sees them."""

import cv2
import numpy as np

from vipr.systems import se3
from vipr.systems.camera.lens import Lens
from vipr.systems.tracking.cad_model import Shape, build_model

LENS = Lens(160, 120, 200.0, 200.0, 79.5, 59.5)


def box(x=0.1, y=0.07, z=0.05):
    """A box centred on its frame [m]."""
    corners = 0.5 * np.array([[i * x, j * y, k * z] for i in (-1, 1) for j in (-1, 1) for k in (-1, 1)])
    faces = ((0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3))
    return build_model(Shape("box", corners, faces))


def l_shape():
    """A flat L, 100 mm long [m]: not convex."""
    outline = ((0, 0), (0.1, 0), (0.1, 0.05), (0.05, 0.05), (0.05, 0.1), (0, 0.1))
    points = np.array([[x, y, z] for z in (0, 0.05) for x, y in outline])
    sides = tuple((i, (i + 1) % 6, 6 + (i + 1) % 6, 6 + i) for i in range(6))
    return build_model(Shape("L", points, (tuple(range(6)), tuple(range(6, 12)), *sides)))


def picture(model, X_CO, lens=LENS, shades=(60, 200, 120, 230, 90, 160), background=30):
    """Flat-shaded grey picture of a convex model, drawn four times as fine."""
    fine = Lens(4 * lens.width, 4 * lens.height, 4 * lens.fx, 4 * lens.fy, 4 * lens.cx + 1.5, 4 * lens.cy + 1.5)
    image = np.full((fine.height, fine.width), background, np.uint8)
    p_C = model.vertices @ X_CO[:3, :3].T + X_CO[:3, 3]
    pixel = fine.project(p_C)
    for normal, triangle in zip(model.normals, model.triangles, strict=True):
        if normal @ X_CO[:3, :3].T @ p_C[triangle[0]] < 0:
            shade = shades[int(np.argmax(np.abs(normal))) * 2 + int(normal.sum() > 0)]
            corners = np.round(pixel[triangle] * 16).astype(np.int32)
            cv2.fillConvexPoly(image, corners, shade, cv2.LINE_AA, 4)
    return cv2.resize(image, (lens.width, lens.height), interpolation=cv2.INTER_AREA)


def pose_at(t):
    """A box that turns and moves before the camera."""
    return se3.pose(se3.exp_so3(np.array([0.5, 0.6 + 0.8 * t, 0.1])), np.array([0.02 * t, 0.0, 0.3]))
