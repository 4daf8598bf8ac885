"""An example of the recogniser for the laws: a classifier of two strokes, a hand that makes them in turn."""

from functools import lru_cache

import numpy as np

from vipr.systems.gestures.announcer import GestureAnnouncer
from vipr.systems.gestures.classifier import GestureClassifier
from vipr.systems.gestures.recogniser import GestureRecogniser
from vipr.systems.signals import CameraFrame, Gesture, HandTracks, SkinRegions


def stroke(name, n=14):
    """(n, 4) movement in faces: the right hand goes up or out."""
    way = np.array({"up": [0.0, 3.0], "out": [-3.0, 0.2]}[name])
    u = 0.5 - 0.5 * np.cos(np.pi * np.linspace(0.0, 1.0, n))
    return np.column_stack([np.tile([2.2, -5.2], (n, 1)), [-1.8, -3.0] + u[:, None] * way])


@lru_cache(maxsize=1)
def two_strokes():
    """Trained on slightly different copies."""
    rng = np.random.default_rng(0)
    X = [stroke(name, n) + 0.03 * rng.normal(size=(n, 4)) for name in ("up", "out") for n in (12, 14, 16, 18)]
    return GestureClassifier("placed", updates=20, backwards=0.0).fit(X, ["up"] * 4 + ["out"] * 4)


def tracks_at(time, cycle=1.6):
    """Up, pause, out, pause, ...: the hand jumps back to its place while nobody looks."""
    turn, phase = divmod(time, cycle)
    name = ("up", "out")[int(turn) % 2]
    p = stroke(name, 15)[int(np.clip(round((phase - 0.5) / 0.04), 0, 14))]

    def px(q):
        return np.array([80.0 + 13.0 * q[0], 30.0 - 13.0 * q[1]])

    return HandTracks(
        face=np.array([80.0, 30.0]), left=px(p[:2]), right=px(p[2:]), face_seen=True, left_seen=True, right_seen=True,
        areas=np.array([169.0, 80.0, 80.0]), size=(160, 120), time=time, number=round(time / 0.04),
    )  # fmt: skip


def recogniser():
    system = GestureRecogniser(two_strokes(), pointing=("out",), offset=0.003)

    def fix(context, t):
        system.GetInputPort("hand_tracks").FixValue(context, tracks_at(t))

    return system, fix


def gesture_at(time):
    """Nothing yet, then "out" at 0.1 s."""
    if time < 0.1:
        return Gesture()
    direction = np.array([-1.0, 0.0])
    return Gesture("out", 0.9, False, start=0.02, end=0.06, named=0.1, direction=direction, number=3)


def announcer():
    system = GestureAnnouncer(("up", "out"), zoom=2)

    def fix(context, t):
        frame = CameraFrame(np.full((120, 160, 3), 90, np.uint8), t, round(t / 0.04))
        for name, value in (
            ("frame", frame),
            ("regions", SkinRegions()),
            ("hand_tracks", tracks_at(t)),
            ("gesture", gesture_at(t)),
        ):
            system.GetInputPort(name).FixValue(context, value)

    return system, fix


EXAMPLES = {GestureRecogniser: recogniser, GestureAnnouncer: announcer}
