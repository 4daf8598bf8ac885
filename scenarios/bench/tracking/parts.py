"""What each part of the method is worth: what is followed with it, and with it switched off."""

from collections.abc import Iterator
from dataclasses import fields, replace

from vipr.scenarios.bench.tables import Table
from vipr.scenarios.bench.tracking import fig11
from vipr.scenarios.bench.tracking.handheld import shaken
from vipr.scenarios.bench.tracking.workbench import BOXES, Workbench
from vipr.systems.tracking.settings import TrackerSettings

TURNS = (90.0, 180.0)  # deg/s
GLIDES = (0.4, 0.8, 1.2)  # m/s
SHAKEN = 6  # hand-held runs


def variants() -> dict[str, TrackerSettings]:
    """The tracker as it is, with each of its switches turned, and as the paper has it."""
    full = TrackerSettings()
    switches = [f.name for f in fields(full) if isinstance(getattr(full, f.name), bool)]
    found = {"all parts": full}
    for name in switches:
        value = getattr(full, name)
        found[f"no {name.replace('_', ' ')}" if value else f"with {name.replace('_', ' ')}"] = replace(
            full, **{name: not value}
        )
    return found


def run(bench: Workbench) -> Iterator[Table]:
    name = BOXES[0]
    motions = {
        "turn x deg/s": (TURNS, lambda v: fig11.turn(bench, name, "x", v)),
        "across m/s": (GLIDES, lambda v: fig11.glide(bench, name, v, 0)),
    }
    if bench.quick:
        motions = {"across m/s": (GLIDES[:1], motions["across m/s"][1])}
    settings = variants()
    fastest = {variant: dict.fromkeys(motions, 0.0) for variant in settings}
    for motion, (speeds, make) in motions.items():
        racing = list(settings)
        for speed in speeds:
            bench.progress(f"parts: {motion} {speed:g}, {len(racing)} variants")
            frames = make(speed)
            racing = [v for v in racing if bench.track(name, frames, settings[v], count=False).survived]
            for variant in racing:
                fastest[variant][motion] = speed
            if not racing:
                break
    followed = dict.fromkeys(settings, 0)
    for k in range(1 if bench.quick else SHAKEN):
        bench.progress(f"parts: hand-held {k + 1}")
        held = BOXES[k % 2]
        frames = shaken(bench, held, k, frames=60, samples=4)
        for variant in settings:
            followed[variant] += bench.track(held, frames, settings[variant], count=False).survived
    yield Table(
        f"Fastest motion survived ({name}; up to the first loss), and hand-held runs followed of {SHAKEN}",
        ("tracker", *motions, "hand-held"),
        [(variant, *speeds.values(), followed[variant]) for variant, speeds in fastest.items()],
        note="Tried: "
        + "; ".join(f"{m}: {', '.join(f'{v:g}' for v in speeds)}" for m, (speeds, _) in motions.items())
        + ".",
    )
