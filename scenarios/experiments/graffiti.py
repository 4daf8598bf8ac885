"""Table II again: 26 Graffiti letters of five writers, drawn in the air, filmed, tracked, recognised (paper, II-A.4)."""

from pathlib import Path

import numpy as np

from vipr.scenarios.experiments.films import HOLD, Reel, reel
from vipr.scenarios.experiments.writers import Writer, draw, graffiti

SEQUENCES, WRITERS = 2230, 5  # as in the paper


def film_writers(seed: int, camera: str, folder: Path, rounds: int | None = None, tick=lambda n: None) -> list[Reel]:
    """Reels of the five writers, one an alphabet: 2230 sequences, or ``rounds`` alphabets a writer."""
    from vipr.scenarios.person_motion import HandPaths, plane_path

    letters = graffiti()
    reels = []
    for w in range(WRITERS):
        writer = Writer.drawn(100 * seed + w)
        wanted = SEQUENCES // WRITERS if rounds is None else rounds * len(letters)
        for number in range(-(-wanted // len(letters))):
            rng = np.random.default_rng([seed, w, number])
            names = [str(a) for a in rng.permutation(list(letters))][: wanted - number * len(letters)]
            paths, bounds = [], []
            for name in names:
                drawing = draw(writer, name, letters[name], rng)
                held = np.concatenate([drawing, np.repeat(drawing[-1:], HOLD, 0)])
                paths.append(HandPaths(right=plane_path(held, size=writer.size, centre=(-0.24, -0.2))))
                bounds.append((0, len(drawing) - 1))
            reels.append(
                reel(
                    f"graffiti-{camera}-{seed}-{w}-{number}", f"writer {w + 1}", paths, names, bounds,
                    camera=camera, seed=1000 * seed + w, folder=folder, tick=tick,
                )
            )  # fmt: skip
    return reels
