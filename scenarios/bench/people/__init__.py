"""``vipr bench people``: Table I row by row, rendered rooms, light, real clips, skin pixels."""

from collections.abc import Iterator
from pathlib import Path

import numpy as np

from vipr.scenarios.bench.benchmark import Bench
from vipr.scenarios.bench.people.clips import FACE_TOLERANCE, HAND_TOLERANCE, lone_hands, run_clips
from vipr.scenarios.bench.people.light import light_table
from vipr.scenarios.bench.people.pixels import classifiers, photographs, room_pixels, scores, uci_pixels
from vipr.scenarios.bench.people.rooms import judge_room, summarise
from vipr.scenarios.bench.people.time import time_table
from vipr.scenarios.bench.people.variants import VARIANTS, run_variant
from vipr.scenarios.bench.tables import Table
from vipr.scenarios.workers import in_processes
from vipr.systems.hands import parts

PARTS = {
    "time": "Table I row by row, with the size of the image",
    "rooms": "rendered rooms: accuracy, seen or not, identities",
    "light": "light that changes, with parts of the method left out",
    "clips": "real clips beside another tracker",
    "variants": "the same clips as other cameras would have taken them",
    "pixels": "skin pixels: precision and recall",
}
SEED = 1000
NEEDS_DATA = {"clips": "video/", "variants": "video/"}


def tables(part: str, bench: Bench) -> Iterator[Table]:
    """The tables of one part; pixels of photographs are left out without data (skin/ and images/)."""
    if part == "time":
        yield time_table(bench.of(120, 40), bench.progress)
    if part == "rooms":
        yield from rooms_tables(bench)
    if part == "light":
        yield light_table(bench)
    if part == "clips":
        bench.progress("clips")
        yield clips_table(bench.data, 200 if bench.quick else None)
        yield lone_hands_table(bench.data)
    if part == "variants":
        yield variants_table(bench)
    if part == "pixels":
        yield from pixel_tables(bench.data, bench.of(5, 1), bench.progress)


def rooms_tables(bench: Bench) -> Iterator[Table]:
    """Rendered rooms: accuracy, seen or not, identities; over all and by what the scene is like."""
    results, seeds = [], bench.seeds(100, 10)
    for result in in_processes(judge_room, [(seed,) for seed in seeds], bench.jobs):
        results.append(result)
        bench.progress(f"room {len(results)} of {len(seeds)}")
    columns = (
        "scenes",
        "n",
        *(f"{p} RMS px" for p in parts.PARTS),
        *(f"{p} tracked %" for p in parts.PARTS),
        *(f"{p} seen right %" for p in parts.PARTS),
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
        f"Rendered rooms, 160x120, {len(seeds)} random scenes of 6 s", columns, rows,
        "RMS over frames in which part and truth are seen within 10 px; tracked: truly seen parts reported within 10 px; first s left out.",
    )  # fmt: skip
    s = summarise(results)
    yield Table(
        "Identities of the hands", ("scenes", "swapped without contact", "partings after contact", "swapped after parting"),
        [(len(seeds), s["scenes_swapped_without_contact"], s["partings"], s["swapped_after_parting"])],
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


def variants_table(bench: Bench) -> Table:
    """Real clips mirrored, cropped, in other light: hit rates."""
    rows = []
    for name, variant in VARIANTS.items():
        bench.progress(f"clips, {name}")
        hits = run_variant(bench.data, variant, 200 if bench.quick else None)
        for clip in dict.fromkeys(h.clip for h in hits):
            groups = [[h for h in hits if h.clip == clip and (h.part == "face") == face] for face in (True, False)]
            shares = [
                100 * sum(getattr(h, counted) for h in group) / (sum(h.visible for h in group) or np.nan)
                for group, counted in zip((*groups, groups[1]), ("hits", "hits", "either"), strict=True)
            ]
            rows.append((clip, name, *shares))
    return Table(
        "Variants of the real clips", ("clip", "variant", "face %", "hands %", "either hand %"), sorted(rows, key=lambda r: r[0]),
        "Shares of the frames in which the reference is sure, hits as above; what differs little between variants can be trusted.",
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
