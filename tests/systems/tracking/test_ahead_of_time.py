"""What is compiled ahead is all that tracking needs."""

import sys

import numpy as np
from drawn_objects import LENS, box, l_shape, picture, pose_at
from numba.core.registry import CPUDispatcher

from vipr.systems.signals import Occluders
from vipr.systems.tracking.ahead_of_time import compile_tracker
from vipr.systems.tracking.belief import start
from vipr.systems.tracking.model_tracking import step


def compiled_signatures():
    modules = [m for name, m in sys.modules.items() if name.startswith("vipr.systems.")]
    functions = {f for m in modules for f in vars(m).values() if isinstance(f, CPUDispatcher)}
    return {f.py_func.__qualname__: list(map(str, f.signatures)) for f in functions}


def test_after_compiling_ahead_tracking_compiles_nothing_more():
    compile_tracker()
    before = compiled_signatures()
    hand = Occluders(triangles_C=np.array([[[0.5, 0.5, 0.1], [0.6, 0.5, 0.1], [0.5, 0.6, 0.1]]]))
    for model, colour in ((box(), False), (box(), True), (l_shape(), False)):
        belief = start(pose_at(0.0))
        for k in range(3):
            image = picture(box(), pose_at(0.04 * k))
            image = np.repeat(image[..., None], 3, axis=2) if colour else image
            belief = step(belief, image, 0.04 * k, model, LENS, occluders_C=hand.triangles_C)
    assert compiled_signatures() == before
