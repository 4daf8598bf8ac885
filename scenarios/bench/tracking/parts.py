"""What each part of the method is worth: the fastest motion survived with it, and with it switched off."""

from collections.abc import Iterator
from dataclasses import fields, replace

from vipr.scenarios.bench.tables import Table
from vipr.scenarios.bench.tracking import fig11
from vipr.scenarios.bench.tracking.handheld import shaken
from vipr.scenarios.bench.tracking.workbench import BOXES, Workbench
from vipr.systems.tracking.model_tracking import TrackerSettings

TURNS = (90.0, 180.0, 270.0)  # deg/s
GLIDES = (0.4, 0.8, 1.2)  # m/s
SHAKES = (12.0, 18.0, 24.0, 30.0)  # px a frame


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
    motions = {
        "turn y deg/s": (TURNS, lambda name, v, k: fig11.turn(bench, name, "y", v)),
        "across m/s": (GLIDES, lambda name, v, k: fig11.glide(bench, name, v, 0)),
        "shaken px/frame": (SHAKES, lambda name, v, k: shaken(bench, name, 100 + k, v, 60)),
    }
    names = BOXES[:1]
    if bench.quick:
        motions = {m: (speeds[1:2], make) for m, (speeds, make) in motions.items() if m in ("turn y deg/s",)}
    settings = variants()
    fastest = {variant: {} for variant in settings}
    for motion, (speeds, make) in motions.items():
        going = {
            (variant, name, k): True for variant in settings for name in names for k in range(_runs(bench, motion))
        }
        best = dict.fromkeys(going, 0.0)
        for speed in speeds:
            for name in names:
                for k in range(_runs(bench, motion)):
                    racing = [v for v in settings if going[v, name, k]]
                    if not racing:
                        continue
                    bench.progress(f"parts: {motion} {speed:g}, {name}, {len(racing)} variants")
                    frames = make(name, speed, k)
                    for variant in racing:
                        if bench.track(name, frames, settings[variant], count=False).survived:
                            best[variant, name, k] = speed
                        else:
                            going[variant, name, k] = False
        for variant in settings:
            values = [best[key] for key in best if key[0] == variant]
            fastest[variant][motion] = sum(values) / len(values)
    table = Table(
        "Fastest motion survived (mean over objects and seeds; each stops at its first loss)",
        ("tracker", *motions),
        [(variant, *(float(fastest[variant][m]) for m in motions)) for variant in settings],
        note="Tried: "
        + "; ".join(f"{m}: {', '.join(f'{v:g}' for v in speeds)}" for m, (speeds, _) in motions.items())
        + ".",
    )
    yield table


def _runs(bench, motion):
    return 2 if motion.startswith("shaken") and not bench.quick else 1
