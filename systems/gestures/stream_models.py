"""The models of one stream: which there are, on what they are trained, how they are sharpened."""

from dataclasses import astuple, dataclass, replace

import numpy as np

from vipr.systems.errors import InputError
from vipr.systems.gestures.allographs import allographs
from vipr.systems.gestures.discriminative import MmiSpec, SharpBank, from_likelihood, sharpen
from vipr.systems.gestures.gaps import lose, seen_points
from vipr.systems.gestures.hmm import COVARIANCES, HmmBank, score
from vipr.systems.gestures.training import HmmSpec, choose_states, own_score, train
from vipr.systems.gestures.trajectories import Distortion, Stream, describe, distort, fill_up, resample

ENOUGH = 16  # examples of a class; with fewer, distorted copies make up the number
COPIES = 0.75  # share of distorted copies while sharpening
# Of variances; models that are not sharpened on distorted copies must leave room for other hands.
FLOOR, PLAIN_FLOOR = 1e-2, 3e-2
PICTURE_GAIN = 1.0 / 3.0  # pictures have many more coordinates: a split explains less of their scatter
PICTURE_TEMPER = 0.4  # and their log likelihoods are as much larger
CLAIMED = 0.1  # a class whose reversed examples are claimed by others more often than this is not taken backwards


@dataclass(frozen=True, eq=False)
class StreamModel:
    """A stream's trained models; ``classes`` (M,) says of which gesture each is."""

    stream: Stream
    bank: SharpBank | HmmBank
    classes: np.ndarray

    def log_posterior(self, x: np.ndarray, prior: np.ndarray) -> np.ndarray:
        """(N, C) of observations x (N, T, D) of the stream; ``prior`` (C,) are log probabilities, used by likelihood models."""
        if isinstance(self.bank, SharpBank):
            return self.bank.log_posterior(x)
        starts = np.flatnonzero(np.r_[True, np.diff(self.classes) > 0])
        return np.maximum.reduceat(score(self.bank, x), starts, axis=1) + prior


@dataclass(frozen=True)
class StreamOptions:
    """The classifier's parameters that concern one stream."""

    states: int | str
    covariance: str
    mixtures: int
    allograph_gain: float | None
    discriminative: bool
    distortion: float
    backwards: float
    gaps: float
    updates: int
    seed: int

    def __post_init__(self):
        number = isinstance(self.states, (int, np.integer)) and self.states >= 1
        for name, fine, allowed in (
            ("states", number or self.states == "validated", "a number from 1 or validated"),
            ("covariance", self.covariance in COVARIANCES, f"one of {', '.join(COVARIANCES)}"),
            ("mixtures", self.mixtures >= 1, "a number from 1"),
            ("allograph_gain", self.allograph_gain is None or 0 <= self.allograph_gain <= 1, "from 0 to 1, or None"),
            ("distortion", self.distortion >= 0, "not negative"),
            ("backwards", 0 <= self.backwards <= 1, "from 0 to 1"),
            ("gaps", 0 <= self.gaps <= 1, "from 0 to 1"),
            ("updates", self.updates >= 0, "not negative"),
        ):
            if not fine:
                raise InputError(f"gesture classifier: {name} is {allowed}, got {getattr(self, name)!r}")


def fit_stream(stream: Stream, trajectories, labels: np.ndarray, options: StreamOptions, tick) -> StreamModel:
    """Train on cleaned trajectories with labels (N,) in 0..C-1; ``tick()`` is called once an update."""
    points = resample(trajectories, stream.sampling, stream.points)
    seen = seen_points(trajectories, stream.sampling, stream.points)
    how = Distortion(*(options.distortion * v for v in astuple(Distortion())))
    rng = np.random.default_rng([options.seed, 1])
    if options.allograph_gain is None:
        model, classes = labels, np.arange(labels.max() + 1)
    else:
        shape = describe(points, stream if stream.picture else replace(stream, features=("position",)))
        model, classes = allographs(shape, labels, options.allograph_gain * (PICTURE_GAIN if stream.picture else 1.0))
    sharp = options.discriminative and len(classes) > 1 and labels.max() > 0
    if sharp:
        source = fill_up(labels, ENOUGH if options.distortion else 0)
        copies = distort(points[source], stream, rng, how) if len(source) else points[:0]
        points = np.concatenate([points, copies])
        seen, labels, model = (np.concatenate([a, a[source]]) for a in (seen, labels, model))
    x = describe(points, stream, seen)
    lengths = np.full(len(x), x.shape[1])
    spec = HmmSpec(
        8 if options.states == "validated" else options.states, 1 if sharp else options.mixtures,
        "diag" if sharp else options.covariance, floor=FLOOR if sharp else PLAIN_FLOOR, prior=2.0, segmental=6,
        baum_welch=5 if sharp else 20,
    )  # fmt: skip
    states = choose_states(x, lengths, model, spec) if options.states == "validated" else None
    bank = train(x, lengths, model, spec, states)
    if not sharp:
        return StreamModel(stream, bank, classes)
    turned = np.zeros(labels.max() + 1, bool)
    if options.backwards and not stream.picture:
        turned = _unclaimed(bank, x, model, describe(points[:, ::-1], stream, seen[:, ::-1]), labels, classes)
    if turned.any():
        extra = np.flatnonzero(turned[labels])
        number = (np.cumsum(turned) - 1)[labels[extra]] + len(classes)
        bank = train(
            np.concatenate([x, describe(points[extra, ::-1], stream, seen[extra, ::-1])]), np.full(len(x) + len(extra), x.shape[1]),
            np.concatenate([model, number]), spec, None if states is None else np.r_[states, np.full(turned.sum(), spec.states)],
        )  # fmt: skip
        classes = np.concatenate([classes, np.flatnonzero(turned)])
        order = np.argsort(classes, kind="stable")
        bank, classes = bank[order], classes[order]
    temper = MmiSpec.temper * (PICTURE_TEMPER if stream.picture else 1.0)
    mmi = MmiSpec(updates=options.updates, seed=options.seed, temper=temper)

    def draw(chosen, rng):
        p, s = points[chosen], seen[chosen]
        back = turned[labels[chosen]] & (rng.random(len(p)) < options.backwards)
        p[back], s[back] = p[back, ::-1], s[back, ::-1]
        copied = rng.random(len(p)) < COPIES * (options.distortion > 0)
        if copied.any():
            p[copied] = distort(p[copied], stream, rng, how)
        if options.gaps:
            p, s = lose(p, s, rng, options.gaps)
        return describe(p, stream, s)

    return StreamModel(stream, sharpen(from_likelihood(bank, x, classes, mmi.temper), draw, labels, mmi, tick), classes)


def _unclaimed(bank, x, model, backwards, labels, classes):
    """(C,) whether a class's examples taken backwards look like no other gesture.

    Another class claims one if its likelihood there reaches what 95 % of that class's own examples reach.
    """
    own = own_score(bank, x, np.full(len(x), x.shape[1]), model)
    usual = np.array([np.quantile(own[model == m], 0.05) for m in range(len(classes))])
    out = np.zeros(labels.max() + 1, bool)
    for c in range(len(out)):
        members = np.flatnonzero(labels == c)[:200]
        claims = (score(bank, backwards[members], method="viterbi") >= usual) & (classes != c)
        out[c] = claims.any(axis=1).mean() <= CLAIMED
    return out
