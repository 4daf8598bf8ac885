"""Accuracy in rendered living rooms, against the label image: centres, seen or not, identities, and light."""

from dataclasses import dataclass

import numpy as np
from scipy.ndimage import binary_dilation

from vipr.scenarios.people.film import PARTS, TrackTable, studio
from vipr.scenarios.people.motion import joint_positions
from vipr.scenarios.people.scenes import Scene, random_scene
from vipr.systems.camera.illumination import illuminate
from vipr.systems.camera.imperfections import ImperfectCamera, Imperfection
from vipr.systems.hands.label_truth import LEFT, RIGHT, tracks_from_labels
from vipr.systems.hands.pipeline import PeopleBelief, see_people
from vipr.systems.skin.classifier import SkinOptions

BOOTSTRAP = 25  # frames that the chain has to find its person
FAR = 10.0  # px at 160 px width: farther off is lost, not inaccurate
PARTED = 8  # frames after hands have parted, when their names are checked


@dataclass(frozen=True, eq=False)
class RoomResult:
    """One scene: per frame and part."""

    scene: Scene
    error: np.ndarray  # (n, 3) px, NaN where not both seen
    seen: np.ndarray  # (n, 3) bool, reported
    seen_true: np.ndarray  # (n, 3) bool
    contact: np.ndarray  # (n,) bool, the hands' labels touch
    swapped: np.ndarray  # (n,) bool, each hand is at the other's place


def shots(scene: Scene):
    """(image, labels) of each frame of a scene, in white light and without noise."""
    stage = studio(scene.body, scene.place)
    stage.dress(scene.look)
    rng = np.random.default_rng((scene.seed, 5))
    for q in joint_positions(scene.paths, stage.body, rng):
        yield stage.shoot(q)


def expose(scene: Scene, pictures, light: np.ndarray | None = None):
    """The (image, labels) frames that the camera gives of :func:`shots`, under the scene's light program or another (n, 2)."""
    camera = ImperfectCamera(Imperfection(noise=1.5), scene.place.width, scene.place.height, scene.seed)
    for k, (image, labels) in enumerate(pictures):
        yield camera.expose(illuminate(image, *(scene.light if light is None else light)[k]), k), labels


def film(scene: Scene):
    """(image, labels) frames of a scene under its own light."""
    return expose(scene, shots(scene))


def judge(scene: Scene, frames, options: SkinOptions = SkinOptions()) -> RoomResult:
    """Follow the frames of a scene and compare with the labels."""
    belief, tracks, truth, contact = PeopleBelief(), [], [], []
    for k, (image, labels) in enumerate(frames):
        belief = see_people(image, k / 25.0, k, belief, options)
        tracks.append(belief.tracks)
        truth.append(tracks_from_labels(labels, k / 25.0, k))
        contact.append(bool((binary_dilation(labels == LEFT, iterations=3) & (labels == RIGHT)).any()))
    a, b = TrackTable.of(tracks), TrackTable.of(truth)
    both = a.seen & b.seen
    error = np.where(both, np.linalg.norm(a.positions - b.positions, axis=2), np.nan)
    crossed = np.linalg.norm(a.positions[:, [2, 1]] - b.positions[:, [1, 2]], axis=2)
    hands = both[:, 1:].all(1)
    with np.errstate(invalid="ignore"):
        swapped = hands & (crossed < FAR).all(1) & (error[:, 1:] > crossed.max(1, keepdims=True)).all(1)
    return RoomResult(scene, error, a.seen, b.seen, np.array(contact), swapped)


def judge_room(seed: int) -> RoomResult:
    """The random scene of a seed, filmed under its own light and followed."""
    scene = random_scene(seed)
    return judge(scene, film(scene))


def summarise(results: list[RoomResult]) -> dict:
    """Figures over many scenes, the first second left out.

    RMS over the frames in which part and truth are seen and the identity is right; ``lost`` is the share of those farther than FAR px;
    ``tracked`` the share of truly seen parts that are reported within FAR px; ``seen_right`` of all frames and parts.
    """
    error = np.concatenate([r.error[BOOTSTRAP:] for r in results])
    seen = np.concatenate([r.seen[BOOTSTRAP:] for r in results])
    true = np.concatenate([r.seen_true[BOOTSTRAP:] for r in results])
    partings = swaps = without = 0
    for r in results:
        n, after = names_after_parting(r)
        partings, swaps = partings + n, swaps + after
        first = np.argmax(r.contact) if r.contact.any() else len(r.contact)
        without += bool(_lasting(r.swapped[BOOTSTRAP:first]).any())
    near = error < FAR
    return {
        "scenes": len(results), "frames": len(error),
        "rms_px": {p: float(np.sqrt(np.nanmean(np.where(near[:, k], error[:, k], np.nan) ** 2))) for k, p in enumerate(PARTS)},
        "rms_all_px": {p: float(np.sqrt(np.nanmean(error[:, k] ** 2))) for k, p in enumerate(PARTS)},
        "lost": float(np.mean(~near[np.isfinite(error)])),
        "tracked": {p: float(near[true[:, k], k].mean()) for k, p in enumerate(PARTS)},
        "seen_right": {p: float((seen[:, k] == true[:, k]).mean()) for k, p in enumerate(PARTS)},
        "scenes_swapped_without_contact": without, "partings": partings, "swapped_after_parting": swaps,
    }  # fmt: skip


def names_after_parting(r: RoomResult) -> tuple[int, int]:
    """How often touching hands parted, and how often their names were exchanged then."""
    n = swaps = 0
    ends = np.flatnonzero(r.contact[:-1] & ~r.contact[1:]) + 1
    for end in ends:
        window = slice(end, end + PARTED)
        before = r.swapped[:end][~r.contact[:end]][-3:]
        if end + PARTED > len(r.contact) or r.contact[window].any() or (len(before) and before.all()):
            continue  # touching again at once, or already exchanged
        n += 1
        swaps += bool(r.swapped[window][-3:].all())
    return n, swaps


def _lasting(flags: np.ndarray, frames: int = 4) -> np.ndarray:
    """Where flags have been set for some frames on end."""
    run = np.convolve(flags.astype(int), np.ones(frames, int))[: len(flags)]
    return run >= frames
