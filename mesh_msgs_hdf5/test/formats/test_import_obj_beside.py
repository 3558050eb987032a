"""What OBJ and MTL files say that a mesh cannot hold, or that does not fit together, is said."""
import pytest
from mesh_writers import SQUARE, image_bytes, obj, pixels

from mesh_msgs.zoo import grid
from mesh_msgs_hdf5.formats.exporter import write_mesh
from mesh_msgs_hdf5.formats.importer import read_mesh
from mesh_msgs_hdf5.model.mesh import Label, Mesh

VT = "vt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\n"
TEXT = "mtllib a.mtl\n" + obj(SQUARE, []).decode() + VT
TEXT += "usemtl a\nf 1/1 2/2 3/3\nusemtl b\nf 1/1 3/3 4/4\n"


def read(folder, mtl):
    (folder / "a.png").write_bytes(image_bytes(pixels(1)))
    (folder / "a.mtl").write_text(mtl)
    (folder / "a.obj").write_text(TEXT)
    return read_mesh(folder / "a.obj")


@pytest.mark.parametrize(
    "lines,words",
    [
        ("d 0.5\n", "its transparency (d, Tr)"),
        ("d -halo 0.5\n", "its transparency (d, Tr)"),
        ("Tr 0.25\n", "its transparency (d, Tr)"),
        ("map_d a.png\n", "its texture of transparency (map_d)"),
        ("Kd 2 -1 0.5\n", "its color (Kd) beyond 0..1"),
        ("map_Ka a.png\n", "its texture of ambient light (map_Ka), the only one"),
        ("newmtl a\nKd 1 0 0\n", "an entry of its own (it is there twice: the last values count)"),
    ],
)
def test_what_a_material_says_and_a_mesh_cannot_hold(tmp_path, lines, words):
    _, report = read(tmp_path, "newmtl b\nmap_Kd a.png\nnewmtl a\n" + lines)
    assert report.notes == ["left out of 1 materials: %s; the first is a" % words]


def test_what_says_nothing_more_is_not_noted(tmp_path):
    mtl = "newmtl a\nKd 1 0 0\nd 1.0\nTr 0\nmap_Ka a.png\nmap_Kd a.png\nNs 10\nillum 2\n"
    _, report = read(tmp_path, mtl + mtl.replace("newmtl a", "newmtl b"))
    assert report.notes == []


def test_many_materials_are_one_note(tmp_path):
    _, report = read(tmp_path, "newmtl a\nd 0.5\nTr 0.5\nnewmtl b\nmap_Kd a.png\nd 0.25\n")
    assert report.notes == ["left out of 2 materials: its transparency (d, Tr); the first is a"]


@pytest.fixture
def labelled(tmp_path):
    """An OBJ file of ours with labels, of which one has another name as a group."""
    path = tmp_path / "a.obj"
    labels = {"tree_1": Label([0, 1, 2], (0, 9, 0)), "a house": Label([4]), "none": Label([])}
    mesh = grid(3)
    write_mesh(path, Mesh(mesh.vertices, mesh.faces, labels=labels))
    assert b"\ng tree_1\n" in path.read_bytes() and b"\ng a_house\n" in path.read_bytes()
    _, report = read_mesh(path)
    assert report.notes == []
    return path


def faces_of(mesh):
    return {text: label.faces.tolist() for text, label in mesh.labels.items()}


def test_a_group_that_was_renamed(labelled):
    text = labelled.read_text()
    labelled.write_text(text.replace("\ng tree_1\n", "\ng birch_9\n"))
    mesh, report = read_mesh(labelled)
    assert faces_of(mesh) == {"tree_1": [], "a house": [4], "none": []}
    assert report.notes == [
        "3 faces are in groups that its comments do not name (birch_9): --labels-from groups makes "
        "labels of these, too",
        "1 labels have another number of faces than its comments say: the groups count "
        "(tree_1: 0, not 3)",
    ]
    mesh, report = read_mesh(labelled, labels_from=("groups",))
    wanted = {"tree_1": [], "a house": [4], "none": [], "birch_9": [0, 1, 2]}
    assert faces_of(mesh) == wanted and mesh.labels["tree_1"].color == (0, 9, 0)
    assert not any("do not name" in note for note in report.notes)


def test_a_face_that_went_to_another_group(labelled):
    lines = labelled.read_text().splitlines()
    first = lines.index("g tree_1")
    lines[first : first + 2] = ["g a_house", lines[first + 1], "g tree_1"]
    labelled.write_text("\n".join(lines) + "\n")
    mesh, report = read_mesh(labelled)
    assert faces_of(mesh) == {"tree_1": [1, 2], "a house": [0, 4], "none": []}
    assert report.notes == [
        "2 labels have another number of faces than its comments say: the groups count "
        "(tree_1: 2, not 3, a house: 2, not 1)"
    ]


def test_all_groups_of_ours_are_labels_once(labelled):
    mesh, _ = read_mesh(labelled, labels_from=("groups",))
    assert faces_of(mesh) == {"tree_1": [0, 1, 2], "a house": [4], "none": []}
