"""Renders one object before a still camera with Drake's VTK engine, without physics, as a real camera would integrate it.

Every picture is the mean of sub-frames: each is rendered at another time of the exposure (motion blur) and with the image shifted by
another fraction of a pixel (a pixel is an area, not a point), so straight edges lie where they should to a few hundredths of a pixel. The
engine smooths what looks like a staircase, which takes up to 0.17 px off a round edge where it runs along the pixels' rows: where that
matters, sub-frames are rendered finer and their pixels averaged. Only the part of the picture where something moves is rendered again.
World frame = camera frame C (x right, y down, z forward).
"""

import tempfile
from collections.abc import Callable
from pathlib import Path

import numpy as np
from pydrake.geometry import (
    ClippingRange,
    ColorRenderCamera,
    FramePoseVector,
    GeometryFrame,
    GeometryInstance,
    LightParameter,
    MakeRenderEngineVtk,
    PerceptionProperties,
    RenderCameraCore,
    RenderEngineVtkParams,
    RenderLabel,
    SceneGraph,
)
from pydrake.geometry import Mesh as MeshShape
from pydrake.math import RigidTransform
from pydrake.systems.sensors import CameraInfo

from vipr.scenarios.sequences import scenery
from vipr.systems import se3
from vipr.systems.camera.lens import Lens
from vipr.systems.errors import InputError

BACKGROUNDS = ("plain", "clutter")
AWAY = se3.pose(np.eye(3), np.array([0.0, 0.0, -50.0]))  # behind the camera: not seen
TILE = 32  # px: rendered windows are multiples of this, so that few sizes occur
SAMPLES = 12  # sub-frames of a still picture
APART = 1.0  # px between the sub-frames of a moving one; their shifts within the pixel fill the gaps


class SequenceRenderer:
    """Objects, a hand and a background in one render engine; one renderer serves many sequences.

    objects: name -> OBJ file (its frame is O). Building costs about a second and Drake does not free it: keep it.
    """

    def __init__(self, objects: dict[str, Path], lens: Lens, *, background: str = "clutter", seed: int = 0):
        if background not in BACKGROUNDS:
            raise InputError(
                f"rendered sequences: unknown background {background!r}, allowed are {', '.join(BACKGROUNDS)}"
            )
        self.lens = lens
        self._objects = dict(objects)
        self._scene = SceneGraph()
        self._source = self._scene.RegisterSource("scenery")
        lights = [
            LightParameter(type="directional", frame="world", direction=[0.45, 0.6, 0.7], intensity=0.75),
            LightParameter(type="directional", frame="world", direction=[-0.7, 0.1, 0.6], intensity=0.4),
            LightParameter(type="directional", frame="world", direction=[0.1, -0.8, 0.5], intensity=0.2),
        ]
        params = RenderEngineVtkParams(default_clear_color=[0.45, 0.45, 0.45], lights=lights)
        self._scene.AddRenderer("vtk", MakeRenderEngineVtk(params))
        self._frames, self._points = {}, {}
        with tempfile.TemporaryDirectory() as folder:
            folder = Path(folder)
            for name, path in self._objects.items():
                self._add(name, [path])
                self._points[name] = _vertices(path)
            hand = scenery.hand()
            self._add("hand", [hand.write(folder / "hand.obj", colour=(0.78, 0.57, 0.46))])
            self._points["hand"] = hand.points
            if background == "clutter":
                self._add_clutter(folder, np.random.default_rng(seed))
            self._context = self._scene.CreateDefaultContext()
            self._pose_port = self._scene.get_source_pose_port(self._source)
            self._query = self._scene.get_query_output_port()
            self._place({})
            self._window(*self._cover(np.zeros((0, 2))), (0.0, 0.0))  # reads the files while they exist
        shifts = (np.arange(1, 65)[:, None] * (0.7548776662, 0.5698402910)) % 1.0 - 0.5
        self._shifts = shifts  # an even spread of any first n
        self._still: np.ndarray | None = None

    def points(self, name: str) -> np.ndarray:
        """(N, 3) [m] vertices of an object in O, or of the ``hand`` in its frame H."""
        return self._points[name]

    def picture(
        self,
        name: str,
        pose_at: Callable[[float], np.ndarray | None],
        hand_at: Callable[[float], np.ndarray | None] | None = None,
        *,
        exposure: float = 0.0,
        samples: int = SAMPLES,
        finer: int = 1,
    ) -> np.ndarray:
        """(h, w, 3) RGB float32, 0 to 255, without noise.

        pose_at(s) gives X_CO at s [s] from the middle of the exposure (None: the object is not there), hand_at(s) X_CH likewise. Sub-frames
        are added until neighbouring ones are at most `APART` pixels apart. Each is rendered so many times finer as finer says.
        """
        if name not in self._objects:
            raise InputError(f"rendered sequences: unknown object {name!r}, there are {', '.join(self._objects)}")
        n = samples
        if exposure > 0:
            ends = [
                self._outline(name, pose_at(s), hand_at(s) if hand_at else None) for s in (-exposure / 2, exposure / 2)
            ]
            if all(len(e) for e in ends) and len(ends[0]) == len(ends[1]):
                n = int(np.clip(np.ceil(np.abs(ends[1] - ends[0]).max() / APART), samples, len(self._shifts)))
        times = ((np.arange(n) + 0.5) / n - 0.5) * exposure
        poses = [{name: pose_at(s), "hand": hand_at(s) if hand_at else None} for s in times]
        image = self._background().copy()
        outline = np.concatenate(
            [self._outline(name, p[name], p["hand"]) for p in (poses[0], poses[n // 2], poses[-1])]
        )
        if not len(outline):
            return image
        x, y, w, h = self._cover(outline)
        shifts = self._shifts[:n] - self._shifts[:n].mean(axis=0)
        total = np.zeros((h, w, 3), np.float32)
        for p, shift in zip(poses, shifts, strict=True):
            self._place(p)
            total += self._window(x, y, w, h, shift, finer)
        image[y : y + h, x : x + w] = total[: image.shape[0] - y, : image.shape[1] - x] / n
        return image

    def _background(self):
        if self._still is None:
            self._place({})
            w, h = self.lens.width, self.lens.height
            shifts = self._shifts[:SAMPLES] - self._shifts[:SAMPLES].mean(axis=0)
            self._still = np.mean([self._window(0, 0, w, h, s) for s in shifts], axis=0, dtype=np.float32)
        return self._still

    def _add(self, name, paths):
        frame = self._scene.RegisterFrame(self._source, GeometryFrame(name))
        for k, path in enumerate(paths):
            instance = GeometryInstance(RigidTransform(), MeshShape(str(path)), f"{name}_{k}")
            geometry = self._scene.RegisterGeometry(self._source, frame, instance)
            properties = PerceptionProperties()
            properties.AddProperty("label", "id", RenderLabel.kDontCare)
            self._scene.AssignRole(self._source, geometry, properties)
        self._frames[name] = frame

    def _add_clutter(self, folder, rng):
        """A printed wall and boxes between it and the object; none comes nearer than 0.35 m behind 2 m."""
        parts = [("wall", scenery.wall(1.9, 1.5), np.array([0.0, 0.0, 3.3]), 0.0, (1024, 768, 160))]
        for k in range(9):
            size = rng.uniform(0.06, 0.22, 3)
            centre = np.array([rng.uniform(-0.45, 0.45), rng.uniform(-0.3, 0.3), rng.uniform(2.55, 3.0)])
            parts.append((f"box{k}", scenery.box(size), centre, rng.uniform(-0.8, 0.8), (384, 256, 30)))
        for name, mesh, centre, turn, (w, h, shapes) in parts:
            R = se3.exp_so3(np.array([0.2, turn, 0.0])) if turn else np.eye(3)
            mesh.faces = [f @ R.T + centre for f in mesh.faces]
            image = scenery.picture(int(rng.integers(1 << 30)), w, h, shapes)
            self._add(name, [mesh.write(folder / f"{name}.obj", image=image)])

    def _place(self, poses):
        moving = (*self._objects, "hand")
        vector = FramePoseVector()
        for name, frame in self._frames.items():
            X = poses.get(name) if name in moving else np.eye(4)
            vector.set_value(frame, RigidTransform(_exact(AWAY if X is None else X)))
        self._pose_port.FixValue(self._context, vector)

    def _window(self, x, y, w, h, shift, finer=1):
        """(h, w, 3) float32 of the part of the picture from pixel (x, y), rendered so many times finer, all content moved by the shift (of
        the finer pixels).
        """
        lens = self.lens
        # Drake's pixel centres are at halves, OpenCV's at integers.
        centre = finer * np.array([lens.cx + 0.5 - x, lens.cy + 0.5 - y]) + shift
        info = CameraInfo(w * finer, h * finer, lens.fx * finer, lens.fy * finer, *centre)
        core = RenderCameraCore("vtk", info, ClippingRange(0.1, 20.0), RigidTransform())
        query = self._query.Eval(self._context)
        image = query.RenderColorImage(ColorRenderCamera(core, False), self._scene.world_frame_id(), RigidTransform())
        fine = np.array(image.data[..., :3], np.float32)
        return fine.reshape(h, finer, w, finer, 3).mean((1, 3)) if finer > 1 else fine

    def _outline(self, name, X_CO, X_CH):
        """Pixels of the vertices of what is there and before the camera."""
        found = [np.zeros((0, 2))]
        for key, X in ((name, X_CO), ("hand", X_CH)):
            if X is not None:
                p_C = self._points[key] @ X[:3, :3].T + X[:3, 3]
                found.append(self.lens.project(p_C[p_C[:, 2] > 0.05]))
        return np.concatenate(found)

    def _cover(self, pixels, margin=4):
        """(x, y, w, h) of a window of whole tiles around the pixels and the principal point, which Drake wants inside."""
        lens = self.lens
        size = np.array([lens.width, lens.height])
        seen = np.concatenate([np.clip(pixels, (0, 0), size - 1), [[lens.cx, lens.cy]]])
        low = np.clip(np.floor(seen.min(axis=0)) - margin, 0, size).astype(int)
        high = np.clip(np.ceil(seen.max(axis=0)) + margin + 1, 0, size).astype(int)
        extent = -(-(high - low) // TILE) * TILE
        return int(low[0]), int(low[1]), int(extent[0]), int(extent[1])


def _exact(X):
    """The pose with its rotation orthonormal to rounding, as Drake insists."""
    U, _, Vt = np.linalg.svd(X[:3, :3])
    Y = np.eye(4)
    Y[:3, :3], Y[:3, 3] = U @ Vt, X[:3, 3]
    return Y


def _vertices(path):
    try:
        text = Path(path).read_text()
    except OSError as error:
        raise InputError(f"rendered sequences: {path} cannot be read ({error.strerror})") from None
    rows = [line.split()[1:4] for line in text.splitlines() if line.startswith("v ")]
    if not rows:
        raise InputError(f"rendered sequences: {path} has no vertices")
    return np.array(rows, float)
