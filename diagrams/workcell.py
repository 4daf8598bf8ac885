"""The workcell of the paper's section III-C: a Puma 560 with a Barrett Hand, a table, an object on a motorised stage, one fixed camera."""

from dataclasses import dataclass, field

import numpy as np
from pydrake.math import RigidTransform, RollPitchYaw
from pydrake.multibody.parsing import Parser
from pydrake.multibody.plant import AddMultibodyPlant, MultibodyPlant, MultibodyPlantConfig
from pydrake.multibody.tree import ModelInstanceIndex, PdControllerGains, SpatialInertia
from pydrake.systems.controllers import InverseDynamics
from pydrake.systems.framework import Diagram, DiagramBuilder

from vipr.diagrams.workcell_layout import JOINT_LIMITS, collision_guard, fixed_camera, puma_with_hand, standing
from vipr.models import model_path, object_names
from vipr.systems import se3
from vipr.systems.arm import puma560
from vipr.systems.arm.encoders import JointEncoders
from vipr.systems.arm.set_points import SetPointInterpolator
from vipr.systems.arm.shapes import Shape, box
from vipr.systems.camera.camera import Camera
from vipr.systems.camera.imperfections import Imperfection
from vipr.systems.camera.lens import Lens, load_lens
from vipr.systems.camera.offscreen import add_renderer, colour_sensor, daylight
from vipr.systems.grasping.payload import HAND_CENTRE, HAND_MASS
from vipr.systems.hand.driver import HandDriver
from vipr.systems.hand.finger import GRASP_HEIGHT
from vipr.systems.hand.torque_switch import GRASPING, Drives
from vipr.systems.tracking.cad_model import load_model
from vipr.systems.truth import PoseTruth

RENDERER = "vtk"

# Joint servo: stiff in the first three joints; damping against the inertia of rotor and links (N m/rad, N m s/rad).
STIFFNESS = np.array([4000.0, 4000.0, 3000.0, 400.0, 400.0, 400.0])
DAMPING = 1.8 * np.sqrt(STIFFNESS * np.maximum(0.3, puma560.REFLECTED_INERTIA))
SET_POINTS = 0.01  # s, their period, which the joint servo is made for
ARM_COUNT = 2 * np.pi / (1000 * np.abs(puma560.GEAR_RATIO))  # rad, encoders of 1000 counts a motor turn
HAND_COUNT = 2 * np.pi / (360 * np.array([17.5, 125, 375, 17.5, 125, 375, 125, 375]))  # rad, 360 counts a motor turn


@dataclass(frozen=True, kw_only=True)
class WorkcellConfig:
    """What stands in the workcell and where."""

    object: str = "milk_carton"  # a folder of vipr.models
    stage_initial: tuple[float, float, float] = (0.0, 0.0, 0.0)  # m, m, rad: x, y, yaw; the object is on its plate
    X_EO_held: np.ndarray | None = None  # the object is fixed to the hand there, as a tool would be; None: it stands
    X_PO: np.ndarray = field(default_factory=lambda: np.eye(4))  # of the object on the plate's top
    ballast: float = 0.0  # kg, packed into the object beside what it weighs
    drives: Drives = GRASPING  # of the hand
    contact_model: str = "hydroelastic_with_fallback"  # or point
    q_initial: np.ndarray = field(default_factory=lambda: puma560.NAMED["nominal"])  # rad
    lens: Lens = field(default_factory=lambda: load_lens(model_path("xc77/camera.yaml")))
    X_WC: np.ndarray = field(default_factory=fixed_camera)
    imperfection: Imperfection = Imperfection()
    # Rendered pixels each way for one of the camera: 1 is three times as fast, its edges up to 0.25 px off.
    supersampling: int = 2
    seed: int = 0
    time_step: float = 0.002  # s, of the physics
    camera_period: float = 0.04  # s


def held_shapes(config: WorkcellConfig) -> tuple[Shape, ...]:
    """The box about an object that is fixed to the hand, in the palm's frame; nothing if none with a CAD model is."""
    if config.X_EO_held is None or config.object not in object_names():
        return ()
    corners = load_model(model_path(f"{config.object}/model.yaml")).corners
    low, high = corners.min(axis=0), corners.max(axis=0)
    X_PO = se3.pose(np.eye(3), [0.0, 0.0, GRASP_HEIGHT]) @ config.X_EO_held
    return (box(config.object, high - low, X_PO @ se3.pose(np.eye(3), 0.5 * (low + high))),)


class Workcell(Diagram):
    """Arm, hand, table, stage, object and camera: everything that would be hardware.

    .. pydrake_system::

        name: Workcell
        input_ports:
        - arm_desired_state
        - motor_command
        - torque_limit
        - watching
        - stage_desired_state
        output_ports:
        - frame
        - joint_state
        - motor_position
        - motor_torque
        - finger_torque
        - clutch
        - X_WO_true
        - X_WE_true
        - X_CO_true

    ::

        arm_desired_state ─▶ set_points ─┬─▶ plant ──▶ encoders ──▶ joint_state
              inverse_dynamics ◀─────────┘   │
                     └───────────────────▶   │
        motor_command, torque_limit          │
                    ──▶ hand_driver ─────▶   ├─▶ hand_encoders ─▶ hand_driver ─▶ motor_position, motor_torque, finger_torque, clutch
        stage_desired_state ─────────────▶   ├─▶ truth ─▶ X_WO_true, X_WE_true, X_CO_true
                                             └─▶ scene_graph ─▶ sensor ─▶ camera ─▶ frame
        watching ─────────────────────────────────────────────────────▶

    Frames: W world, on the floor at the arm's foot, x ahead, z up; C camera; O object; E hand (the hand's ``grasp`` frame).
    ``arm_desired_state`` (12) is [q; qdot] of the joint servo [rad, rad/s], new every 10 ms, ``motor_command`` (4) the angles of the hand
    [rad], ``torque_limit`` (4) those at which its motors stop [N m] (may be left unconnected), ``watching`` (1) whether the camera takes
    pictures (it does if this is left unconnected), ``stage_desired_state`` (6) [x, y, yaw; rates] of the stage. ``frame`` is the
    camera's, ``joint_state`` (12) the encoders' [q; qdot]; the hand's outputs are its driver's.

    The joint servo is a PD controller in each joint about a motion through the set-points (``SetPointInterpolator``), with the torques
    that this motion takes by a nominal model of arm and hand. Coulomb friction is not simulated; viscous friction and rotor inertia are.
    """

    def __init__(self, config: WorkcellConfig):
        super().__init__()
        self.config = config
        builder = DiagramBuilder()
        plant, scene_graph = AddMultibodyPlant(
            MultibodyPlantConfig(
                time_step=config.time_step, stiction_tolerance=1e-5, contact_model=config.contact_model
            ),
            builder,
        )
        plant.set_name("plant")
        scene_graph.set_name("scene_graph")
        self.plant = plant
        models = _add_models(plant, config)
        puma, hand, stage = models["puma560"], models["barrett_hand"], models["motion_stage"]
        self.arm = puma_with_hand()
        self.joint_limits, self.guard = JOINT_LIMITS, collision_guard(held_shapes(config))
        add_renderer(scene_graph, RENDERER, daylight())

        encoders = builder.AddNamedSystem("encoders", JointEncoders(ARM_COUNT))
        self._nominal = nominal_arm()  # InverseDynamics keeps only a pointer to it
        steps = int(np.ceil(SET_POINTS / config.time_step - 1e-9))
        set_points = builder.AddNamedSystem("set_points", SetPointInterpolator(config.q_initial, SET_POINTS, steps))
        dynamics = builder.AddNamedSystem("inverse_dynamics", InverseDynamics(self._nominal))
        hand_encoders = builder.AddNamedSystem("hand_encoders", JointEncoders(HAND_COUNT))
        hand_driver = builder.AddNamedSystem("hand_driver", HandDriver(config.drives))
        X_WC = RigidTransform(config.X_WC)
        sensor = builder.AddNamedSystem("sensor", colour_sensor(config.lens, X_WC, RENDERER, config.supersampling))
        width, height = config.lens.width, config.lens.height
        camera = builder.AddNamedSystem(
            "camera",
            Camera(
                width,
                height,
                imperfection=config.imperfection,
                supersampling=config.supersampling,
                seed=config.seed,
                period=config.camera_period,
            ),
        )
        thing, palm = plant.GetBodyByName(config.object), plant.GetBodyByName("palm", hand)
        X_palm_E = plant.GetFrameByName("grasp", hand).GetFixedPoseInBodyFrame()
        truth = builder.AddNamedSystem(
            "truth", PoseTruth(thing.index(), palm.index(), X_palm_E.GetAsMatrix4(), config.X_WC)
        )

        for writer, reader in (
            (plant.get_state_output_port(puma), encoders.GetInputPort("state")),
            (set_points.GetOutputPort("desired_state"), plant.get_desired_state_input_port(puma)),
            (set_points.GetOutputPort("desired_state"), dynamics.get_input_port_estimated_state()),
            (set_points.GetOutputPort("desired_acceleration"), dynamics.get_input_port_desired_acceleration()),
            (dynamics.get_output_port_generalized_force(), plant.get_actuation_input_port(puma)),
            (plant.get_state_output_port(hand), hand_encoders.GetInputPort("state")),
            (hand_encoders.GetOutputPort("joint_state"), hand_driver.GetInputPort("hand_state")),
            (plant.get_net_actuation_output_port(hand), hand_driver.GetInputPort("joint_torque")),
            (hand_driver.GetOutputPort("desired_state"), plant.get_desired_state_input_port(hand)),
            (scene_graph.get_query_output_port(), sensor.query_object_input_port()),
            (sensor.color_image_output_port(), camera.GetInputPort("color_image")),
            (plant.get_body_poses_output_port(), truth.GetInputPort("body_poses")),
        ):
            builder.Connect(writer, reader)
        builder.ExportInput(set_points.GetInputPort("set_points"), "arm_desired_state")
        for name in ("motor_command", "torque_limit"):
            builder.ExportInput(hand_driver.GetInputPort(name), name)
        builder.ExportInput(camera.GetInputPort("watching"), "watching")
        builder.ExportInput(plant.get_desired_state_input_port(stage), "stage_desired_state")
        for system, names in (
            (camera, ("frame",)),
            (encoders, ("joint_state",)),
            (hand_driver, ("motor_position", "motor_torque", "finger_torque", "clutch")),
            (truth, ("X_WO_true", "X_WE_true", "X_CO_true")),
        ):
            for name in names:
                builder.ExportOutput(system.GetOutputPort(name), name)
        builder.BuildInto(self)
        self.set_name("workcell")


def _parser(plant: MultibodyPlant) -> Parser:
    parser = Parser(plant)
    parser.package_map().AddPackageXml(str(model_path("package.xml")))
    return parser


def _add_models(plant: MultibodyPlant, config: WorkcellConfig) -> dict[str, ModelInstanceIndex]:
    """Everything in its place, gains and start positions set, finalized; the model instances by name."""
    parser = _parser(plant)
    parser.AddModels(url="package://vipr/workcell/workcell.dmd.yaml")
    parser.AddModels(url=f"package://vipr/{config.object}/{config.object}.sdf")
    camera = parser.AddModels(url="package://vipr/xc77/xc77.sdf")[0]
    tripod = parser.AddModels(url="package://vipr/xc77/tripod.sdf")[0]
    X_WC = RigidTransform(config.X_WC)
    plant.WeldFrames(plant.world_frame(), plant.GetFrameByName("camera", camera), X_WC)
    X_WT = RigidTransform(RollPitchYaw(0, 0, np.arctan2(*X_WC.rotation().matrix()[1::-1, 2])), X_WC.translation())
    X_TripodHead = RigidTransform([-0.09, 0.0, -0.02])
    plant.WeldFrames(plant.world_frame(), plant.GetFrameByName("tripod", tripod), X_WT @ X_TripodHead)
    models = {name: plant.GetModelInstanceByName(name) for name in ("puma560", "barrett_hand", "motion_stage")}
    for i, (p, d) in enumerate(zip(STIFFNESS, DAMPING, strict=True), start=1):
        plant.GetJointActuatorByName(f"joint_{i}", models["puma560"]).set_controller_gains(PdControllerGains(p=p, d=d))
    for i, q in enumerate(config.q_initial, start=1):
        plant.GetJointByName(f"joint_{i}", models["puma560"]).set_default_angle(q)
    for axis, value in zip(("x", "y"), config.stage_initial, strict=False):
        plant.GetJointByName(f"stage_{axis}").set_default_translation(value)
    plant.GetJointByName("stage_yaw").set_default_angle(config.stage_initial[2])
    thing = plant.GetBodyByName(config.object)
    if config.X_EO_held is None:
        plant.SetDefaultFloatingBaseBodyPose(thing, RigidTransform(standing(config.stage_initial) @ config.X_PO))
    else:
        grasp = plant.GetFrameByName("grasp", models["barrett_hand"])
        plant.WeldFrames(grasp, thing.body_frame(), RigidTransform(config.X_EO_held))
    if config.ballast:
        more = SpatialInertia(config.ballast, thing.default_com(), thing.default_unit_inertia())
        ballast = plant.AddRigidBody("ballast", plant.GetModelInstanceByName(config.object), more)
        plant.WeldFrames(thing.body_frame(), ballast.body_frame())
    plant.Finalize()
    return models


def nominal_arm() -> MultibodyPlant:
    """What the controller believes the arm weighs: the Puma with the hand as a ball of known mass."""
    plant = MultibodyPlant(0.0)
    _parser(plant).AddModels(url="package://vipr/puma560/puma560.sdf")
    plant.WeldFrames(plant.world_frame(), plant.GetFrameByName("link_0"))
    ball = SpatialInertia.SolidSphereWithMass(HAND_MASS, 0.05).Shift([0.0, 0.0, -HAND_CENTRE])
    hand = plant.AddRigidBody("hand", plant.AddModelInstance("hand"), ball)
    plant.WeldFrames(plant.GetFrameByName("flange"), hand.body_frame())
    plant.Finalize()
    return plant
