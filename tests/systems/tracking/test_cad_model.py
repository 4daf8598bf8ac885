"""Model files are read as their formats say, and what cannot be tracked is refused in one line."""

import numpy as np
import pytest
from drawn_objects import box, l_shape

from vipr.systems.errors import InputError
from vipr.systems.tracking.cad_model import CREASE, Shape, build_model, load_model

CAO = """V1
# eight corners, a line on its own and a cylinder
10
0 0 0
0.1 0 0
0.1 0.1 0
0 0.1 0
0 0 0.1
0.1 0 0.1
0.1 0.1 0.1
0 0.1 0.1
0.2 0 0   # axis
0.2 0 0.1
# lines
5
0 1
1 2 name=edge
2 3
3 0
8 9
# faces from lines
1
4 0 1 2 3
# faces from points
5
4 4 5 6 7
4 0 1 5 4
4 1 2 6 5
4 2 3 7 6
4 3 0 4 7
# cylinders
1
8 9 0.03
# circles
1
0.02 4 5 7
"""


def write(tmp_path, name, text):
    path = tmp_path / name
    path.write_text(text)
    return path


def test_a_box_has_twelve_creases_and_outward_normals_whatever_the_sense_of_its_faces():
    corners = box().vertices
    faces = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    model = build_model(Shape("box", corners, tuple(f[:: (-1) ** k] for k, f in enumerate(faces))))
    assert (len(model.edges), model.closed, model.convex) == (12, True, True)
    assert (model.edge_kind == CREASE).all()
    assert ((model.vertices[model.triangles[:, 0]] * model.normals).sum(1) > 0).all()


def test_a_concave_face_keeps_its_outline():
    model = l_shape()
    assert (len(model.edges), model.closed, model.convex) == (18, True, False)


def test_a_triangulated_box_has_the_edges_of_the_box(tmp_path):
    triangles = "\n".join(f"f {a + 1} {b + 1} {c + 1}" for a, b, c in box().triangles)
    vertices = "\n".join(f"v {x} {y} {z}" for x, y, z in box().vertices)
    model = load_model(write(tmp_path, "box.obj", vertices + "\n" + triangles))
    assert len(model.edges) == 12


def test_obj_faces_may_name_textures_normals_and_count_from_the_end(tmp_path):
    text = "v 0 0 0\nv 0.1 0 0\nv 0.1 0.1 0\nv 0 0.1 0\nvt 0 0\nvn 0 0 1\nf 1/1/1 2//1 3 -1\n"
    assert len(load_model(write(tmp_path, "plate.obj", text)).edges) == 4


def test_a_cao_file_gives_faces_from_lines_and_points_cylinders_circles_and_loose_lines(tmp_path):
    model = load_model(write(tmp_path, "part.cao", CAO))
    assert len(model.triangles) == 12
    assert len(model.edges) == 13  # twelve of the cube, and the line that belongs to no face
    assert np.allclose(model.cylinders, [[0.2, 0, 0, 0.2, 0, 0.1, 0.03]])
    assert np.allclose(np.abs(model.circles), [[0, 0, 0.1, 0, 0, 1, 0.02]])


def test_a_yaml_model_adds_cylinders_to_a_polyhedron(tmp_path):
    write(tmp_path, "plate.obj", "v 0 0 0\nv 0.1 0 0\nv 0.1 0.1 0\nv 0 0.1 0\nf 1 2 3 4\n")
    text = (
        "name: pot\npolyhedron: plate.obj\ncylinders: [{axis_start: [0, 0, 0], axis_end: [0, 0, 0.1], radius: 0.03}]\n"
    )
    model = load_model(write(tmp_path, "pot.yaml", text))
    assert (model.name, len(model.edges), len(model.cylinders)) == ("pot", 4, 1)


@pytest.mark.parametrize(
    ("name", "text", "message"),
    [
        ("a.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\n", "has no faces"),
        ("a.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 4\n", "line 4: names a vertex outside 1 to 3"),
        ("a.obj", "v 0 0 nan\nv 1 0 0\nv 0 1 0\nf 1 2 3\n", "not a finite number"),
        ("a.obj", "v 0 0 zero\n", "line 1: expected a number, got 'zero'"),
        ("a.obj", "v 0 0 0\nv 1 0 0\nv 2 0 0\nf 1 2 3\n", "have no area"),
        ("a.obj", "v 0 0 0\nv 200 0 0\nv 0 200 0\nf 1 2 3\n", "expected metres"),
        ("a.cao", CAO[:60], "the file ends where|needs 3 numbers"),
        ("a.cao", CAO.replace("8 9 0.03", "8 99 0.03"), "an index is outside 0 to 9"),
        ("a.cao", CAO.replace("4 0 1 2 3", "3 0 1 2"), "do not form a closed loop"),
        ("a.cao", "V2\n", "begins with V1"),
        ("a.yaml", "cylinders: [{radius: 0.03}]\n", "cylinder 0 needs axis_start"),
        ("a.yaml", "name: nothing\n", "has no faces, lines, cylinders or circles"),
        ("a.yaml", "cylindres: []\n", "got cylindres"),
        ("a.stl", "solid nothing\nendsolid nothing\n", "a.stl"),
        ("a.xyz", "", "unknown kind .xyz"),
    ],
)
def test_a_model_that_cannot_be_tracked_is_refused(tmp_path, name, text, message):
    with pytest.raises(InputError, match=message):
        load_model(write(tmp_path, name, text))


def test_a_missing_model_is_named():
    with pytest.raises(InputError, match=r"nowhere\.obj: no such file"):
        load_model("nowhere.obj")
