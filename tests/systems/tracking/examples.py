"""Examples of the tracking systems for the laws."""

from dataclasses import replace

import numpy as np
from drawn_objects import LENS, box, picture, pose_at
from pydrake.common.value import Value
from pydrake.math import RigidTransform

from vipr.systems.signals import CameraFrame, ObjectPose, Occluders
from vipr.systems.tracking.annotator import PoseAnnotator
from vipr.systems.tracking.geometric_sight import GeometricSight, SightErrors
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


def geometric_sight():
    believed = replace(LENS, fx=1.1 * LENS.fx, fy=1.1 * LENS.fy)
    system = GeometricSight(box().corners, SightErrors(1e-3, 1e-4, 1e-3), lens=LENS, believed=believed, seed=3)

    def fix(context, t):
        for name, ahead in (("X_CO_true", 0.0), ("X_CE_true", 0.1)):
            system.GetInputPort(name).FixValue(context, Value(RigidTransform(pose_at(t + ahead))))

    return system, fix


EXAMPLES = {GeometricSight: geometric_sight, ModelTracker: tracker, PoseAnnotator: annotator}
