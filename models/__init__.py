"""Robot, camera and object models: one folder each, with the source of every figure in its README."""

from importlib.resources import files
from pathlib import Path


def model_path(relative: str) -> Path:
    """Path of a file of this package, e.g. ``model_path("puma560/puma560.urdf")``."""
    path = Path(str(files("vipr.models"))) / relative
    if not path.exists():
        raise FileNotFoundError(f"vipr.models has no {relative!r}")
    return path


def object_names() -> list[str]:
    """The objects that have a CAD edge model."""
    return sorted(path.parent.name for path in model_path("package.xml").parent.glob("*/model.yaml"))
