"""Examples of the tracking systems for the laws."""

import numpy as np
from drawn_objects import LENS, box, picture, pose_at

from vipr.systems.signals import CameraFrame, ObjectPose, Occluders
from vipr.systems.tracking.annotator import PoseAnnotator
from vipr.systems.tracking.tracker import ModelTracker


def tracker():
    model = box()
    system = ModelTracker(model, LENS, X_CO_initial=pose_at(0.0))

    def fix(context, t):
        number = round(t / 0.04)
        image = picture(model, pose_at(t)) if number != 2 else np.zeros((0, 0), np.uint8)
        system.GetInputPort("frame").FixValue(context, CameraFrame(image, t, number))
        system.GetInputPort("initial_pose").FixValue(context, ObjectPose())
        system.GetInputPort("occluders").FixValue(context, Occluders())

    return system, fix


def annotator():
    model = box()
    system = PoseAnnotator(model, LENS)

    def fix(context, t):
        frame = CameraFrame(np.dstack([picture(model, pose_at(t))] * 3), t, round(t / 0.04))
        system.GetInputPort("frame").FixValue(context, frame)
        system.GetInputPort("object_pose").FixValue(context, ObjectPose(X_CO=pose_at(t), state="tracking", time=t))

    return system, fix


EXAMPLES = {ModelTracker: tracker, PoseAnnotator: annotator}
