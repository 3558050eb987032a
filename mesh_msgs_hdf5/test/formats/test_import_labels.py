"""Labels of others: numbers of faces and vertices, and groups."""
import json

import numpy as np
import pytest
from mesh_writers import ply, stl, xyz

from mesh_msgs_hdf5.checks.check import identical
from mesh_msgs_hdf5.commands.mesh_tool import main
from mesh_msgs_hdf5.formats.exporter import write_mesh
from mesh_msgs_hdf5.formats.importer import read_mesh
from mesh_msgs_hdf5.map_file import MapFile
from mesh_msgs_hdf5.model.errors import MapFileError
from mesh_msgs_hdf5.model.mesh import Mesh

# a strip of quads, two triangles each
POINTS = np.float32([[x, y, 0] for x in range(6) for y in (0, 1)])
QUADS = [[2 * i, 2 * i + 2, 2 * i + 3, 2 * i + 1] for i in range(5)]
CATEGORIES, OBJECTS = [3, 1, 3, 0, 1], [1, 1, 2, 7, 1]
NAMES = {1: "floor", 3: "chair"}


def strip(tmp_path):
    after = [("category_id", "h", CATEGORIES), ("object_id", "I", OBJECTS)]
    (tmp_path / "a.ply").write_bytes(ply(xyz(POINTS), QUADS, after=after))
    return tmp_path / "a.ply"


def faces_of(mesh):
    return {text: sorted(label.faces.tolist()) for text, label in mesh.labels.items()}


def test_classes_of_faces(tmp_path):
    path = strip(tmp_path)
    mesh, report = read_mesh(path)
    assert not mesh.labels
    assert "--labels-from category_id makes labels of what category_id says" in report.notes
    mesh, report = read_mesh(path, labels_from=("category_id",))
    assert not any("--labels-from" in note for note in report.notes)
    assert faces_of(mesh) == {"category1": [2, 3, 8, 9], "category3": [0, 1, 4, 5]}
    assert "2 labels of category_id" in report.notes and report.labels == 2
    assert mesh.face_attributes["category_id"].tolist() == np.repeat(CATEGORIES, 2).tolist()


def test_classes_and_instances_with_names(tmp_path):
    path = strip(tmp_path)
    options = {"labels_from": ("category_id", "object_id"), "label_names": NAMES}
    mesh, _ = read_mesh(path, **options)
    expected = {"floor_1": [2, 3, 8, 9], "chair_1": [0, 1], "chair_2": [4, 5]}
    assert faces_of(mesh) == expected
    mesh, _ = read_mesh(path, labels_from=("category_id", "object_id"), label_names={3: "chair"})
    assert set(faces_of(mesh)) == {"category1_1", "chair_1", "chair_2"}


def test_classes_of_vertices(tmp_path):
    """A face has the class of most of its corners; where all differ, that of the first."""
    numbers = [1, 1, 1, 2, 2, 2, 3, 4, 5, 0, 0, 0]
    faces = [[0, 1, 2], [1, 2, 3], [3, 4, 2], [6, 7, 8], [9, 10, 8], [8, 9, 10]]
    columns = xyz(POINTS) + [("label", "H", numbers)]
    (tmp_path / "a.ply").write_bytes(ply(columns, faces))
    mesh, _ = read_mesh(tmp_path / "a.ply", labels_from=("label",))
    assert faces_of(mesh) == {"label1": [0, 1], "label2": [2], "label3": [3]}


OBJ = "".join("v %g %g %g\n" % tuple(p) for p in POINTS) + (
    "g default\nf 1 3 4 2\n"
    "o Big Table\ng wood legs\nusemtl oak\nf 3 5 6 4\n"
    "g wood\nf 5 7 8 6\no Lamp/1\nusemtl steel\nf 7 9 10 8\ng off\nusemtl oak\nf 9 11 12 10\n"
)


@pytest.mark.parametrize(
    "source,expected",
    [
        ("groups", {"wood": [2, 3, 4, 5, 6, 7], "legs": [2, 3]}),
        ("objects", {"Big Table": [2, 3, 4, 5], "Lamp_1": [6, 7, 8, 9]}),
        ("materials", {"oak": [2, 3, 4, 5, 8, 9], "steel": [6, 7]}),
    ],
)
def test_groups_of_obj(tmp_path, source, expected):
    (tmp_path / "a.obj").write_text(OBJ)
    mesh, report = read_mesh(tmp_path / "a.obj")
    assert not mesh.labels
    assert "--labels-from groups makes labels of its 2 groups" in report.notes
    mesh, _ = read_mesh(tmp_path / "a.obj", labels_from=(source,))
    assert faces_of(mesh) == expected


@pytest.mark.parametrize("kind", ["u1", "i8", "f8"])
@pytest.mark.parametrize("width", [None, 1])
def test_of_vertex_attributes(tmp_path, kind, width):
    """Of a map, and of our own PLY of it."""
    classes = np.array([1, 1, 1, 1, 0, 3, 3, 3, 3, 3, 0, 0]).astype(kind)
    classes = classes if width is None else classes.reshape(-1, width)
    mesh = Mesh(POINTS, np.uint32([q[:3] for q in QUADS]), vertex_attributes={"class_id": classes})
    MapFile.write(tmp_path / "a.h5", mesh)
    write_mesh(tmp_path / "a.ply", mesh)
    for name in ("a.h5", "a.ply"):
        found, _ = read_mesh(tmp_path / name, labels_from=("class_id",), label_names=NAMES)
        assert faces_of(found) == {"floor": [0, 1], "chair": [2, 3]}
        values = found.vertex_attributes["class_id"]
        assert identical(values.reshape(-1), classes.reshape(-1))
    _, report = read_mesh(tmp_path / "a.ply")
    assert "--labels-from class_id makes labels of what class_id says" in report.notes
    with pytest.raises(MapFileError) as refused:
        read_mesh(tmp_path / "a.h5", labels_from=("classes",))
    assert refused.value.hint == "there are: class_id"


def test_of_a_map(tmp_path):
    mesh = Mesh(POINTS, np.uint32([q[:3] for q in QUADS]))
    mesh.face_attributes["class"] = np.uint8(CATEGORIES)
    MapFile.write(tmp_path / "a.h5", mesh)
    found, _ = read_mesh(tmp_path / "a.h5", labels_from=("class",), label_names=NAMES)
    assert faces_of(found) == {"floor": [1, 4], "chair": [0, 2]}


@pytest.mark.parametrize(
    "text",
    [
        json.dumps({"classes": [{"id": n, "name": t} for n, t in NAMES.items()]}),
        json.dumps([{"id": n, "name": t, "more": 0} for n, t in NAMES.items()]),
        json.dumps(NAMES),
        "id,name\n1,floor\n3,chair\n",
        '1,"floor"\n3, chair\n',
    ],
)
def test_tables_of_names(tmp_path, capsys, text):
    path = strip(tmp_path)
    (tmp_path / "names").write_text(text)
    words = ["import", str(path), str(tmp_path / "a.h5"), "--labels-from", "category_id,object_id"]
    assert main([*words, "--label-names", str(tmp_path / "names")]) == 0
    assert MapFile(tmp_path / "a.h5").label_names() == ["chair_1", "chair_2", "floor_1"]
    capsys.readouterr()


@pytest.mark.parametrize(
    "name,options,text",
    [
        ("a.ply", {"labels_from": ("kind",)}, "no property 'kind'.*there are: category_id, object"),
        ("a.ply", {"labels_from": ("a", "b", "c")}, "one name, or two"),
        ("a.stl", {"labels_from": ("groups",)}, "no property 'groups'.*the mesh has none"),
        ("a.obj", {"labels_from": ("category_id",)}, "there are: groups, objects, materials"),
        ("b.obj", {"labels_from": ("groups",)}, "the file has no groups"),
        ("b.ply", {"labels_from": ("x",)}, "no property|no whole number"),
        ("c.ply", {"labels_from": ("part",)}, "part is 0.5 at 2, no whole number, 2 in all"),
    ],
)
def test_what_cannot_be_made_is_refused(tmp_path, name, options, text):
    strip(tmp_path)
    (tmp_path / "a.stl").write_bytes(stl(POINTS, [[0, 1, 2]]))
    (tmp_path / "a.obj").write_text(OBJ)
    (tmp_path / "b.obj").write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")
    (tmp_path / "b.ply").write_bytes(ply(xyz(POINTS), QUADS))
    (tmp_path / "c.ply").write_bytes(
        ply(xyz(POINTS), QUADS, after=[("part", "f", [1, 0.5, 1, 1, 1])])
    )
    with pytest.raises(MapFileError, match=text):
        read_mesh(tmp_path / name, **options)


@pytest.mark.parametrize(
    "text",
    [
        '{"classes": [], "labels": [{"instance_id": 1, "label": "a", "color": [1, 2]}]}',
        "{",
        "[1]",
        '{"a": "b"}',
        '{"1": 2}',
        "1\n",
        "a,b\nc,d\n",
    ],
)
def test_what_is_no_table(tmp_path, capsys, text):
    path = strip(tmp_path)
    (tmp_path / "names").write_text(text)
    words = ["import", str(path), str(tmp_path / "a.h5"), "--labels-from", "category_id"]
    assert main([*words, "--label-names", str(tmp_path / "names")]) == 1
    err = capsys.readouterr().err
    assert "no table of classes" in err and err.count("\n") == 1
