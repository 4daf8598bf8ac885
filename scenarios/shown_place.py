"""A place that was shown: where the corners of an object were in the image, and the picture, as kept in a YAML file (paper III-F)."""

from dataclasses import dataclass, field, replace
from pathlib import Path

import cv2
import numpy as np
import yaml

from vipr.systems.camera.lens import Lens
from vipr.systems.errors import InputError
from vipr.systems.pose.estimate import PoseEstimate, estimate_pose
from vipr.systems.servo.tasks import Place
from vipr.systems.tracking.known_view import KnownView

LARGEST_RESIDUAL = 5.0  # px: corners further from any view of the object than this are not those of this object


@dataclass(frozen=True, eq=False)
class ShownPlace:
    """Corners of an object in O and in the image of one camera, and what that camera saw (an empty picture: not kept).

    Where the object truly stood is for the referee alone.
    """

    object: str
    place: int  # number of the place in ``place_by_showing``
    size: tuple[int, int]  # px, of the image
    points_O: np.ndarray  # (n, 3) m
    pixels: np.ndarray  # (n, 2)
    X_WO_true: np.ndarray | None = None  # (4, 4)
    picture: np.ndarray = field(default_factory=lambda: np.zeros((0, 0, 3), np.uint8))  # (h, w, 3) BGR

    def task(self, lens: Lens, X_WC: np.ndarray) -> Place:
        """To bring the object there, by a robot that believes in this lens and this place of the camera."""
        shown = (self.pixels - (lens.cx, lens.cy)) / (lens.fx, lens.fy)
        return Place(X_WC, self._pose(lens).X_CO, self.points_O, shown)

    def views(self, lens: Lens) -> tuple[KnownView, ...]:
        """The picture, if there is one, with the pose that the corners give in a camera believed to have this lens."""
        if not self.picture.size:
            return ()
        estimate = self._pose(lens)
        return (KnownView(self.picture, estimate.X_CO, estimate.covariance),)

    def _pose(self, lens: Lens) -> PoseEstimate:
        if self.size != (lens.width, lens.height):
            raise InputError(
                f"shown place: its image is {self.size[0]} x {self.size[1]} px, the camera's {lens.width} x {lens.height} px"
            )
        estimate = estimate_pose(self.points_O, self.pixels, lens, robust=False)
        if not estimate.valid:
            raise InputError(f"shown place: its corners give no pose: {estimate.reason}")
        if not estimate.residual_px <= LARGEST_RESIDUAL:
            raise InputError(
                f"shown place: its corners are {estimate.residual_px:.1f} px from any view of the object, allowed are "
                f"{LARGEST_RESIDUAL:g} px"
            )
        return estimate


def save_shown_place(place: ShownPlace, path: Path) -> None:
    """Write the YAML file, and beside it the picture under the same name."""
    corners = [
        {"point_m": [round(float(v), 6) for v in p], "pixel": [round(float(v), 3) for v in u]}
        for p, u in zip(place.points_O, place.pixels, strict=True)
    ]
    values = {"object": place.object, "place": place.place, "image_size": list(place.size), "corners": corners}
    if place.X_WO_true is not None:
        values["X_WO_true"] = [[round(float(v), 9) for v in row] for row in place.X_WO_true]
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        if place.picture.size:
            values["picture"] = path.with_suffix(".png").name
            path.with_suffix(".png").write_bytes(cv2.imencode(".png", place.picture)[1].tobytes())
        path.write_text(yaml.safe_dump(values, sort_keys=False, default_flow_style=None))
    except OSError as error:
        raise InputError(f"shown place {path}: cannot be written ({error.strerror})") from None


def load_shown_place(path: Path) -> ShownPlace:
    """Read the YAML file; InputError with what is wrong in it."""
    try:
        values = yaml.safe_load(path.read_text())
    except (OSError, UnicodeDecodeError, yaml.YAMLError) as error:
        reason = (str(error).splitlines() or [type(error).__name__])[0]
        raise InputError(f"shown place {path}: cannot be read ({reason})") from None
    try:
        points = np.array([corner["point_m"] for corner in values["corners"]], float).reshape(-1, 3)
        pixels = np.array([corner["pixel"] for corner in values["corners"]], float).reshape(-1, 2)
        width, height = (int(v) for v in values["image_size"])
        truth = np.array(values["X_WO_true"], float).reshape(4, 4) if "X_WO_true" in values else None
        place = ShownPlace(str(values["object"]), int(values["place"]), (width, height), points, pixels, truth)
        if "picture" in values:
            place = replace(place, picture=_picture(path.parent / str(values["picture"]), place.size))
    except (KeyError, TypeError, ValueError) as error:
        raise InputError(
            f"shown place {path}: needs object, place, image_size (2) and corners, each with point_m (3) and pixel (2); "
            f"{type(error).__name__}: {error}"
        ) from None
    if len(points) < 4 or len(points) != len(pixels) or not np.isfinite([*points.ravel(), *pixels.ravel()]).all():
        raise InputError(f"shown place {path}: 4 or more corners of finite numbers are needed, got {len(points)}")
    return place


def _picture(path: Path, size: tuple[int, int]) -> np.ndarray:
    """The picture (h, w, 3) of a place whose image has that size."""
    picture = cv2.imread(str(path), cv2.IMREAD_COLOR)
    if picture is None:
        raise InputError(f"shown place: its picture {path} cannot be read")
    if picture.shape[1::-1] != size:
        raise InputError(
            f"shown place: its picture {path} is {picture.shape[1]} x {picture.shape[0]} px, its image_size {size[0]} x {size[1]} px"
        )
    return picture
