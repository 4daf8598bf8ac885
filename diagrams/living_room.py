"""A person in a living room before the gesture camera."""

from dataclasses import dataclass

import numpy as np
from pydrake.geometry import (
    ClippingRange,
    ColorRenderCamera,
    DepthRange,
    DepthRenderCamera,
    GeometryInstance,
    LightParameter,
    MakeRenderEngineVtk,
    Mesh,
    PerceptionProperties,
    RenderCameraCore,
    RenderEngineVtkParams,
    RenderLabel,
    Rgba,
    Role,
    SceneGraph,
)
from pydrake.math import RigidTransform, RotationMatrix
from pydrake.multibody.parsing import Parser
from pydrake.multibody.plant import MultibodyPlant
from pydrake.systems.framework import Diagram, DiagramBuilder
from pydrake.systems.rendering import MultibodyPositionToGeometryPose
from pydrake.systems.sensors import CameraInfo, RgbdSensor

from vipr.models import model_path
from vipr.systems.camera.imperfections import ImperfectCamera
from vipr.systems.camera.room_light import RoomLight
from vipr.systems.hands.label_truth import FACE, LEFT, RIGHT
from vipr.systems.hands.person_truth import PersonTruth

SKIN_TONES = {  # linear RGB of diffuse reflectance, from light to dark
    "porcelain": (0.84, 0.62, 0.50),
    "fair": (0.78, 0.54, 0.42),
    "olive": (0.66, 0.45, 0.32),
    "brown": (0.47, 0.30, 0.20),
    "dark": (0.28, 0.175, 0.12),
}
ROOM_LABEL = 20


@dataclass(frozen=True)
class Look:
    """Clothes, skin and decor: all that can change without building the diagram again."""

    skin: str = "fair"  # of SKIN_TONES
    sleeves: str = "long"  # long | short (bare from the elbow on)
    shirt: tuple[float, float, float] = (0.16, 0.25, 0.42)
    hair: tuple[float, float, float] = (0.13, 0.09, 0.06)
    decor: str = "plain"  # plain | wallpaper | beige | wood


@dataclass(frozen=True)
class CameraPlace:
    """Where the gesture camera stands; it looks level along -x of the world, at the person."""

    width: int = 160  # px
    height: int = 120  # px
    distance: float = 2.1  # m from the person
    level: float = 1.25  # m above the floor
    field_of_view: float = np.deg2rad(47.0)  # rad, horizontal


class LivingRoom(Diagram):
    """A person, driven by joint positions, in a room with a changing light, seen by the gesture camera; truth beside the frame.

    .. pydrake_system::

        name: LivingRoom
        input_ports:
        - person_positions
        - light
        output_ports:
        - frame
        - hand_tracks_true
        - color_image
        - label_image

    World W: the floor below the person, x towards the camera, y to the person's left, z up. ``person_positions`` in the order of
    ``vipr.models.person.generate.JOINTS`` (m, rad); ``light`` is (intensity, colour temperature [K]). ``frame`` and ``hand_tracks_true``
    are sampled together every ``period`` s from t = 0, the frame with what the camera's ``electronics`` add (nothing if not given);
    ``color_image`` and ``label_image`` are rendered when asked for::

        person_positions -> poses -> scene_graph -> camera -> room_light -> frame
                                                          `-> truth -> hand_tracks_true
    """

    def __init__(
        self,
        body: str = "medium",
        look: Look | None = None,
        place: CameraPlace | None = None,
        period: float = 0.04,
        electronics: ImperfectCamera | None = None,
    ):
        super().__init__()
        look, place = look or Look(), place or CameraPlace()
        builder = DiagramBuilder()
        scene_graph = builder.AddNamedSystem("scene_graph", SceneGraph())
        scene_graph.AddRenderer(
            "room", MakeRenderEngineVtk(RenderEngineVtkParams(lights=_lights(), cast_shadows=False))
        )
        person = MultibodyPlant(time_step=0.0)
        person.RegisterAsSourceForSceneGraph(scene_graph)
        Parser(person).AddModels(str(model_path(f"person/person_{body}.urdf")))
        person.Finalize()
        self._source = person.get_source_id()
        self._parts = self._find_parts(person, scene_graph)
        room = GeometryInstance(RigidTransform(), Mesh(str(model_path("living_room/room.obj"))), "room")
        room_source = scene_graph.RegisterSource("room")
        self._room = (room_source, scene_graph.RegisterAnchoredGeometry(room_source, room))
        for source, geometry, properties in self._properties(look):
            if geometry != self._room[1]:
                scene_graph.RemoveRole(source, geometry, Role.kPerception)
            scene_graph.AssignRole(source, geometry, properties)

        poses = builder.AddNamedSystem("poses", MultibodyPositionToGeometryPose(person))
        camera = builder.AddNamedSystem("camera", _camera(scene_graph, place))
        light = builder.AddNamedSystem("room_light", RoomLight(period, electronics=electronics))
        truth = builder.AddNamedSystem("truth", PersonTruth(period))
        builder.ExportInput(poses.get_input_port(), "person_positions")
        builder.ExportInput(light.GetInputPort("light"), "light")
        builder.Connect(poses.get_output_port(), scene_graph.get_source_pose_port(self._source))
        builder.Connect(scene_graph.get_query_output_port(), camera.query_object_input_port())
        builder.Connect(camera.color_image_output_port(), light.GetInputPort("color_image"))
        builder.Connect(camera.label_image_output_port(), truth.GetInputPort("label_image"))
        builder.ExportOutput(light.GetOutputPort("frame"), "frame")
        builder.ExportOutput(truth.GetOutputPort("hand_tracks_true"), "hand_tracks_true")
        builder.ExportOutput(camera.color_image_output_port(), "color_image")
        builder.ExportOutput(camera.label_image_output_port(), "label_image")
        builder.BuildInto(self)
        self._person = person  # keeps the plant alive; it holds no state

    def dress(self, context, look: Look) -> None:
        """Give the person and the room of this context another look, without building anything."""
        scene_graph = self.GetSubsystemByName("scene_graph")
        inner = scene_graph.GetMyMutableContextFromRoot(context)
        for source, geometry, properties in self._properties(look):
            scene_graph.RemoveRole(inner, source, geometry, Role.kPerception)
            scene_graph.AssignRole(inner, source, geometry, properties)

    def _find_parts(self, person, scene_graph):
        inspector = scene_graph.model_inspector()
        parts = {}
        for geometry in inspector.GetAllGeometryIds(Role.kPerception):
            parts[inspector.GetName(geometry).split("::")[-1]] = geometry
        return parts

    def _properties(self, look: Look):
        """(source, geometry, properties) of every part for this look."""
        skin = SKIN_TONES[look.skin]
        trousers = (0.12, 0.13, 0.16)
        forearm = skin if look.sleeves == "short" else look.shirt
        table = {
            "face": (FACE, skin, "person/face.png"), "neck": (10, skin, None), "hair": (11, look.hair, None),
            "shirt": (12, look.shirt, None), "trousers": (13, trousers, None),
            "left_upper_arm": (14, look.shirt, None), "right_upper_arm": (15, look.shirt, None),
            "left_forearm": (16, forearm, None), "right_forearm": (17, forearm, None),
            "left_hand": (LEFT, skin, None), "right_hand": (RIGHT, skin, None),
        }  # fmt: skip
        for name, (label, colour, texture) in table.items():
            yield self._source, self._parts[name], _material(label, colour, texture)
        yield *self._room, _material(ROOM_LABEL, (1, 1, 1), f"living_room/{look.decor}.png")


def random_look(rng: np.random.Generator, decors=("plain", "wallpaper", "beige", "wood")) -> Look:
    """Another person in other clothes (never of skin's own colour) in another room."""
    shirt = np.clip(rng.uniform(0.05, 0.7) * rng.dirichlet((3, 3, 4)) * 3, 0.02, 0.85)
    if 1.1 < shirt[0] / shirt[1] < 2.6 and shirt[2] < 1.1 * shirt[1]:
        shirt = shirt[::-1]
    hair = tuple(rng.uniform(0.03, 0.45) * np.array((1.0, 0.72, 0.45)))
    return Look(
        str(rng.choice(list(SKIN_TONES))),
        str(rng.choice(["long", "short"])),
        tuple(shirt),
        hair,
        str(rng.choice(list(decors))),
    )


def _material(label: int, colour, texture: str | None) -> PerceptionProperties:
    properties = PerceptionProperties()
    properties.AddProperty("phong", "diffuse", Rgba(*colour, 1.0))
    if texture:
        properties.AddProperty("phong", "diffuse_map", str(model_path(texture)))
    properties.AddProperty("label", "id", RenderLabel(label))
    return properties


def _lights():
    """A ceiling light before the person, a weaker window at the side and the floor's reflection, fixed in the world."""
    return [
        LightParameter(type="directional", frame="world", direction=[-0.75, -0.2, -0.62], intensity=0.65),
        LightParameter(type="directional", frame="world", direction=[-0.6, 0.75, -0.05], intensity=0.3),
        LightParameter(type="directional", frame="world", direction=[-0.7, 0.0, 0.7], intensity=0.22),
    ]


def _camera(scene_graph, place: CameraPlace) -> RgbdSensor:
    info = CameraInfo(place.width, place.height, _vertical(place))
    core = RenderCameraCore("room", info, ClippingRange(0.1, 10.0), RigidTransform())
    color, depth = ColorRenderCamera(core, show_window=False), DepthRenderCamera(core, DepthRange(0.1, 9.9))
    X_WC = RigidTransform(
        RotationMatrix(np.array([[0, 0, -1.0], [1, 0, 0], [0, -1, 0]])), [place.distance, 0, place.level]
    )
    return RgbdSensor(scene_graph.world_frame_id(), X_WC, color, depth)


def _vertical(place: CameraPlace) -> float:
    focal = 0.5 * place.width / np.tan(0.5 * place.field_of_view)
    return float(2 * np.arctan(0.5 * place.height / focal))
