"""How well a person is followed when the light changes, by variants of the first stage."""

import numpy as np

from vipr.scenarios.bench.benchmark import Bench
from vipr.scenarios.bench.people.rooms import RoomResult, expose, judge, shots, summarise
from vipr.scenarios.bench.tables import Table
from vipr.scenarios.people.scenes import light_program, random_scene
from vipr.scenarios.workers import in_processes
from vipr.systems.skin.classifier import SkinOptions

VARIANTS = {
    "full chain": SkinOptions(),
    "light not followed": SkinOptions(follow_light=False),
    "nothing adapts": SkinOptions(follow_light=False, adapt=False),
    "r-g box, adapting": SkinOptions(classifier="box", follow_light=False),
    "r-g box, fixed": SkinOptions(classifier="box", follow_light=False, adapt=False),
    "skin locus shell": SkinOptions(classifier="locus", follow_light=False, adapt=False),
    "hue-saturation box": SkinOptions(classifier="hsi", follow_light=False, adapt=False),
}
PROGRAMS = ("constant", "fixed", "step", "drift")
FIRST = 500  # seeds between those of the rooms and those of the light


def light_table(bench: Bench) -> Table:
    """Share of truly seen parts that are tracked under each light program, by variants of the first stage."""
    results, scenes = [], bench.of(20, 2)
    for result in in_processes(judge_lights, [(bench.seed, k) for k in range(scenes)], bench.jobs):
        results.append(result)
        bench.progress(f"light: scene {len(results)} of {scenes}")
    rows = [(name, *(_tracked([r[name, program] for r in results]) for program in PROGRAMS)) for name in VARIANTS]
    return Table(
        f"Light: parts tracked % ({scenes} scenes each)",
        ("first stage", "constant white", "another light from the start", "steps", "drifts"),
        rows,
        "Intensity 0.4 to 1.6, 3000 K to 8000 K; hands apart; the mean of face and hands. Motion and the still scene help every variant.",
    )


def judge_lights(seed: int, k: int) -> dict[tuple[str, str], RoomResult]:
    """Scene k under every light program, followed by every variant."""
    scene = random_scene(seed + FIRST + k, kind="apart")
    pictures, results = list(shots(scene)), {}
    for program in PROGRAMS:
        light = light_program(np.random.default_rng((seed, k)), program, len(scene.paths))
        frames = list(expose(scene, pictures, light))
        for name, options in VARIANTS.items():
            results[name, program] = judge(scene, frames, options)
    return results


def _tracked(results: list[RoomResult]) -> float:
    """Per cent of the truly seen parts, the mean of face and hands."""
    return 100 * float(np.mean(list(summarise(results)["tracked"].values())))
