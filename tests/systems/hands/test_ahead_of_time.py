"""What is compiled ahead is all that seeing people needs."""

import sys

import numpy as np
import pytest
from drawn_people import waving
from numba.core.registry import CPUDispatcher

from vipr.systems.hands.ahead_of_time import compile_people
from vipr.systems.hands.pipeline import PeopleBelief, see_people


def compiled_signatures():
    modules = [m for name, m in sys.modules.items() if name.startswith("vipr.systems.")]
    functions = {f for m in modules for f in vars(m).values() if isinstance(f, CPUDispatcher)}
    return {f.py_func.__qualname__: sorted(map(str, f.signatures)) for f in functions}


@pytest.mark.parametrize(("scale", "writable"), [(1, True), (1, False), (3, True)])
def test_after_compiling_ahead_seeing_people_compiles_nothing_more(scale, writable):
    compile_people()
    before, belief = compiled_signatures(), PeopleBelief()
    for k in range(20):
        image = np.kron(waving(k, **({"right": (66 + k, 40)} if k > 8 else {})), np.ones((scale, scale, 1), np.uint8))
        image.setflags(write=writable)
        belief = see_people(image, k / 25.0, k, belief)
    assert belief.tracks.face_seen and compiled_signatures() == before
