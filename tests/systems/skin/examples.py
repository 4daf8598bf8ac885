"""Examples of the skin systems for the laws."""

import numpy as np

from vipr.systems.signals import CameraFrame, HandTracks
from vipr.systems.skin.segmenter import SkinSegmenter


def blobs(t, size=(48, 64)):
    """A grey room with a still face and a moving hand of skin colour."""
    image = np.full((*size, 3), (150, 145, 140), np.uint8)
    image[6:18, 26:36] = (110, 140, 200)
    x = 8 + int(60 * t)
    image[28:35, x : x + 6] = (110, 140, 200)
    return image


def segmenter():
    system = SkinSegmenter(offset=0.001)

    def fix(context, t):
        frame = CameraFrame(image=blobs(t), time=t, number=round(t / 0.04))
        system.GetInputPort("frame").FixValue(context, frame)
        system.GetInputPort("hand_tracks").FixValue(context, HandTracks())

    return system, fix


EXAMPLES = {SkinSegmenter: segmenter}
