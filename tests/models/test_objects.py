"""Objects, table, stage and camera: they stand still, weigh what they should, and their CAD models are their looks and their contact."""

import numpy as np
import pytest
import trimesh
import yaml
from pydrake.geometry import Box, Convex, Cylinder, Mesh, QueryObject, Role  # noqa: F401  (QueryObject: port type)
from pydrake.math import RigidTransform, RollPitchYaw
from pydrake.multibody.parsing import Parser
from pydrake.multibody.plant import AddMultibodyPlantSceneGraph
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder

from vipr.models import model_path
from vipr.models.build import board, objects, robots
from vipr.systems.camera.lens import load_lens
from vipr.systems.tracking.cad_model import load_model

NAMES = sorted(objects.THINGS)
PAYLOAD = 0.5  # kg beside the hand, what the arm's wrist carries at this reach


def scene(*models, gravity=True):
    """Diagram, plant: the table welded to the world, its frame in the middle of the top, and the models, welded where they name a frame."""
    builder = DiagramBuilder()
    plant, scene_graph = AddMultibodyPlantSceneGraph(builder, 0.002)
    for path, frame, X_WF in models:
        (instance,) = Parser(plant).AddModels(str(model_path(path)))
        if frame:
            plant.WeldFrames(plant.world_frame(), plant.GetFrameByName(frame, instance), X_WF)
    plant.Finalize()
    return builder.Build(), plant, scene_graph


TABLE = ("table/table.sdf", "top", RigidTransform())


@pytest.fixture(scope="module")
def standing():
    """(plant, context before, context after one second): every object on the table, half a metre apart."""
    diagram, plant, _ = scene(TABLE, *((f"{name}/{name}.sdf", None, None) for name in NAMES))
    simulator = Simulator(diagram)
    context = simulator.get_mutable_context()
    for i, name in enumerate(NAMES):
        X_WO = RigidTransform(RollPitchYaw(0, 0, i), [0.25 * (i % 3 - 1), 0.4 * (i // 3 - 0.5), 0.0])
        plant.SetFreeBodyPose(plant.GetMyContextFromRoot(context), plant.GetBodyByName(name), X_WO)
    simulator.AdvanceTo(0.5)
    early = context.Clone()
    simulator.AdvanceTo(1.0)
    return plant, plant.GetMyContextFromRoot(early), plant.GetMyContextFromRoot(context)


@pytest.mark.parametrize("name", NAMES)
def test_object_stands_still(standing, name):
    plant, early, late = standing
    poses = [plant.EvalBodyPoseInWorld(context, plant.GetBodyByName(name)) for context in (early, late)]
    assert np.linalg.norm(poses[1].translation() - poses[0].translation()) < 1e-5
    assert np.degrees(poses[0].rotation().InvertAndCompose(poses[1].rotation()).ToAngleAxis().angle()) < 0.01
    assert abs(poses[1].translation()[2]) < 5e-4  # on the table top, hardly sunk in
    assert poses[1].rotation().col(2)[2] > 0.99999


@pytest.mark.parametrize("name", NAMES)
def test_mass_and_inertia_are_those_of_the_uniform_solid(standing, name):
    plant, _, context = standing
    body, thing = plant.GetBodyByName(name), objects.THINGS[name]()
    assert body.default_mass() == thing.mass <= PAYLOAD
    solid = hull(cad_points(name))
    solid.density = thing.mass / solid.volume
    M = body.CalcSpatialInertiaInBodyFrame(context)
    about_com = M.Shift(M.get_com()).CalcRotationalInertia().CopyToFullMatrix3()
    if name != "bottle":  # its hull is not its shape
        np.testing.assert_allclose(M.get_com(), solid.center_mass, atol=1e-5)
        np.testing.assert_allclose(about_com, solid.moment_inertia, rtol=2e-3, atol=1e-8)


def cad_points(name):
    """Vertices of the CAD edge model, cylinders as 360-sided prisms."""
    folder = model_path(name)
    model = yaml.safe_load((folder / "model.yaml").read_text())
    points = []
    if "polyhedron" in model:
        points += list(trimesh.load_mesh(folder / model["polyhedron"], process=False).vertices)
    a = np.linspace(0, 2 * np.pi, 360, endpoint=False)
    for cylinder in model.get("cylinders", []):
        for centre in (cylinder["axis_start"], cylinder["axis_end"]):
            r = cylinder["radius"]
            points += list(np.array(centre) + r * np.column_stack([np.cos(a), np.sin(a), 0 * a]))
    return np.array(points)


def hull(points):
    return trimesh.convex.convex_hull(np.asarray(points))


@pytest.mark.parametrize("name", NAMES)
def test_the_tracker_reads_the_cad_model(name):
    model = load_model(model_path(f"{name}/model.yaml"))
    thing = objects.THINGS[name]()
    assert len(model.vertices) == len(thing.points)
    np.testing.assert_allclose(model.cylinders[:, [2, 5, 6]], np.reshape(thing.cylinders, (-1, 3)))


@pytest.mark.parametrize("name", NAMES)
def test_the_visual_is_the_cad_model(name):
    folder = model_path(name)
    visual = np.array(
        [
            [float(v) for v in line.split()[1:]]
            for line in (folder / "visual.obj").read_text().splitlines()
            if line.startswith("v ")
        ]
    )
    model = yaml.safe_load((folder / "model.yaml").read_text())
    if "polyhedron" in model:
        assert {tuple(p) for p in np.round(visual, 6)} == {tuple(p) for p in np.round(cad_points(name), 6)}
    for cylinder in model.get("cylinders", []):
        z0, z1 = cylinder["axis_start"][2], cylinder["axis_end"][2]
        for z in (z0, z1):
            radii = np.hypot(*visual[np.isclose(visual[:, 2], z)][:, :2].T)
            assert np.isclose(radii, cylinder["radius"], atol=2e-6).sum() >= objects.SIDES
    visual_hull, cad_hull = hull(visual), hull(cad_points(name))
    np.testing.assert_allclose(visual_hull.volume, cad_hull.volume, rtol=6e-4)  # chords
    np.testing.assert_allclose(visual_hull.bounds, cad_hull.bounds, atol=2e-6)


@pytest.mark.parametrize("name", NAMES)
def test_the_contact_geometry_is_the_cad_model(name):
    _, plant, scene_graph = scene((f"{name}/{name}.sdf", None, None))
    inspector = scene_graph.model_inspector()
    points = []
    a = np.linspace(0, 2 * np.pi, 360, endpoint=False)
    for geometry in plant.GetCollisionGeometriesForBody(plant.GetBodyByName(name)):
        shape, X = inspector.GetShape(geometry), inspector.GetPoseInFrame(geometry)
        if isinstance(shape, Box):
            corners = np.array(np.meshgrid(*([-1, 1],) * 3)).reshape(3, -1) * shape.size()[:, None] / 2
        elif isinstance(shape, Cylinder):
            r, h = shape.radius(), shape.length() / 2
            corners = np.column_stack([(r * np.cos(t), r * np.sin(t), z) for t in a for z in (-h, h)])
        else:
            assert isinstance(shape, Convex)
            corners = trimesh.load_mesh(model_path(f"{name}/object.obj"), process=False).vertices.T
        points.append(X.multiply(corners).T)
    contact = np.vstack(points)
    assert np.abs(hull(contact).bounds - hull(cad_points(name)).bounds).max() < 1e-9
    np.testing.assert_allclose(hull(contact).volume, hull(cad_points(name)).volume, rtol=1e-9)
    assert {tuple(p) for p in np.round(contact, 7)} == {tuple(p) for p in np.round(cad_points(name), 7)}


@pytest.mark.parametrize("name", [n for n in NAMES if objects.THINGS[n]().points])
def test_polyhedra_are_closed_and_face_outwards(name):
    solid = trimesh.load_mesh(model_path(f"{name}/object.obj"))
    assert solid.is_watertight and solid.is_winding_consistent and solid.volume > 0


def test_the_kept_files_are_what_the_builder_writes(tmp_path):
    robots.write(tmp_path)
    objects.write(tmp_path, prints=False)
    board.write(tmp_path, prints=False)
    written = [path for path in tmp_path.rglob("*") if path.is_file()]
    assert len(written) > 40
    for path in written:
        assert path.read_text() == model_path(str(path.relative_to(tmp_path))).read_text(), path.name


@pytest.mark.parametrize(
    "path",
    [
        "room/room.sdf",
        "xc77/xc77.sdf",
        "xc77/tripod.sdf",
        "motion_stage/motion_stage.sdf",
        "calibration_board/calibration_board.sdf",
    ],
)
def test_model_loads_without_a_warning(path, caplog):
    scene((path, None, None))
    assert not caplog.records


WORKCELL = ("puma560", "barrett_hand", "xc77", "table", "room", "motion_stage", "calibration_board")


@pytest.mark.parametrize("name", [*WORKCELL, *NAMES])
def test_the_folder_says_where_its_figures_come_from(name):
    assert (model_path(name) / "README.md").is_file()


def test_the_camera_is_the_xc77_with_25_mm():
    lens = load_lens(model_path("xc77/camera.yaml"))
    cell = 11e-6 * 14.31818 / 12.27273  # m: sensor clock over grabber clock
    assert (lens.width, lens.height) == (640, 480)
    assert lens.fx == pytest.approx(0.025 / cell, rel=1e-5)
    assert lens.fy == pytest.approx(0.025 / 13e-6, rel=1e-5)
    assert (lens.cx, lens.cy) == (319.5, 239.5)


def test_the_stage_carries_a_carton_at_100_mm_per_second():
    stage = ("motion_stage/motion_stage.sdf", "base", RigidTransform([0, 0, 0]))
    diagram, plant, _ = scene(TABLE, stage, ("milk_carton/milk_carton.sdf", None, None))
    simulator = Simulator(diagram)
    root = simulator.get_mutable_context()
    context = plant.GetMyContextFromRoot(root)
    carton, top = plant.GetBodyByName("milk_carton"), plant.GetFrameByName("plate_top")
    plant.SetFreeBodyPose(context, carton, RigidTransform([0, 0, 0.020]))
    port = plant.get_desired_state_input_port(plant.GetModelInstanceByName("motion_stage"))
    velocity = np.array([0.1, -0.06, 0.5])
    for k in range(300):
        t = 0.004 * k
        ramp = min(t / 0.25, 1.0)
        travelled = t * ramp / 2 if t < 0.25 else t - 0.125
        port.FixValue(context, np.concatenate([velocity * travelled, velocity * ramp]))
        simulator.AdvanceTo(t + 0.004)
        if k == 25:
            start = carton.EvalPoseInWorld(context), top.CalcPoseInWorld(context)
    X_PO = [top.CalcPoseInWorld(context).inverse() @ carton.EvalPoseInWorld(context), start[1].inverse() @ start[0]]
    assert np.linalg.norm(X_PO[0].translation() - X_PO[1].translation()) < 5e-4  # it rides along
    speed = carton.EvalSpatialVelocityInWorld(context)
    np.testing.assert_allclose(speed.rotational()[2], 0.5, atol=0.02)
    np.testing.assert_allclose(speed.translational()[:2], [0.1, -0.06], atol=2e-3)
