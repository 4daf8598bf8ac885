"""The robot's own language on trial: trained on some people, tested on others, and on hands that mean nothing (paper, II-A.4)."""

from dataclasses import dataclass

import numpy as np

from vipr.scenarios.experiments.films import RATE, Reel, Sitting
from vipr.scenarios.experiments.instructions import GARBAGE, LANGUAGE, Person, perform_all
from vipr.scenarios.people.motion import greeting
from vipr.systems.gestures.body import BodyBelief, direction, seen_from_face, told_apart
from vipr.systems.gestures.classifier import GestureClassifier
from vipr.systems.gestures.segmentation import MotionBelief, PauseSettings, advance
from vipr.systems.gestures.trajectories import Trajectory
from vipr.systems.gestures.ways import ways

TRAINING = (6, 500, 240)  # people, gestures, non-gestures
SITTING = 25  # films, at most
REST = 6  # frames of it that a film begins with, so that movements are cut out of it as out of a stream
# By likelihood, which has little to find where idle hands and ways have models of their own, and is lower for strangers' gestures
FALSE_REJECTION = 1e-4
TEST = (4, 320, 240)  # as in the paper: 320 sequences of four people who were not in training


def sittings(test: bool, seed: int, camera: str, share: float = 1.0) -> list[Sitting]:
    """What the people are to do, each in several sittings; the first ``share`` of each person's sittings.

    A sitting begins with a greeting, which is no instruction either.
    """
    people, gestures, others = TEST if test else TRAINING
    group, planned = "test" if test else "training", []
    for n in range(people):
        rng = np.random.default_rng([seed, int(test), n])
        count = gestures * (n + 1) // people - gestures * n // people
        wanted = [list(LANGUAGE)[k % len(LANGUAGE)] for k in range(count)] + [GARBAGE] * (others // people)
        number = 1000 * seed + 100 * test + n
        parts = np.array_split(rng.permutation(wanted), -(-len(wanted) // SITTING))
        for part, names in enumerate(parts[: max(1, round(share * len(parts)))]):
            paths, bounds, targets = perform_all(
                Person.drawn(number), names.tolist(), np.random.default_rng([number, part])
            )
            name, person = f"instructions-{camera}-{seed}-{group}-{n}-{part}", f"{group} person {n + 1}"
            paths, labels = [greeting(), *paths], [GARBAGE, *names.tolist()]
            bounds = [(first + REST, last + REST) for first, last in [(0, len(paths[0]) - 1), *bounds]]
            targets = np.vstack([np.full((1, 2), np.nan), targets])
            planned.append(Sitting(name, person, paths, labels, bounds, camera, number, targets, REST, greets=False))
    return sorted(planned, key=lambda s: int(s.name.rsplit("-", 1)[1]))


@dataclass(frozen=True, eq=False)
class Movements:
    """Movements cut out of the films, one row each."""

    trajectories: list[Trajectory]
    film: np.ndarray  # (M,) which film each is from
    delay: np.ndarray  # (M,) s from the true end of the film's gesture to the frame after which the movement was cut
    main: np.ndarray  # (M,) bool: of a film's movements the one that overlaps the gesture most


def cut(reels: list[Reel], settings: PauseSettings | None = None) -> Movements:
    """Movements as the recogniser cuts them, film by film; films are numbered through."""
    settings = settings or PauseSettings()
    trajectories, film, delay, main, number = [], [], [], [], 0
    for r in reels:
        body = BodyBelief()
        for k in range(len(r.labels)):
            motion, found = MotionBelief(), []
            for tracks in r.tracks(k):
                body, point = seen_from_face(body, tracks)
                if point is None:
                    continue
                motion, movement = advance(motion, tracks.time, point, settings)
                if movement is not None:
                    found.append((told_apart(movement), tracks.time))
            first, last = r.bounds[k] / RATE
            overlap = [min(last, m.times[-1]) - max(first, m.times[0]) for m, _ in found]
            for n, (m, named) in enumerate(found):
                trajectories.append(m)
                film.append(number)
                delay.append(named - last)
                main.append(n == int(np.argmax(overlap)) and overlap[n] > 0)
            number += 1
    return Movements(trajectories, np.array(film, int), np.array(delay), np.array(main, bool))


def train_language(reels: list[Reel], seed: int = 0, updates: int = 500, tick=lambda share: None) -> GestureClassifier:
    """A classifier of the language; every movement of a non-gesture film teaches what to reject, and as many ways as there are gestures."""
    movements, labels = cut(reels), np.concatenate([r.labels for r in reels])
    label = labels[movements.film]
    person = np.concatenate([np.repeat(r.person, len(r.labels)) for r in reels])[movements.film]
    meant = movements.main & (label != GARBAGE)
    gestures = [t for t, m in zip(movements.trajectories, meant, strict=True) if m]
    others = [t for t, g in zip(movements.trajectories, label == GARBAGE, strict=True) if g]
    others += ways(gestures, person[meant], len(gestures), np.random.default_rng([seed, 5]))
    classifier = GestureClassifier(
        "placed", garbage=GARBAGE, false_rejection=FALSE_REJECTION, distortion=0.7, backwards=0.0, timed=True,
        updates=updates, seed=seed,
    )  # fmt: skip
    return classifier.fit(gestures + others, np.r_[label[meant], np.repeat(GARBAGE, len(others))], tick=tick)


@dataclass
class Trial:
    """Outcome, film by film."""

    truth: np.ndarray  # (N,) made
    answer: np.ndarray  # (N,) name given to the main movement; "missed" where none was cut
    rejected: np.ndarray  # (N,) bool, of the main movement
    accepted: np.ndarray  # (N,) int: movements of the film that were accepted as gestures
    margin: np.ndarray  # (N,) of the main movement; of non-gestures the largest of all movements
    delay: np.ndarray  # (N,) s from the end of the gesture to its name; NaN where none was cut and of non-gestures
    angle: np.ndarray  # (N,) rad between the direction given and the one meant; NaN where none


def try_language(classifier: GestureClassifier, reels: list[Reel]) -> Trial:
    """Recognise all films."""
    movements = cut(reels)
    truth = np.concatenate([r.labels for r in reels])
    targets = np.concatenate([r.targets for r in reels])
    N = len(truth)
    answer, rejected = np.full(N, "missed", object), np.ones(N, bool)
    accepted, margin = np.zeros(N, int), np.full(N, -np.inf)
    angle, delay = np.full(N, np.nan), np.full(N, np.nan)
    label, _, refused = classifier.recognise(movements.trajectories)
    margins = classifier.margins(movements.trajectories)
    for m, k in enumerate(movements.film):
        accepted[k] += not refused[m]
        if truth[k] == GARBAGE:
            margin[k] = max(margin[k], margins[m])
        if movements.main[m]:
            answer[k], rejected[k] = label[m], refused[m]
            if truth[k] != GARBAGE:
                margin[k], delay[k] = margins[m], movements.delay[m]
            given = direction(movements.trajectories[m].points)
            angle[k] = np.arccos(np.clip(given @ targets[k], -1.0, 1.0)) if np.isfinite(targets[k]).all() else np.nan
    return Trial(truth, answer, rejected, accepted, margin, delay, angle)


def rates(trial: Trial, threshold: float | None = None) -> dict:
    """Percentages: gestures named right (a rejected one counts as wrong), named before rejection, rejected; non-gestures accepted."""
    gesture = trial.truth != GARBAGE
    rejected = trial.rejected if threshold is None else ~(trial.margin >= threshold)
    right = trial.answer == trial.truth
    accepted = trial.accepted > 0 if threshold is None else trial.margin >= threshold
    return {
        "recognised_percent": 100.0 * float((right & ~rejected)[gesture].mean()),
        "named_right_percent": 100.0 * float(right[gesture].mean()),
        "rejected_percent": 100.0 * float(rejected[gesture].mean()),
        "false_acceptance_percent": 100.0 * float(accepted[~gesture].mean()) if (~gesture).any() else float("nan"),
    }


def curve(trial: Trial) -> tuple[np.ndarray, np.ndarray]:
    """False rejection and false acceptance in percent over all thresholds."""
    thresholds = np.r_[-np.inf, np.sort(trial.margin[np.isfinite(trial.margin)]), np.inf]
    values = [rates(trial, t) for t in thresholds]
    return np.array([v["rejected_percent"] for v in values]), np.array([v["false_acceptance_percent"] for v in values])
