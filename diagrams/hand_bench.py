"""A Barrett Hand on a carriage over a level support with one object: where grasps are taught, without an arm."""

from dataclasses import dataclass, field

import numpy as np
from pydrake.geometry import AddContactMaterial, AddRigidHydroelasticProperties, Box, ProximityProperties
from pydrake.math import RigidTransform
from pydrake.multibody.parsing import Parser
from pydrake.multibody.plant import AddMultibodyPlant, CoulombFriction, MultibodyPlant, MultibodyPlantConfig
from pydrake.multibody.tree import PdControllerGains, PrismaticJoint, SpatialInertia
from pydrake.systems.framework import Diagram, DiagramBuilder

from vipr.diagrams.workcell import HAND_COUNT
from vipr.models import model_path
from vipr.systems import se3
from vipr.systems.arm.encoders import JointEncoders
from vipr.systems.hand import transmission
from vipr.systems.hand.driver import HandDriver
from vipr.systems.hand.torque_switch import GRASPING, Drives
from vipr.systems.truth import PoseTruth

CARRIAGE_MASS = 2.0  # kg, of each slide
CARRIAGE_GAINS = PdControllerGains(p=2e5, d=6e3)  # N/m, N s/m: far stiffer than any grasp
SUPPORT_FRICTION = 0.8  # of the stage's plate: what is pushed at the top tips rather than slides


@dataclass(frozen=True, kw_only=True)
class HandBenchConfig:
    """What lies on the bench and how the hand stands over it."""

    object: str = "can"  # a folder of vipr.models
    X_WO: np.ndarray = field(default_factory=lambda: np.eye(4))  # of the object; the support is z = 0
    X_WE: np.ndarray = field(default_factory=lambda: se3.pose(np.diag([1.0, -1.0, -1.0]), [0.0, 0.0, 0.3]))
    motors: np.ndarray = field(default_factory=lambda: np.zeros(4))  # rad, where they start
    drives: Drives = GRASPING
    contact_model: str = "hydroelastic_with_fallback"  # or point
    time_step: float = 0.002  # s


class HandBench(Diagram):
    """The hand, held by three stiff slides, and an object on a support below it.

    .. pydrake_system::

        name: HandBench
        input_ports:
        - motor_command
        - torque_limit
        - carriage_desired_state
        output_ports:
        - joint_state
        - motor_position
        - motor_torque
        - finger_torque
        - clutch
        - X_WO_true
        - X_WE_true
        - contact_results
        - query_object

    Frames: W world, on the support, z up; O object; E the hand's ``grasp`` frame. ``motor_command`` (4) and ``torque_limit`` (4) are the
    hand driver's [rad, N m]. ``carriage_desired_state`` (6) is the shift of the hand from where it started [x, y, z; rates] in W
    [m, m/s]; its orientation stays. ``joint_state`` (16) is the encoders' [q; qdot] of the hand's joints. ``contact_results`` are the
    plant's, ``query_object`` is the scene graph's, for a camera.
    """

    def __init__(self, config: HandBenchConfig):
        super().__init__()
        builder = DiagramBuilder()
        plant, scene_graph = AddMultibodyPlant(
            MultibodyPlantConfig(
                time_step=config.time_step, stiction_tolerance=1e-5, contact_model=config.contact_model
            ),
            builder,
        )
        self.config, self.plant, self.scene_graph = config, plant, scene_graph
        hand, carriage = _add_models(plant, config)
        encoders = builder.AddNamedSystem("hand_encoders", JointEncoders(HAND_COUNT))
        driver = builder.AddNamedSystem("hand_driver", HandDriver(config.drives, initial=config.motors))
        thing, palm = plant.GetBodyByName(config.object), plant.GetBodyByName("palm", hand)
        X_PE = plant.GetFrameByName("grasp", hand).GetFixedPoseInBodyFrame().GetAsMatrix4()
        truth = builder.AddNamedSystem("truth", PoseTruth(thing.index(), palm.index(), X_PE, np.eye(4)))
        for writer, reader in (
            (plant.get_state_output_port(hand), encoders.GetInputPort("state")),
            (encoders.GetOutputPort("joint_state"), driver.GetInputPort("hand_state")),
            (plant.get_net_actuation_output_port(hand), driver.GetInputPort("joint_torque")),
            (driver.GetOutputPort("desired_state"), plant.get_desired_state_input_port(hand)),
            (plant.get_body_poses_output_port(), truth.GetInputPort("body_poses")),
        ):
            builder.Connect(writer, reader)
        for name in ("motor_command", "torque_limit"):
            builder.ExportInput(driver.GetInputPort(name), name)
        builder.ExportInput(plant.get_desired_state_input_port(carriage), "carriage_desired_state")
        for system, names in (
            (encoders, ("joint_state",)),
            (driver, ("motor_position", "motor_torque", "finger_torque", "clutch")),
            (truth, ("X_WO_true", "X_WE_true")),
        ):
            for name in names:
                builder.ExportOutput(system.GetOutputPort(name), name)
        builder.ExportOutput(plant.get_contact_results_output_port(), "contact_results")
        builder.ExportOutput(scene_graph.get_query_output_port(), "query_object")
        builder.BuildInto(self)
        self.set_name("hand_bench")


def _add_models(plant: MultibodyPlant, config: HandBenchConfig):
    """The support, the object and the hand on its slides; finalized. Returns the instances of hand and slides."""
    parser = Parser(plant)
    parser.package_map().AddPackageXml(str(model_path("package.xml")))
    parser.AddModels(url=f"package://vipr/{config.object}/{config.object}.sdf")
    (hand,) = parser.AddModels(url="package://vipr/barrett_hand/barrett_hand.sdf")
    _add_support(plant)
    carriage = plant.AddModelInstance("carriage")
    below = plant.world_frame()
    for name, axis in (("x", [1, 0, 0]), ("y", [0, 1, 0]), ("z", [0, 0, 1])):
        slide = plant.AddRigidBody(f"slide_{name}", carriage, SpatialInertia.SolidSphereWithMass(CARRIAGE_MASS, 0.05))
        joint = plant.AddJoint(PrismaticJoint(f"slide_{name}", below, slide.body_frame(), axis))
        plant.AddJointActuator(f"slide_{name}", joint, 1e4).set_controller_gains(CARRIAGE_GAINS)
        below = slide.body_frame()
    X_EP = plant.GetFrameByName("grasp", hand).GetFixedPoseInBodyFrame().inverse()
    palm = plant.GetFrameByName("palm", hand)
    plant.WeldFrames(below, palm, RigidTransform(config.X_WE) @ X_EP)
    angles = transmission.joint_angles(transmission.check_command(config.motors), transmission.SEATED)
    for name, angle in zip(transmission.JOINTS, angles, strict=True):
        plant.GetJointByName(name, hand).set_default_angle(angle)
    plant.SetDefaultFloatingBaseBodyPose(plant.GetBodyByName(config.object), RigidTransform(config.X_WO))
    plant.Finalize()
    return hand, carriage


def _add_support(plant: MultibodyPlant) -> None:
    """A slab with its top at z = 0."""
    properties = ProximityProperties()
    AddRigidHydroelasticProperties(1.0, properties)
    AddContactMaterial(friction=CoulombFriction(SUPPORT_FRICTION, SUPPORT_FRICTION), properties=properties)
    X_WS, slab = RigidTransform([0.0, 0.0, -0.015]), Box(0.8, 0.8, 0.03)
    plant.RegisterCollisionGeometry(plant.world_body(), X_WS, slab, "support", properties)
    plant.RegisterVisualGeometry(plant.world_body(), X_WS, slab, "support", np.array([0.56, 0.44, 0.32, 1.0]))
