"""``GestureClassifier``: hidden Markov models of several descriptions of a trajectory, with scikit-learn's conventions.

Each stream describes a trajectory in its own way, as movement or as the picture it leaves, and has one left-right HMM a gesture, more
where a gesture is made in clearly different ways. The models are trained by likelihood (segmental, Baum-Welch), then sharpened against
each other by mutual information; the streams' log posteriors are averaged. If times count, the duration speaks for or against a gesture
as well. Whether something is a gesture at all is asked twice: of the posterior, if there were examples of what is none, and of the
likelihood: is it, per point, far below what held-out examples reached beside a garbage model of all gestures together?
"""

from dataclasses import fields

import numpy as np
from sklearn.base import BaseEstimator, ClassifierMixin
from sklearn.utils.validation import check_is_fitted

from vipr.systems.errors import InputError
from vipr.systems.gestures.gaps import seen_points
from vipr.systems.gestures.rejection import fit_gate, fit_pace
from vipr.systems.gestures.stream_models import StreamOptions, fit_stream
from vipr.systems.gestures.trajectories import Stream, clean, describe, resample

STREAMS = {
    "default": (
        Stream(("position", "direction")),
        Stream(("position", "direction", "turning")),
        Stream(("position", "velocity"), sampling="time"),
        Stream(("rows",)),
        Stream(("columns",)),
    ),
    # The three rows of Table II: image position, image velocity, both; equal steps of time.
    "position": (Stream(("position",), sampling="time", scale="box", smoothing=0),),
    "velocity": (Stream(("velocity",), sampling="time", scale="box", smoothing=0),),
    "combined": (Stream(("position", "velocity"), sampling="time", scale="box", smoothing=0),),
    # Positions that mean something as they are, such as of hands from the face; and the shape, wherever it is made.
    "placed": (
        Stream(("position", "direction"), scale="none"),
        Stream(("position", "velocity"), sampling="time", scale="none"),
        Stream(("position", "direction")),
    ),
}


class GestureClassifier(ClassifierMixin, BaseEstimator):
    """Names trajectories by hidden Markov models.

    X is a list (or object array) of trajectories: arrays (T, d) at equal time steps, or ``Trajectory`` with time stamps; y are labels.
    Where a trajectory is NaN it was not seen, and its models integrate over what it may have been. Trajectories without two different
    finite positions are left out of training and are always rejected.

    streams : a name of ``STREAMS`` or a tuple of ``Stream``
    states : number of states of every model, or "validated": chosen per gesture on held-out examples
    covariance, mixtures : "full", "diag" or "tied"; components a state (likelihood models; sharpening uses one diagonal component)
    allograph_gain : share of scatter that splitting a gesture in two must explain (pictures: a third of it); None: one model a gesture
    discriminative : sharpen the models against each other
    distortion : how much copies are distorted while sharpening, 1 for another writer's hand, 0 for none
    backwards : share of examples taken from end to start while sharpening, of gestures that then look like no other; 0: none
    gaps : share of examples that are not seen for a while while sharpening, for hands that a camera may lose; 0: none
    priors : "observed" (as in training) or "uniform"
    garbage : label of non-gestures in y, if any; they shape the garbage model and the threshold, and ``predict`` may answer with it
    false_rejection : share of held-out gestures that the threshold may reject
    doubt : what is no gesture with this probability is rejected; a wrong answer is worse than none
    timed : times are in seconds; durations count, and what takes far less or more time than the gesture did in training is rejected
    seed : of everything random

    After ``fit``: ``classes_``, ``streams_`` (the models), ``gate_``, ``pace_``, ``skipped_`` (indices left out).
    """

    def __init__(
        self, streams="default", states=8, covariance="diag", mixtures=1, allograph_gain=0.3, discriminative=True, distortion=1.0,
        backwards=0.08, gaps=0.0, priors="observed", garbage=None, false_rejection=0.01, doubt=0.05, timed=False,
        updates=500, seed=0,
    ):  # fmt: skip
        self.streams, self.states, self.covariance, self.mixtures = streams, states, covariance, mixtures
        self.allograph_gain, self.discriminative = allograph_gain, discriminative
        self.distortion, self.backwards, self.gaps = distortion, backwards, gaps
        self.priors, self.garbage, self.false_rejection = priors, garbage, false_rejection
        self.doubt, self.timed, self.updates, self.seed = doubt, timed, updates, seed

    def fit(self, X, y, tick=lambda share: None):
        """Train on trajectories X with labels y. ``tick(share)`` is told what share of the work is done."""
        streams = self._streams()
        options = StreamOptions(**{f.name: getattr(self, f.name) for f in fields(StreamOptions)})
        if self.priors not in ("observed", "uniform") or not 0 <= self.false_rejection < 1 or not 0 < self.doubt <= 1:
            raise InputError(
                "gesture classifier: priors is observed or uniform, false_rejection from 0 to below 1 and doubt above 0 to 1, got "
                f"{self.priors!r}, {self.false_rejection} and {self.doubt}"
            )
        cleaned, kept = self._clean(X)
        y = np.asarray(y)
        if y.ndim != 1 or len(y) != len(cleaned):
            raise InputError(
                f"gesture classifier: one label a trajectory, got {len(cleaned)} trajectories and labels of shape {y.shape}"
            )
        self.skipped_ = np.flatnonzero(~kept)
        if not kept.any():
            raise InputError(
                f"gesture classifier: none of the {len(y)} trajectories has two different finite positions at different times"
            )
        good = [t for t in cleaned if t is not None]
        self.classes_, labels = np.unique(y[kept], return_inverse=True)
        self.dimension_ = _dimension(good)
        self.counts_ = np.bincount(labels)
        self.streams_ = []
        for n, stream in enumerate(streams):
            shares = iter((n + np.linspace(0.1, 1, self.updates)) / len(streams))
            self.streams_.append(fit_stream(stream, good, labels, options, lambda shares=shares: tick(next(shares))))
        foreign = np.flatnonzero(self.classes_ == self.garbage) if self.garbage is not None else np.zeros(0, int)
        self.garbage_ = int(foreign[0]) if len(foreign) else -1
        points = resample(good, streams[0].sampling, streams[0].points)
        self.gate_ = fit_gate(points, streams[0], labels, self.garbage_, self.false_rejection, self.seed)
        self.pace_ = fit_pace(_seconds(good), labels)
        tick(1.0)
        return self

    def predict_log_proba(self, X):
        """(N, C) natural logarithms of ``predict_proba``."""
        return self._judge(X)[0]

    def predict_proba(self, X):
        """(N, C) probability of each class of ``classes_``; the priors for a trajectory that cannot be judged."""
        return np.exp(self.predict_log_proba(X))

    def predict(self, X):
        """(N,) most probable labels. If a garbage label was given, it answers for rejected trajectories too."""
        label, _, rejected = self.recognise(X)
        if self.garbage_ >= 0:
            label[rejected] = self.classes_[self.garbage_]
        return label

    def recognise(self, X):
        """Labels (N,), their probabilities (N,) and whether each is rejected (N,): no gesture, whatever the label says."""
        log_posterior, kept, label, margin = self._judge(X)
        rejected = ~kept | (margin < self.gate_.threshold)
        probability = np.exp(log_posterior[np.arange(len(label)), label])
        probability[~kept] = 0.0
        return self.classes_[label], probability, rejected

    def margins(self, X):
        """(N,) what the gate judges by: log likelihood per point above the garbage model's, of the best gesture.

        -inf if unjudged, in doubt whether it is a gesture, or if its duration is none of that gesture.
        """
        return self._judge(X)[3]

    def _judge(self, X):
        """Log posteriors (N, C), whether each could be judged (N,), the best gesture's number (N,) and its margin (N,)."""
        check_is_fitted(self, "streams_")
        cleaned, kept = self._clean(X)
        prior = np.log(self.counts_ / self.counts_.sum())
        usual = prior if self.priors == "observed" else np.full(len(prior), -np.log(len(prior)))
        log_posterior, margin = np.tile(usual, (len(cleaned), 1)), np.full(len(cleaned), -np.inf)
        good = [t for t in cleaned if t is not None]
        views = self._describe(good) if good else {}
        if views:
            log_posterior[kept] = self._log_posterior(views, prior, _seconds(good))
        named = log_posterior.copy()
        if self.garbage_ >= 0 and len(self.classes_) > 1:
            named[:, self.garbage_] = -np.inf
        label = named.argmax(axis=1)
        if views:
            margin[kept] = self.gate_.margin(views[self._streams()[0]], label[kept])
            if self.timed:
                margin[kept] = np.where(self.pace_.usual(_seconds(good), label[kept]), margin[kept], -np.inf)
        if self.garbage_ >= 0:
            most = np.minimum(np.log(self.doubt), log_posterior.max(axis=1))
            margin[log_posterior[:, self.garbage_] >= most] = -np.inf
        return log_posterior, kept, label, margin

    def _describe(self, good):
        """Observations (N, T, D) of cleaned trajectories for each stream."""
        if _dimension(good) != self.dimension_:
            raise InputError(
                f"gesture classifier: trained on {self.dimension_} coordinates a point, got {_dimension(good)}"
            )
        streams = self._streams()
        views = {k: (resample(good, *k), seen_points(good, *k)) for k in {(s.sampling, s.points) for s in streams}}
        return {s: describe(views[s.sampling, s.points][0], s, views[s.sampling, s.points][1]) for s in streams}

    def _log_posterior(self, views, prior, seconds):
        total = sum(model.log_posterior(views[model.stream], prior) for model in self.streams_) / len(self.streams_)
        if self.timed:
            total += self.pace_.log_density(seconds)
        if self.priors == "uniform":
            total -= prior
        total -= total.max(axis=1, keepdims=True)
        return total - np.log(np.exp(total).sum(axis=1, keepdims=True))

    def _streams(self):
        if isinstance(self.streams, str):
            if self.streams not in STREAMS:
                raise InputError(
                    f"gesture classifier: streams is one of {', '.join(STREAMS)} or a tuple of Stream, got {self.streams!r}"
                )
            return STREAMS[self.streams]
        return tuple(self.streams)

    def _clean(self, X):
        cleaned = [clean(t) for t in X]
        return cleaned, np.array([t is not None for t in cleaned], bool)

    def __sklearn_tags__(self):
        tags = super().__sklearn_tags__()
        tags.input_tags.two_d_array, tags.input_tags.allow_nan, tags.no_validation = False, True, True
        return tags


def _seconds(good):
    """(N,) durations of cleaned trajectories."""
    return np.array([t.times[-1] - t.times[0] for t in good])


def _dimension(good):
    dimensions = {t.points.shape[1] for t in good}
    if len(dimensions) != 1:
        raise InputError(
            f"gesture classifier: all points need the same number of coordinates, got {sorted(dimensions)}"
        )
    return dimensions.pop()
