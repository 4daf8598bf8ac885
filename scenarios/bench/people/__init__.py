"""``vipr bench people``: Table I row by row, rendered rooms, light, real clips, skin pixels."""

from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np

from vipr.scenarios.bench.people.clips import FACE_TOLERANCE, HAND_TOLERANCE, lone_hands, run_clips
from vipr.scenarios.bench.people.light import light_table
from vipr.scenarios.bench.people.pixels import classifiers, photographs, room_pixels, scores, uci_pixels
from vipr.scenarios.bench.people.rooms import judge_room, summarise
from vipr.scenarios.bench.people.time import time_table
from vipr.scenarios.bench.tables import Table, chosen_parts
from vipr.scenarios.workers import in_processes
from vipr.systems.errors import InputError
from vipr.systems.hands.parts import PARTS

TABLES = ("time", "rooms", "light", "clips", "pixels")


def run(
    quick: bool = False,
    only: list[str] | None = None,
    data: Path | None = None,
    seed: int = 1000,
    progress: Callable[[str], None] = lambda what: None,
) -> Iterator[Table]:
    """The tables, one by one; ``data`` is the folder with video/, skin/ and images/."""
    chosen = chosen_parts("people", only, TABLES)
    if data is None and {"clips", "pixels"} & set(only or ()):
        raise InputError("bench people: clips and pixels need --data FOLDER with video/, skin/ and images/")
    if "time" in chosen:
        yield time_table(40 if quick else 120, progress)
    if "rooms" in chosen:
        yield from rooms_tables(10 if quick else 100, seed, progress)
    if "light" in chosen:
        yield light_table(2 if quick else 20, seed, progress)
    if "clips" in chosen and data is not None:
        progress("clips")
        yield clips_table(data, 200 if quick else None)
        yield lone_hands_table(data)
    if "pixels" in chosen:
        yield from pixel_tables(data, 1 if quick else 5, progress)


def rooms_tables(scenes: int, seed: int, progress) -> Iterator[Table]:
    """Rendered rooms: accuracy, seen or not, identities; over all and by what the scene is like."""
    results = []
    for result in in_processes(judge_room, [(seed + k,) for k in range(scenes)]):
        results.append(result)
        progress(f"room {len(results)} of {scenes}")
    columns = (
        "scenes",
        "n",
        *(f"{p} RMS px" for p in PARTS),
        *(f"{p} tracked %" for p in PARTS),
        *(f"{p} seen right %" for p in PARTS),
    )
    rows = []
    groups = {"all": results}
    for name, of in (
        ("", lambda r: r.scene.kind),
        ("sleeves ", lambda r: r.scene.look.sleeves),
        ("", lambda r: r.scene.look.decor),
    ):
        for value in sorted({of(r) for r in results}):
            groups[f"{name}{value}"] = [r for r in results if of(r) == value]
    for name, group in groups.items():
        s = summarise(group)
        rows.append(
            (
                name,
                len(group),
                *s["rms_px"].values(),
                *(100 * v for k in ("tracked", "seen_right") for v in s[k].values()),
            )
        )
    yield Table(
        f"Rendered rooms, 160x120, {scenes} random scenes of 6 s", columns, rows,
        "RMS over frames in which part and truth are seen within 10 px; tracked: truly seen parts reported within 10 px; first s left out.",
    )  # fmt: skip
    s = summarise(results)
    yield Table(
        "Identities of the hands", ("scenes", "swapped without contact", "partings after contact", "swapped after parting"),
        [(scenes, s["scenes_swapped_without_contact"], s["partings"], s["swapped_after_parting"])],
    )  # fmt: skip


def clips_table(data: Path, most: int | None) -> Table:
    """Real clips: hit rates."""
    rows = [
        (h.clip, h.part, h.visible, h.hits, 100 * h.hits / h.visible, h.either, h.median_error)
        for h in run_clips(data, most=most)
    ]
    return Table(
        "Real clips", ("clip", "part", "reference visible", "hits", "%", "either hand", "median error / shoulder width"), rows,
        f"A hit is a part seen within {FACE_TOLERANCE} (face) or {HAND_TOLERANCE} (hand) shoulder widths of the reference of visibility >= "
        "0.5; the reference is another tracker and not the truth.",
    )  # fmt: skip


def lone_hands_table(data: Path) -> Table:
    """Clips that show a hand and nobody: what is reported in them."""
    clips, frames, *shares = lone_hands(data)
    return Table(
        "Clips of one hand alone", ("clips", "frames", "a face %", "a hand %", "two hands %"),
        [(clips, frames, *(100 * v for v in shares))],
        "Shares of the frames in which each is reported; there is one hand and no face.",
    )  # fmt: skip


def pixel_tables(data: Path | None, seeds: int, progress) -> Iterator[Table]:
    """Precision and recall of skin pixels."""
    columns = ("classifier", "precision %", "recall %")
    if data is not None:
        progress("labelled pixels")
        pixels, skin = uci_pixels(data)
        yield Table(
            "UCI skin pixels",
            columns,
            [(n, *(100 * v for v in scores(f(pixels), skin))) for n, f in classifiers().items()],
        )
        photos = list(photographs(data))
        rows = []
        for name, f in classifiers().items():
            found = np.concatenate([f(photo)[::2, ::2].ravel() for _, photo, _ in photos])
            true = np.concatenate([skin[::2, ::2].ravel() for *_, skin in photos])
            rows.append((name, *(100 * v for v in scores(found, true))))
        yield Table(
            f"{len(photos)} photographs with the face's skin masked",
            columns,
            rows,
            "Necks and hands are not in the masks.",
        )
    rows = []
    for decor in ("plain", "beige", "wood"):
        progress(f"pixels in {decor} rooms")
        rows += [
            (f"{decor}: {n}", 100 * p, 100 * r) for n, (p, r) in room_pixels(decor, range(7000, 7000 + seeds)).items()
        ]
    yield Table("Skin pixels in rendered rooms after the first second", columns, rows)
