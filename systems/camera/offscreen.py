"""Offscreen rendering: one way to make a render engine, and a clear word where the machine cannot."""

import ctypes
import glob

from pydrake.geometry import (
    ClippingRange,
    ColorRenderCamera,
    DepthRange,
    DepthRenderCamera,
    LightParameter,
    MakeRenderEngineVtk,
    RenderCameraCore,
    RenderEngineVtkParams,
    SceneGraph,
)
from pydrake.math import RigidTransform
from pydrake.systems.sensors import CameraInfo, RgbdSensor

from vipr.systems.camera.lens import Lens
from vipr.systems.errors import InputError

CURE = "on Debian or Ubuntu: apt-get install --no-install-recommends libglib2.0-0 libegl1 libgl1-mesa-dri"
_FOLDERS = ("/usr/lib", "/usr/lib/*", "/usr/lib64", "/usr/local/lib", "/usr/local/lib/*")
_DRIVERS = tuple(
    f"{folder}/{file}" for folder in _FOLDERS for file in ("dri/*_dri.so", "libgallium*.so", "libEGL_nvidia.so*")
)


def require_offscreen_rendering() -> None:
    """Raise InputError with the cure where EGL or a driver for it is missing (VTK would end the process)."""
    try:
        ctypes.CDLL("libEGL.so.1")
    except OSError:
        raise InputError(f"rendering: libEGL.so.1 is missing; {CURE}") from None
    if not any(glob.glob(pattern) for pattern in _DRIVERS):
        raise InputError(f"rendering: no Mesa or other OpenGL driver found; {CURE}")


def add_renderer(scene_graph: SceneGraph, name: str, parameters: RenderEngineVtkParams) -> None:
    """Add a VTK engine under the name."""
    require_offscreen_rendering()
    scene_graph.AddRenderer(name, MakeRenderEngineVtk(parameters))


def daylight() -> RenderEngineVtkParams:
    """A room in daylight: lights fixed in the world; Drake's default light moves with the camera."""
    lights = [
        LightParameter(type="directional", direction=[-0.5, 0.4, -0.9], intensity=0.9, frame="world"),
        LightParameter(type="directional", direction=[0.3, 0.8, -0.4], intensity=0.45, frame="world"),
        LightParameter(type="directional", direction=[-0.6, -0.7, -0.2], intensity=0.35, frame="world"),
        LightParameter(type="directional", direction=[0.0, 0.0, 1.0], intensity=0.15, frame="world"),
    ]
    return RenderEngineVtkParams(lights=lights)


def colour_sensor(lens: Lens, X_WC: RigidTransform, renderer: str, supersampling: int = 1) -> RgbdSensor:
    """A camera fixed in the world with the lens's intrinsics, ``supersampling`` times as many pixels each way.

    Only its colour image is meant to be used.
    """
    k = supersampling
    cx, cy = k * (lens.cx + 0.5), k * (lens.cy + 0.5)
    info = CameraInfo(k * lens.width, k * lens.height, k * lens.fx, k * lens.fy, cx, cy)
    core = RenderCameraCore(renderer, info, ClippingRange(0.05, 20.0), RigidTransform())
    depth = DepthRenderCamera(core, DepthRange(0.1, 15.0))
    return RgbdSensor(SceneGraph.world_frame_id(), X_WC, ColorRenderCamera(core), depth)
