"""Examples of the living room and of the robot that watches it, for the laws."""

import numpy as np

from vipr.diagrams.gesture_robot import GestureRobot
from vipr.diagrams.living_room import CameraPlace, LivingRoom
from vipr.diagrams.seeing_people import SeeingPeople
from vipr.models import model_path
from vipr.systems.camera.imperfections import ImperfectCamera, Imperfection
from vipr.systems.gestures.model_file import load_model
from vipr.systems.signals import CameraFrame


def living_room():
    system = LivingRoom("small", place=CameraPlace(width=64, height=48))

    def fix(context, t):
        system.GetInputPort("person_positions").FixValue(context, [0.0] * 5 + [0.0, -t, 0.0, -t, 0.0] * 2)
        system.GetInputPort("light").FixValue(context, [1.0 - t, 4000.0])

    return system, fix


def gesture_robot():
    place = CameraPlace(width=64, height=48)
    room = LivingRoom("small", place=place, electronics=ImperfectCamera(Imperfection(noise=2.0), 64, 48, 3))
    system = GestureRobot(room, load_model(model_path("gestures/instructions.npz")), ("stop", "come"))

    def fix(context, t):
        system.GetInputPort("person_positions").FixValue(context, [0.0] * 5 + [0.0, -t, 0.0, -t, 0.0] * 2)
        system.GetInputPort("light").FixValue(context, [1.0, 5000.0])

    return system, fix


def seeing_people():
    y, x = np.mgrid[0:60, 0:80]

    def fix(context, t):
        image = np.full((60, 80, 3), (150, 140, 130), np.uint8)
        image[(x - 40) ** 2 + (y - 18 - 20 * t) ** 2 < 64] = (120, 150, 200)
        system.GetInputPort("frame").FixValue(context, CameraFrame(image, t, round(t / 0.04)))

    system = SeeingPeople()
    return system, fix


EXAMPLES = {LivingRoom: living_room, SeeingPeople: seeing_people, GestureRobot: gesture_robot}
