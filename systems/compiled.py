"""Inner loops compiled by numba, where arrays of a few hundred numbers would spend their time in numpy's calls.

``compiled`` turns a pure function of numbers and arrays into machine code at its first call, and keeps that below its stage's
``__pycache__``, so that the next process starts with it. Compiled functions call each other across modules, and numba looks at the caller's
file only: here what is kept belongs to the sources of the whole stage, and any change in them compiles anew.
"""

import inspect
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import cache
from pathlib import Path

from numba import config, njit

from vipr.systems.sources import digest


def compiled(function: Callable) -> Callable:
    """The function, compiled; division by zero gives inf or nan, as in numpy. Where nothing can be kept, each process compiles anew."""
    with _kept_in(folder_of(Path(inspect.getfile(function)).parent)):
        try:
            return njit(cache=True, error_model="numpy")(function)
        except RuntimeError:  # no folder that can be written
            return njit(error_model="numpy")(function)


@cache
def folder_of(stage: Path) -> Path:
    """Where the compiled code of the modules in a folder is kept: named for what they, and the rigid motions, say now."""
    sources = digest({*stage.glob("*.py"), Path(__file__).with_name("se3.py")})
    return stage / "__pycache__" / f"compiled-{sources[:12]}"


@contextmanager
def _kept_in(folder: Path) -> Iterator[None]:
    """Functions that numba takes up meanwhile are kept there, or, if that cannot be written, where numba finds a place."""
    usual = config.CACHE_DIR
    try:
        folder.mkdir(parents=True, exist_ok=True)
        config.CACHE_DIR = str(folder)
    except OSError:
        pass
    try:
        yield
    finally:
        config.CACHE_DIR = usual
