"""Examples of the hand systems for the laws."""

import numpy as np
from pydrake.systems.sensors import ImageLabel16I

from vipr.systems.hands.person_truth import PersonTruth
from vipr.systems.hands.track_points import TrackPoints
from vipr.systems.hands.tracker import HandTracker
from vipr.systems.signals import HandTracks, SkinRegions


def regions_of(parts, time, number, size=(160, 120)):
    """Regions of discs (x, y, radius, faceness) [px], all surely of the person."""
    y, x = np.mgrid[0 : size[1], 0 : size[0]]
    labels = np.zeros((size[1], size[0]), np.uint8)
    rows = []
    for k, (cx, cy, radius, faceness) in enumerate(parts):
        disc = (x - cx) ** 2 + (y - cy) ** 2 <= radius**2
        labels[disc] = k + 1
        rows.append((cx, cy, disc.sum(), cx - radius, cy - radius, 2 * radius + 1, 2 * radius + 1, faceness))
    table = np.array(rows, float).reshape(-1, 8)
    return SkinRegions(
        centres=table[:, :2].copy(),
        areas=table[:, 2].copy(),
        boxes=table[:, 3:7].copy(),
        person=np.ones(len(table)),
        faceness=table[:, 7].copy(),
        cores=np.column_stack([table[:, :2], table[:, 5] / 2]),
        labels=labels,
        moving=np.zeros(len(table)),
        motion=np.zeros_like(labels),
        scale=1.0,
        size=size,
        cut=False,
        time=time,
        number=number,
    )


def tracker():
    system = HandTracker(offset=0.002)

    def fix(context, t):
        parts = [(80, 30, 9, 0.6), (40 + 100 * t, 80, 5, 0.0), (120, 90, 5, 0.0)]
        system.GetInputPort("regions").FixValue(context, regions_of(parts, t, round(t / 0.04)))

    return system, fix


def truth():
    system = PersonTruth()

    def fix(context, t):
        image = ImageLabel16I(32, 24)
        image.mutable_data[:] = 20
        image.mutable_data[3:9, 10 + int(20 * t) : 16 + int(20 * t)] = 2
        system.GetInputPort("label_image").FixValue(context, image)

    return system, fix


def points():
    system = TrackPoints()

    def fix(context, t):
        tracks = HandTracks(
            face=np.array([80.0, 30.0]), right=np.array([40.0 + t, 80.0]), face_seen=True, right_seen=t > 0.1
        )
        system.GetInputPort("hand_tracks").FixValue(context, tracks)

    return system, fix


EXAMPLES = {HandTracker: tracker, PersonTruth: truth, TrackPoints: points}
