"""The command mesh_tool: labels as numbers, for programs that learn from them."""
import csv
import io
import json

import numpy as np
import pytest
from PIL import Image
from mesh_msgs import zoo

from mesh_msgs_hdf5.commands.mesh_tool import main
from mesh_msgs_hdf5.formats.importer import read_mesh
from mesh_msgs_hdf5.labels.label_store import LabelStore
from mesh_msgs_hdf5.map_file import MapFile
from mesh_msgs_hdf5.model.mesh import Label, Mesh

pytestmark = pytest.mark.usefixtures("read_here")

GRID = zoo.grid()
LABELS = {
    "tree_10": Label(np.uint32([0, 1, 2, 3]), (1, 2, 3)),
    "tree_2": Label(np.uint32([10, 11])),
    "house": Label(np.uint32([3, 20, 21])),
}
# class, instance of faces: those of the last of several labels, in the order of their names
EXPECTED = np.zeros((len(GRID.faces), 2), int)
EXPECTED[[20, 21]] = 1, 1
EXPECTED[[10, 11]] = 2, 2
EXPECTED[[0, 1, 2, 3]] = 2, 3


@pytest.fixture
def path(tmp_path):
    """One of the labels stands in the journal alone."""
    labels = {text: label for text, label in LABELS.items() if text != "tree_2"}
    MapFile.write(tmp_path / "map.h5", Mesh(GRID.vertices, GRID.faces, labels=labels))
    with LabelStore(tmp_path / "map.h5", "mesh") as store:
        store.set("tree_2", LABELS["tree_2"].faces)
    return tmp_path / "map.h5"


def run(capsys, *words):
    """What it says for programs."""
    assert main([*map(str, words), "--json"]) == 0
    return json.loads(capsys.readouterr().out)


def check_table(table):
    assert (table["format"], table["version"], table["unlabelled"]) == ("mesh_label_ids", 1, 0)
    assert table["classes"] == [
        {"id": 1, "name": "house", "faces": 2},
        {"id": 2, "name": "tree", "faces": 6},
    ]
    named = [(e["instance_id"], e["class_id"], e["label"], e["color"]) for e in table["labels"]]
    assert named == [(1, 1, "house", None), (2, 2, "tree_2", None), (3, 2, "tree_10", [1, 2, 3])]


def test_a_line_for_each_face(path, tmp_path, capsys):
    value = run(capsys, "labels", "export", path, tmp_path / "ids.csv", "--ids")
    rows = list(csv.reader(io.StringIO((tmp_path / "ids.csv").read_text())))
    assert rows[0] == ["face", "class_id", "instance_id"]
    found = np.array(rows[1:]).astype(int)
    assert np.array_equal(found[:, 0], np.arange(len(GRID.faces)))
    assert np.array_equal(found[:, 1:], EXPECTED)
    assert value["notes"] == ["1 faces have several labels: the last counts"]
    assert value["table"] == str(tmp_path / "ids_classes.json")
    check_table(json.loads((tmp_path / "ids_classes.json").read_text()))


@pytest.mark.parametrize("remarked", [True, False])
def test_colors_of_labels_come_back_by_the_table(path, tmp_path, remarked):
    """With the comments of our export, and without, as from a program that knows none."""
    assert main(["export", str(path), str(tmp_path / "ids.ply"), "--ids", "-q"]) == 0
    if not remarked:
        head, body = (tmp_path / "ids.ply").read_bytes().split(b"end_header\n", 1)
        lines = [line for line in head.splitlines(True) if b"comment mesh_tools" not in line]
        (tmp_path / "ids.ply").write_bytes(b"".join(lines) + b"end_header\n" + body)
    words = ["import", str(tmp_path / "ids.ply"), str(tmp_path / "back.h5"), "-q"]
    words += ["--labels-from", "class_id,instance_id"]
    words += ["--label-names", str(tmp_path / "ids_classes.json")]
    assert main(words) == 0
    colors = {text: label.color for text, label in MapFile(tmp_path / "back.h5").labels().items()}
    assert colors == {text: label.color for text, label in LABELS.items()}


def test_columns_of_ply_come_back_as_the_same_labels(path, tmp_path, capsys):
    run(capsys, "export", path, tmp_path / "ids.ply", "--ids")
    mesh, _ = read_mesh(tmp_path / "ids.ply")
    columns = [mesh.face_attributes[name] for name in ("class_id", "instance_id")]
    assert np.array_equal(np.stack(columns, 1), EXPECTED) and columns[0].dtype == np.int32
    check_table(json.loads((tmp_path / "ids_classes.json").read_text()))
    words = [
        "--labels-from",
        "class_id,instance_id",
        "--label-names",
        tmp_path / "ids_classes.json",
    ]
    (tmp_path / "bare.ply").write_bytes(
        b"".join(
            line
            for line in (tmp_path / "ids.ply").read_bytes().splitlines(True)
            if not line.startswith(b"comment")
        )
    )
    run(capsys, "import", tmp_path / "bare.ply", tmp_path / "back.h5", *words)
    labels = MapFile(tmp_path / "back.h5").labels()
    assert {text: sorted(label.faces.tolist()) for text, label in labels.items()} == {
        "house": [20, 21],  # without the face of two labels
        "tree_2": [10, 11],
        "tree_10": [0, 1, 2, 3],
    }


@pytest.mark.parametrize("kind,column", [("class", 0), ("instance", 1)])
def test_a_picture_of_ids_has_no_mixture(path, tmp_path, capsys, kind, column):
    """Each pixel is that of the face at its center, which the camera in the table tells."""
    words = ["--size", "320x240", "--view", "top"]
    run(capsys, "render", path, tmp_path / "ids.png", "--labels", "--ids", kind, *words)
    run(capsys, "render", path, tmp_path / "bare.png", "--labels", "--bare", *words)
    with Image.open(tmp_path / "ids.png") as image:
        assert image.mode.startswith("I") and image.size == (320, 240)
        found = np.asarray(image).astype(int)
    with Image.open(tmp_path / "bare.png") as image:
        assert image.size == (320, 240)
        alpha = np.asarray(image.convert("RGBA"))[..., 3]
    table = json.loads((tmp_path / "ids_classes.json").read_text())
    check_table(table)
    assert table["pixels"] == kind + "_id"
    camera = table["camera"]
    middles = GRID.vertices[GRID.faces].mean(1)
    right, up = middles @ camera["right"], middles @ camera["up"]
    columns = np.floor((right - camera["left"]) / camera["pixel"]).astype(int)
    rows = np.floor((camera["top"] - up) / camera["pixel"]).astype(int)
    assert np.array_equal(found[rows, columns], EXPECTED[:, column])
    assert set(np.unique(found)) == set(np.unique(EXPECTED[:, column]))
    assert not found[alpha == 0].any()
    share = np.mean(found == 2)
    area = np.mean(EXPECTED[:, column] == 2) * np.mean(alpha > 127)
    assert share == pytest.approx(area, rel=0.1)


def test_numbers_of_an_earlier_table_are_kept(path, tmp_path, capsys):
    (tmp_path / "known.csv").write_text("5,tree\n9,car\n")
    words = ["--ids", "--classes", tmp_path / "known.csv"]
    value = run(capsys, "labels", "export", path, tmp_path / "ids.csv", *words)
    numbers = {entry["name"]: entry["id"] for entry in value["classes"]}
    assert numbers == {"tree": 5, "car": 9, "house": 10}
    run(capsys, "render", path, tmp_path / "picture.png", *words)
    with Image.open(tmp_path / "picture.png") as image:
        assert set(np.unique(np.asarray(image)).tolist()) == {0, 5, 10}


@pytest.mark.parametrize(
    "words,text",
    [
        (["labels", "export", "MAP", "a.json", "--ids"], "ends with .csv"),
        (["labels", "export", "MAP", "old.csv", "--ids"], "old_classes.json"),
        (["export", "MAP", "a.obj", "--ids"], "ends with .ply"),
        (["render", "MAP", "a.png", "--ids", "--height"], "no other thing"),
        (["render", "MAP", "old.png", "--ids"], "old_classes.json"),
        (["labels", "export", "MAP", "a.csv", "--ids", "--classes", "zero.csv"], "class 0 is not"),
        (["labels", "export", "MAP", "a.csv", "--ids", "--classes", "twice.csv"], "twice"),
    ],
)
def test_what_cannot_be_done_writes_nothing(path, tmp_path, monkeypatch, capsys, words, text):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "old_classes.json").write_text("")
    (tmp_path / "zero.csv").write_text("0,tree\n")
    (tmp_path / "twice.csv").write_text("1,tree\n2,tree\n")
    before = sorted(tmp_path.iterdir())
    assert main([word.replace("MAP", str(path)) for word in words]) == 1
    err = capsys.readouterr().err
    assert text in err and err.count("\n") == 1
    assert sorted(tmp_path.iterdir()) == before
