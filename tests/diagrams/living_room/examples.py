"""Examples of the living room and of the robot that watches it, for the laws."""

from vipr.diagrams.gesture_robot import GestureRobot
from vipr.diagrams.living_room import CameraPlace, LivingRoom
from vipr.models import model_path
from vipr.systems.camera.imperfections import ImperfectCamera, Imperfection
from vipr.systems.gestures.model_file import load_model


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


EXAMPLES = {LivingRoom: living_room, GestureRobot: gesture_robot}
