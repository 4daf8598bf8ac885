"""What the program's own files say now, in short: what is kept on disk belongs to the code and the models that made it."""

import hashlib
from collections.abc import Iterable
from functools import cache
from importlib.util import find_spec
from pathlib import Path


def digest(files: Iterable[Path]) -> str:
    """Hexadecimal SHA-256 of the contents of files, whatever their order."""
    contents = hashlib.sha256()
    for path in sorted(set(files)):
        contents.update(path.read_bytes())
    return contents.hexdigest()


@cache
def digest_of_modules(*names: str) -> str:
    """``digest`` of modules, and of packages with all they hold: code, meshes, pictures."""
    return digest(path for name in names for path in _files(name))


def _files(name):
    origin = Path(find_spec(name).origin)
    if origin.name != "__init__.py":
        return [origin]
    return [p for p in origin.parent.rglob("*") if p.is_file() and "__pycache__" not in p.parts]
