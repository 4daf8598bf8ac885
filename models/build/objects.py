"""Objects of the house: one description each gives the visual, the collision geometry, the inertia and the CAD edge model.

Frame O of every object: centre of the bottom face, z up. Sources of the figures: README.md in each object's folder.
"""

from dataclasses import dataclass, replace
from pathlib import Path

import cv2
import numpy as np
import trimesh
import yaml

from vipr.models.build import artwork
from vipr.models.build.mesh import BOX_FACES, Mesh, write_edges

SIDES = 128  # of a cylinder's visual: the chord of the can stays within 0.01 mm of the circle, 0.6 mm of depth at 2 m
PIXELS_PER_METRE = artwork.PIXELS_PER_MM * 1000


@dataclass(frozen=True)
class Thing:
    """A uniform solid: polyhedron and cylinders about z (z0, z1, radius) [m]."""

    mass: float  # kg
    mesh: Mesh
    sheet: np.ndarray  # print, BGR
    friction: float
    points: tuple = ()
    faces: tuple = ()
    box: tuple | None = None  # size, where the polyhedron is one
    cylinders: tuple = ()
    facet: float = 0.02  # m, of the contact meshes


def box_points(x: float, y: float, z: float) -> tuple:
    """Corners of a box on its bottom centre, in the order of BOX_FACES."""
    return tuple((sx * x / 2, sy * y / 2, h) for h in (0.0, z) for sy in (-1, 1) for sx in (-1, 1))


# Corners of a box in the order left bottom, right bottom, right top, left top, as its four sides are seen from outside, going round.
WALLS = ((0, 1, 5, 4), (1, 3, 7, 5), (3, 2, 6, 7), (2, 0, 4, 6))


def wrapped(mesh: Mesh, points, walls, sheet_size, rise=None) -> None:
    """Add the walls of a prism, printed from one sheet that goes round it: x is the way round, y the height (or ``rise`` of a corner)."""
    width, height = sheet_size
    start = 0.0
    for wall in walls:
        p = np.array([points[i] for i in wall])
        along = (p[1] - p[0])[:2]
        length = np.linalg.norm(along)
        u = start + (p[:, :2] - p[0, :2]) @ along / length
        v = p[:, 2]
        mesh.polygon("print", p, uvs=np.column_stack([u / width, v / height]))
        start += length


def milk_carton() -> Thing:
    """Gable-top litre: 70 x 70 mm, walls 195 mm, ridge along x at 235 mm."""
    a, wall, ridge = 0.070, 0.195, 0.235
    points = (*box_points(a, a, wall), (-a / 2, 0.0, ridge), (a / 2, 0.0, ridge))
    slope = float(np.hypot(a / 2, ridge - wall))
    sheet = (4 * a, wall + slope)
    mesh = Mesh()
    for k, outline in enumerate(((0, 1, 5, 4), (1, 3, 7, 9, 5), (3, 2, 6, 7), (2, 0, 4, 8, 6))):
        p = np.array([points[i] for i in outline])
        direction = (p[1] - p[0]) / a
        uv = np.column_stack([(k * a + (p - p[0]) @ direction) / sheet[0], p[:, 2] / sheet[1]])
        mesh.polygon("print", p, uvs=uv)
    for k, outline in ((0, (4, 5, 9, 8)), (2, (7, 6, 8, 9))):
        u = np.array([k * a, (k + 1) * a, (k + 1) * a, k * a]) / sheet[0]
        v = np.array([wall, wall, wall + slope, wall + slope]) / sheet[1]
        mesh.polygon("print", [points[i] for i in outline], uvs=np.column_stack([u, v]))
    mesh.polygon("card", [points[i] for i in BOX_FACES[0]])
    faces = (BOX_FACES[0], (0, 1, 5, 4), (1, 3, 7, 9, 5), (3, 2, 6, 7), (2, 0, 4, 8, 6), (4, 5, 9, 8), (7, 6, 8, 9))
    return Thing(0.45, mesh, artwork.milk(sheet), 0.6, points, faces)


def rice_box() -> Thing:
    """Carton of rice in cooking bags: 115 x 50 x 165 mm."""
    size = x, y, z = 0.115, 0.050, 0.165
    points = box_points(*size)
    sheet = (2 * (x + y), z + y)
    mesh = Mesh()
    wrapped(mesh, points, WALLS, sheet)
    mesh.polygon(
        "print", [points[i] for i in BOX_FACES[1]], uvs=np.array([(0, z), (x, z), (x, z + y), (0, z + y)]) / sheet
    )
    mesh.polygon("card", [points[i] for i in BOX_FACES[0]])
    return Thing(0.40, mesh, artwork.rice(sheet, size), 0.6, points, BOX_FACES, box=size)


def book() -> Thing:
    """Paperback lying on its back cover: 130 x 190 x 18 mm, spine at -x."""
    size = x, y, z = 0.130, 0.190, 0.018
    points = box_points(*size)
    sheet = (x + 2 * z, y)
    mesh = Mesh()
    mesh.polygon("print", [points[i] for i in BOX_FACES[1]], uvs=np.array([(0, 0), (x, 0), (x, y), (0, y)]) / sheet)
    spine = np.array([(x, y), (x, 0), (x + z, 0), (x + z, y)]) / sheet
    mesh.polygon("print", [points[i] for i in WALLS[3]], uvs=spine)
    for wall in WALLS[:3]:
        mesh.polygon("pages", [points[i] for i in wall])
    mesh.polygon("card", [points[i] for i in BOX_FACES[0]])
    return Thing(0.30, mesh, artwork.book(sheet, size), 0.5, points, BOX_FACES, box=size)


def turned(mass, friction, sheet, *parts) -> Thing:
    """Cylinders about z: parts are (z0, z1, radius, side material, top material)."""
    mesh = Mesh()
    for k, (z0, z1, radius, side, top) in enumerate(parts):
        mesh.tube(side, (0, 0, z0), (0, 0, z1), radius, sides=SIDES, caps=(k == 0, True), cap_material=top)
    return Thing(mass, mesh, sheet, friction, cylinders=tuple(part[:3] for part in parts))


def can() -> Thing:
    """Drink can, 330 ml, full: 66 mm across, 115 mm high."""
    r, h = 0.033, 0.115
    return turned(0.345, 0.5, artwork.can(2 * np.pi * r, h), (0, h, r, "print", "metal"))


def mug() -> Thing:
    """Mug without its handle, full: 80 mm across, 95 mm high."""
    r, h = 0.040, 0.095
    return turned(0.45, 0.5, artwork.mug(2 * np.pi * r, h), (0, h, r, "print", "coffee"))


def bottle() -> Thing:
    """Bottle of syrup: body 62 mm across and 150 mm high, cap 40 mm across, 185 mm in all."""
    r, h = 0.031, 0.150
    parts = (0, h, r, "print", "plastic"), (h, 0.185, 0.020, "cap", "cap")
    # Eleven facets around the body, as the can has, one of them at -x: it lies still on it with x up.
    return replace(turned(0.45, 0.5, artwork.bottle(2 * np.pi * r, h), *parts), facet=0.018)


THINGS = {f.__name__: f for f in (milk_carton, rice_box, can, mug, bottle, book)}
MATERIALS = {
    "print": "print.png",
    "card": (0.80, 0.79, 0.76),
    "pages": (0.86, 0.82, 0.70),
    "metal": (0.62, 0.63, 0.65),
    "coffee": (0.20, 0.11, 0.06),
    "plastic": (0.45, 0.10, 0.16),
    "cap": (0.88, 0.87, 0.83),
}


def inertia(thing: Thing) -> tuple[np.ndarray, np.ndarray]:
    """Centre of mass (3,) and central moments of inertia (3, 3) of the uniform solid."""
    if thing.points:
        solid = trimesh.Trimesh(
            thing.points, [(f[0], f[i], f[i + 1]) for f in thing.faces for i in range(1, len(f) - 1)]
        )
        return solid.center_mass, solid.moment_inertia * thing.mass / solid.volume
    volumes = np.array([np.pi * r**2 * (z1 - z0) for z0, z1, r in thing.cylinders])
    heights = np.array([(z0 + z1) / 2 for z0, z1, _ in thing.cylinders])
    com = np.array([0, 0, volumes @ heights / volumes.sum()])
    moments = np.zeros((3, 3))
    for (z0, z1, r), volume, height in zip(thing.cylinders, volumes, heights, strict=True):
        m = thing.mass * volume / volumes.sum()
        across = m * (3 * r**2 + (z1 - z0) ** 2) / 12 + m * (height - com[2]) ** 2
        moments += np.diag([across, across, m * r**2 / 2])
    return com, moments


def sdf(name: str, thing: Thing) -> str:
    """The SDF text."""
    com, moments = inertia(thing)
    if thing.box:
        shapes = [(f"0 0 {thing.box[2] / 2:g}", "<box><size>{:g} {:g} {:g}</size></box>".format(*thing.box))]
    elif thing.points:
        shapes = [("0 0 0", "<mesh><uri>object.obj</uri><drake:declare_convex/></mesh>")]
    else:
        shapes = [
            (f"0 0 {(z0 + z1) / 2:g}", f"<cylinder><radius>{r:g}</radius><length>{z1 - z0:g}</length></cylinder>")
            for z0, z1, r in thing.cylinders
        ]
    common = {"mu": thing.friction, "facet": thing.facet}
    collisions = "".join(COLLISION.format(k=k, at=at, shape=s, **common) for k, (at, s) in enumerate(shapes))
    values = dict(zip(("ixx", "iyy", "izz"), (f"{v:.6g}" for v in np.diag(moments)), strict=True))
    return SDF.format(name=name, mass=thing.mass, com=f"{com[2]:.6g}", collisions=collisions, **values)


SDF = """<?xml version="1.0"?>
<!-- Written by vipr.models.build. Frame O: centre of the bottom face, z up. -->
<sdf version="1.9" xmlns:drake="http://drake.mit.edu">
  <model name="{name}">
    <link name="{name}">
      <inertial>
        <pose>0 0 {com} 0 0 0</pose>
        <mass>{mass}</mass>
        <inertia><ixx>{ixx}</ixx><ixy>0</ixy><ixz>0</ixz><iyy>{iyy}</iyy><iyz>0</iyz><izz>{izz}</izz></inertia>
      </inertial>
      <visual name="visual"><geometry><mesh><uri>visual.obj</uri></mesh></geometry></visual>
{collisions}    </link>
  </model>
</sdf>
"""
COLLISION = """      <collision name="collision_{k}">
        <pose>{at} 0 0 0</pose>
        <geometry>{shape}</geometry>
        <drake:proximity_properties>
          <drake:compliant_hydroelastic/>
          <drake:hydroelastic_modulus>1e7</drake:hydroelastic_modulus>
          <drake:mesh_resolution_hint>{facet:g}</drake:mesh_resolution_hint>
          <drake:hunt_crossley_dissipation>1</drake:hunt_crossley_dissipation>
          <drake:mu_dynamic>{mu}</drake:mu_dynamic>
          <drake:mu_static>{mu}</drake:mu_static>
        </drake:proximity_properties>
      </collision>
"""


def edge_model(name: str, thing: Thing) -> dict:
    """Content of ``model.yaml``: the CAD edge model, lengths in metres."""
    model = {"name": name}
    if thing.points:
        model["polyhedron"] = "object.obj"
    if thing.cylinders:
        model["cylinders"] = [
            {"axis_start": [0.0, 0.0, float(z0)], "axis_end": [0.0, 0.0, float(z1)], "radius": float(r)}
            for z0, z1, r in thing.cylinders
        ]
    return model


def write(folder: Path, prints: bool = True) -> None:
    """Write every object's files below folder, the prints too unless told otherwise."""
    for name, make in THINGS.items():
        thing, here = make(), folder / name
        here.mkdir(parents=True, exist_ok=True)
        thing.mesh.write(here / "visual.obj", MATERIALS)
        (here / f"{name}.sdf").write_text(sdf(name, thing))
        (here / "model.yaml").write_text(yaml.safe_dump(edge_model(name, thing), sort_keys=False))
        if thing.points:
            write_edges(here / "object.obj", thing.points, thing.faces)
        if prints:
            cv2.imwrite(str(here / "print.png"), thing.sheet, [cv2.IMWRITE_PNG_COMPRESSION, 9])
