"""``vipr bench grasp``: picks of random placements, with errors of the pose, with parts of the robot left out, and with finer physics."""

import json
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np

from vipr.models import object_names
from vipr.scenarios.bench import grasp_switch
from vipr.scenarios.bench.tables import Table, chosen_parts
from vipr.scenarios.pick_trial import pick_trial
from vipr.scenarios.workers import in_processes

PARTS = ("placements", "errors", "choices", "physics", "switch")
PAIRED = 30  # placements, the first ones, for each error, choice and for the finer physics
ERRORS = (3.0, 6.0, 10.0)  # mm and degrees
ERROR_PLACES = {
    "seen": "Errors added to the pose that is seen; the support corrects what it can",
    "believed": "Errors added to the pose that is believed with the support's help; nothing corrects them",
}
CHOICES = {
    "no TorqueSwitch": ("hand.break_away_torque=.inf",),
    "the best grasp only, once": ("one_grasp=true", "pick.attempts=1"),
    "point contact": ("contact_model=point",),
    "the tracker alone, without the support": ("pick.settle=false", "pick.sure_mm=20"),
}
AS_IT_IS = "as it is"
HALF_STEP = ("time_step_s=0.0025",)

ENERGIES = {  # largest kinetic energy of everything while a grasp is held
    "energy at first uJ": "kinetic_first_j",  # third of the hold
    "energy at last uJ": "kinetic_last_j",
}
JUDGED = (
    "held %",
    "slip mm",
    "worst",
    "once lifted mm",
    "worst once lifted",
    "tilt deg",
    "attempts",
    "knocked over",
    "unnoticed",
)

Rows = list[dict]


def run(
    trials: int,
    only: list[str],
    seed: int,
    jobs: int,
    settings: list[str],
    kept: Path | None,
    progress: Callable[[str], None],
) -> Iterator[Table]:
    """The tables of the parts asked for: ``trials`` placements, at most ``PAIRED`` of them again for each error, choice and the physics.

    Picks are written to the file ``kept`` as they are done, and those found there are not done again.
    """
    parts, part = chosen_parts("grasp", only, PARTS), min(trials, PAIRED)
    store = _Store(kept)

    def picks(count: int, name: str, *overrides: str) -> Rows:
        """The first ``count`` placements with these settings, objects in turn."""
        objects = object_names()
        tasks = [(objects[i % len(objects)], seed + i, (*settings, *overrides)) for i in range(count)]
        new = in_processes(pick_trial, [task for task in tasks if task not in store], jobs)
        rows = []
        for task in tasks:
            if task not in store:
                store.keep(task, next(new))
            rows.append(store[task])
            progress(f"{name}: {len(rows)} of {count}; {task[0]} {task[1]}: {rows[-1]['reason']}")
        return rows

    if "switch" in parts:
        yield grasp_switch.run(seed, progress)
    if parts == ["switch"]:
        return
    rows = picks(trials if "placements" in parts else part, AS_IT_IS)
    if "placements" in parts:
        yield _placements(rows)
    same = rows[:part]
    if "errors" in parts:
        for place, title in ERROR_PLACES.items():
            where = f"pose_error_in={place}"
            levels = {
                f"{e:g}": picks(part, f"{e:g} mm {place}", f"pose_error_mm={e}", f"pose_error_deg={e}", where)
                for e in ERRORS
            }
            yield _compared(title, "error, mm and degrees", {"0": same, **levels})
    if "choices" in parts:
        variants = {name: picks(part, name, *overrides) for name, overrides in CHOICES.items()}
        yield _compared("What each choice is worth", "robot", {AS_IT_IS: same, **variants})
    if "physics" in parts:
        yield _physics(same, picks(part, "half the time step", *HALF_STEP))


class _Store(dict):
    """Rows by task, and in a file with one JSON line a pick."""

    def __init__(self, path: Path | None):
        super().__init__()
        self._path = path
        if path is not None and path.exists():
            for line in path.read_text().splitlines():
                (name, seed, overrides), row = json.loads(line)
                self[name, seed, tuple(overrides)] = row

    def keep(self, task: tuple, row: dict) -> None:
        self[task] = row
        if self._path is not None:
            with self._path.open("a") as file:
                file.write(json.dumps([task, row]) + "\n")


def _placements(rows: Rows) -> Table:
    columns = ("object", "placements", *JUDGED)
    table = Table("Random placements, pose from the tracker: lifted 150 mm, carried 300 mm, held 5 s", columns)
    groups = {name: [r for r in rows if r["object"] == name] for name in object_names()}
    for name, some in {**groups, "all": rows}.items():
        if some:
            table.rows.append((name, len(some), *_summary(some)))
    table.note = "; ".join(f"{r['object']} seed {r['seed']}: {r['reason']}" for r in rows if not r["success"])
    return table


def _compared(title: str, first: str, variants: dict[str, Rows]) -> Table:
    columns = (first, "placements", *JUDGED)
    table = Table(title, columns)
    table.rows = [(name, len(rows), *_summary(rows)) for name, rows in variants.items()]
    return table


def _physics(coarse: Rows, fine: Rows) -> Table:
    columns = ("time step", "placements", "held %", "median slip mm", *ENERGIES)
    table = Table("Physics: half the time step, and energy while a grasp is held", columns)
    for name, rows in (("5 ms", coarse), ("2.5 ms", fine)):
        energy = [1e6 * max((r[key] for r in rows if key in r), default=np.nan) for key in ENERGIES.values()]
        table.rows.append((name, len(rows), _percent(rows), _numbers(rows, "slip_mm", np.median), *energy))
    return table


def _summary(rows: Rows) -> tuple:
    attempts = float(np.mean([r.get("attempts", 0) for r in rows]))
    return (
        _percent(rows),
        _numbers(rows, "slip_mm", np.median),
        _numbers(rows, "slip_mm", np.max),
        _numbers(rows, "slip_after_lift_mm", np.median),
        _numbers(rows, "slip_after_lift_mm", np.max),
        _numbers(rows, "object_tilt_deg", np.max),
        attempts,
        int(sum(r.get("knocked_over", 0) for r in rows)),
        int(sum(r.get("unnoticed", 0) for r in rows)),
    )


def _percent(rows: Rows) -> float:
    return 100.0 * float(np.mean([r["success"] for r in rows]))


def _numbers(rows: Rows, key: str, of) -> float:
    """Of the picks that held."""
    values = [r[key] for r in rows if r["success"]]
    return float(of(values)) if values else float("nan")
