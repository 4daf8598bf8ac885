"""Four shapes drawn at random places, sizes and paces, and a classifier that is trained in a moment."""

import numpy as np

from vipr.systems.gestures.classifier import GestureClassifier

SHAPES = {
    "circle": lambda u: (np.cos(6.28 * u), np.sin(6.28 * u)),
    "ess": lambda u: (np.sin(6.28 * u), 2.0 - 4.0 * u),
    "line": lambda u: (u, 0.1 * u),
    "vee": lambda u: (u, np.abs(2.0 * u - 1.0)),
}


def drawings(rng, each=12, noise=0.01):
    X, y = [], []
    for name, shape in SHAPES.items():
        for _ in range(each):
            u = np.linspace(0.0, 1.0, rng.integers(20, 50)) ** rng.uniform(0.8, 1.2)
            points = np.column_stack(shape(u)) * rng.uniform(20, 200) + rng.uniform(-500, 500, 2)
            X.append(points + noise * np.ptp(points) * rng.normal(size=points.shape))
            y.append(name)
    return X, np.array(y)


def quick(**parameters):
    return GestureClassifier(**{"updates": 10, **parameters})
