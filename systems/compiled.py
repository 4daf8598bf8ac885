"""Inner loops compiled by numba, where arrays of a few hundred numbers would spend their time in numpy's calls.

``compiled`` turns a pure function of numbers and arrays into machine code at its first call, and keeps that beside its module (or in the
user's cache folder), so that the next process starts with it. A change in a compiled function that others call from another module
needs ``make clean-compiled``: what is kept is checked against the caller's own file only.
"""

from collections.abc import Callable

from numba import njit


def compiled(function: Callable) -> Callable:
    """The function, compiled; division by zero gives inf or nan, as in numpy. Where nothing can be kept, each process compiles anew."""
    try:
        return njit(cache=True, error_model="numpy")(function)
    except RuntimeError:  # no folder that can be written
        return njit(error_model="numpy")(function)
