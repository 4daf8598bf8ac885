"""Example of the living room for the laws."""

from vipr.diagrams.living_room import CameraPlace, LivingRoom


def living_room():
    system = LivingRoom("small", place=CameraPlace(width=64, height=48))

    def fix(context, t):
        system.GetInputPort("person_positions").FixValue(context, [0.0] * 5 + [0.0, -t, 0.0, -t, 0.0] * 2)
        system.GetInputPort("light").FixValue(context, [1.0 - t, 4000.0])

    return system, fix


EXAMPLES = {LivingRoom: living_room}
