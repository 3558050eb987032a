"""The command mesh_tool: layers and labels, which change a map file."""
import hashlib
import json
import os

import numpy as np
import pytest

from mesh_msgs_hdf5.commands.mesh_tool import main
from mesh_msgs_hdf5.commands.progress import ProgressLine
from mesh_msgs_hdf5.labels.label_store import LabelStore
from mesh_msgs_hdf5.map_file import MapFile
from mesh_msgs_hdf5.model.mesh import Label, Mesh

from map_samples import assert_same_mesh

pytestmark = pytest.mark.usefixtures("read_here")


@pytest.fixture
def rich(rich_mesh, tmp_path):
    path = tmp_path / "rich.h5"
    MapFile.write(path, rich_mesh)
    return path


def run(capsys, *arguments):
    """(exit code, output, errors)"""
    code = main([str(argument) for argument in arguments])
    return (code, *capsys.readouterr())


def test_lists_of_layers(rich, capsys):
    for words in (["layers"], ["layers", "list"]):
        code, out, err = run(capsys, *words, rich)
        lines = out.splitlines()
        assert (code, err) == (0, "") and len(lines) == 2
        assert lines[1].startswith("height_diff: ") and "1 lethal, 1 unknown" in lines[1]
        assert '"radius": 0.3' in lines[1] and "parameters unknown" in lines[0]
    names = [
        layer["name"] for layer in json.loads(run(capsys, "layers", rich, "--json")[1])["layers"]
    ]
    assert names == ["Grün und weich", "height_diff"]
    attributes = json.loads(run(capsys, "layers", rich, "--json", "--face")[1])["face_attributes"]
    assert len(attributes) == 4 and attributes[0]["name"] == "Fläche m²"
    code, out, err = run(capsys, "layers", "list", rich, "--vertex")
    assert (code, err) == (0, "") and "  vertex " not in out
    assert out.splitlines()[0].startswith("SIFT: -128 .. 127, int8 x 7, ")
    text = run(capsys, "layers", rich, "--json", "--vertex")[1]
    attributes = json.loads(text)["vertex_attributes"]
    assert [(a["name"], a["type"]) for a in attributes][1:3] == [
        ("class_id", "uint8"),
        ("echo", "float32"),
    ]
    shown = run(capsys, "info", rich)[1]
    assert "  vertex     flow: " in shown and "float32 x 3, " in shown and "m/s" in shown
    with pytest.raises(SystemExit):
        main(["layers", str(rich), "--vertex", "--face"])
    MapFile.write(rich.parent / "bare.h5", Mesh(np.eye(3, dtype="f4"), np.uint32([[0, 1, 2]])))
    assert "no layers" in run(capsys, "layers", rich.parent / "bare.h5")[1]


def test_copy_rename_and_delete_layers(rich, rich_mesh, capsys):
    costs, parameters = rich_mesh.vertex_costs, rich_mesh.layer_parameters
    assert run(capsys, "layers", "copy", rich, "height_diff", "old")[0] == 0
    costs["old"], parameters["old"] = costs["height_diff"], parameters["height_diff"]
    assert_same_mesh(MapFile(rich).read(), rich_mesh)
    assert run(capsys, "layers", "rename", rich, "height_diff", "new")[0] == 0
    costs["new"], parameters["new"] = costs.pop("height_diff"), parameters.pop("height_diff")
    assert_same_mesh(MapFile(rich).read(), rich_mesh)
    code, out, err = run(capsys, "layers", "delete", rich, "new", "Grün und weich")
    assert (code, err) == (0, "") and out == "%s: deleted layer new, Grün und weich\n" % rich
    del costs["new"], parameters["new"], costs["Grün und weich"]
    assert_same_mesh(MapFile(rich).read(), rich_mesh)
    attributes, parameters = rich_mesh.vertex_attributes, rich_mesh.vertex_parameters
    copy = ("layers", "copy", rich, "SIFT", "older", "--vertex")
    assert run(capsys, *copy)[1] == "%s: vertex attribute SIFT copied to older\n" % rich
    attributes["older"], parameters["older"] = attributes["SIFT"], parameters["SIFT"]
    assert_same_mesh(MapFile(rich).read(), rich_mesh)
    assert run(capsys, *copy)[2].count("there is a vertex attribute 'older' already") == 1
    assert run(capsys, "layers", "rename", rich, "echo", "new", "--vertex", "-q") == (0, "", "")
    attributes["new"] = attributes.pop("echo")
    assert_same_mesh(MapFile(rich).read(), rich_mesh)
    assert run(capsys, "layers", "delete", rich, "new", "id", "--vertex", "-q") == (0, "", "")
    del attributes["new"], attributes["id"]
    assert_same_mesh(MapFile(rich).read(), rich_mesh)
    attributes = rich_mesh.face_attributes
    assert run(capsys, "layers", "rename", rich, "cost", "price", "--face", "-q") == (0, "", "")
    attributes["price"] = attributes.pop("cost")
    rich_mesh.face_parameters = {"price": rich_mesh.face_parameters["cost"]}
    assert_same_mesh(MapFile(rich).read(), rich_mesh)
    assert run(capsys, "layers", "delete", rich, "--face", "segment", "face_normals")[0] == 0
    del attributes["segment"], attributes["face_normals"]
    assert_same_mesh(MapFile(rich).read(), rich_mesh)


def test_copy_a_layer_from_another_file(rich, rich_mesh, capsys, tmp_path):
    mesh = Mesh(rich_mesh.vertices, rich_mesh.faces)
    other = tmp_path / "other.h5"
    MapFile.write(other, mesh)
    assert run(capsys, "layers", "copy", other, "height_diff", "--from", rich)[0] == 0
    file = MapFile(other)
    assert np.array_equal(
        file.vertex_costs("height_diff"), rich_mesh.vertex_costs["height_diff"], equal_nan=True
    )
    assert file.layer_parameters("height_diff") == rich_mesh.layer_parameters["height_diff"]
    assert run(capsys, "layers", "copy", other, "segment", "id", "--face", "--from", rich)[0] == 0
    assert np.array_equal(MapFile(other).face_attribute("id"), rich_mesh.face_attributes["segment"])
    code, _, err = run(capsys, "layers", "copy", other, "height_diff", "--from", rich)
    assert code == 1 and "already" in err and "--force" in err
    assert run(capsys, "layers", "copy", other, "height_diff", "--from", rich, "--force")[0] == 0
    mesh.vertices = mesh.vertices + np.float32(1)
    MapFile.write(other, mesh)
    code, _, err = run(capsys, "layers", "copy", other, "height_diff", "--from", rich)
    assert code == 1 and "geometry" in err


@pytest.mark.parametrize(
    "arguments,words",
    [
        (["layers", "delete", "MAP", "height_diff", "slope"], "there is no layer 'slope'"),
        (["layers", "delete", "MAP", "height_diff", "--face"], "face attribute 'height_diff'"),
        (["layers", "rename", "MAP", "x", "y"], "there are: "),
        (["layers", "rename", "MAP", "height_diff", "Grün und weich"], "already"),
        (["layers", "rename", "MAP", "height_diff", "a/b"], "slash"),
        (["layers", "rename", "MAP", "height_diff", "vertices"], "kept for mesh data"),
        (["layers", "copy", "MAP", "height_diff"], "a name of its own"),
        (["layers", "copy", "MAP", "height_diff", "height_diff", "--force"], "a name of its own"),
        (["layers", "copy", "MAP", "x", "--from", "nothing.h5"], "no such file"),
        (["layers", "delete", "nothing.h5", "x"], "no such file"),
        (["layers", "list", "MAP", "--part", "upper"], "upper"),
        (["labels", "delete", "MAP", "tree_1", "bush_1"], "there is no label 'bush_1'"),
        (["labels", "delete", "MAP", "--class", "bush"], "there is no class 'bush'"),
        (["labels", "rename", "MAP", "tree_1", "tree_2"], "already"),
        (["labels", "rename", "MAP", "tree_1", "a/b"], "slash"),
        (["labels", "rename", "MAP", "bush", "b"], "there is no label 'bush'"),
        (["labels", "color", "MAP", "none", "bush"], "there is no label 'bush'"),
        (["labels", "import", "MAP", "nothing.csv"], "no such file"),
        (["labels", "export", "MAP", "out.txt"], ".json or .csv"),
        (["labels", "export", "MAP", "nowhere/out.csv"], "does not exist"),
        (["labels", "list", "nothing.h5"], "no such file"),
    ],
)
def test_what_cannot_be_done_is_one_line_and_changes_nothing(rich, capsys, arguments, words):
    before = hashlib.sha256(rich.read_bytes()).digest()
    code, out, err = run(capsys, *[rich if word == "MAP" else word for word in arguments])
    assert (code, out) == (1, "") and words in err
    assert err.startswith("mesh_tool: error: ") and err.count("\n") == 1
    assert hashlib.sha256(rich.read_bytes()).digest() == before
    assert os.listdir(rich.parent) == [rich.name]


def plain(labels):
    return {text: (sorted(label.faces.tolist()), label.color) for text, label in labels.items()}


@pytest.mark.parametrize("suffix", ["json", "csv"])
def test_labels_survive_export_and_import(rich, rich_mesh, capsys, tmp_path, suffix):
    table = tmp_path / ("labels." + suffix)
    assert run(capsys, "labels", "export", rich, table)[0] == 0
    assert run(capsys, "labels", "export", rich, table)[0] == 1
    assert run(capsys, "labels", "export", rich, table, "--force", "-q") == (0, "", "")
    assert run(capsys, "labels", "import", rich, table, "--replace")[0] == 0
    assert_same_mesh(MapFile(rich).read(), rich_mesh)
    bare = tmp_path / "bare.h5"
    MapFile.write(
        bare, Mesh(rich_mesh.vertices, rich_mesh.faces, labels={"x_1": Label(np.uint32([1]))})
    )
    assert run(capsys, "labels", "import", bare, table)[0] == 0
    expected = {**plain(rich_mesh.labels), "x_1": ([1], None)}
    assert plain(MapFile(bare).labels()) == expected
    code, out, _ = run(capsys, "labels", "import", bare, table, "--replace", "--json")
    assert code == 0 and json.loads(out)["deleted"] == ["x_1"]
    assert len(json.loads(out)["set"]) == len(rich_mesh.labels)
    assert plain(MapFile(bare).labels()) == plain(rich_mesh.labels)
    assert sorted(os.listdir(tmp_path)) == sorted(["bare.h5", "rich.h5", table.name])


def test_labels_of_another_geometry_are_only_taken_with_force(rich, rich_mesh, capsys, tmp_path):
    table = tmp_path / "labels.json"
    run(capsys, "labels", "export", rich, table)
    other = tmp_path / "other.h5"
    MapFile.write(other, Mesh(rich_mesh.vertices + np.float32(1), rich_mesh.faces))
    code, _, err = run(capsys, "labels", "import", other, table)
    assert code == 1 and "--force" in err and not MapFile(other).label_names()
    assert run(capsys, "labels", "import", other, table, "--force")[0] == 0
    assert plain(MapFile(other).labels()) == plain(rich_mesh.labels)


def test_list_rename_color_and_delete_labels(rich, rich_mesh, capsys):
    labels = dict(rich_mesh.labels)
    code, out, _ = run(capsys, "labels", rich)
    assert code == 0 and "tree_1: 3 faces, #0080ff" in out.splitlines()
    assert "tree_2: 60 faces" in out.splitlines() and len(out.splitlines()) == len(labels)
    found = json.loads(run(capsys, "labels", "list", rich, "--json")[1])
    entry = {
        "label": "house_2_b",
        "class": "house",
        "instance": "2_b",
        "color": [1, 2, 3],
        "faces": 1,
    }
    assert entry in found["labels"] and found["faces"] == 60 and found["uuid"] == rich_mesh.uuid
    assert run(capsys, "labels", "rename", rich, "tree_1", "oak_1")[0] == 0
    labels["oak_1"] = labels.pop("tree_1")
    assert plain(MapFile(rich).labels()) == plain(labels)
    assert run(capsys, "labels", "color", rich, "#0a0b0c", "oak_1", "tree_2")[0] == 0
    for text in ("oak_1", "tree_2"):
        labels[text] = Label(labels[text].faces, (10, 11, 12))
    assert plain(MapFile(rich).labels()) == plain(labels)
    assert run(capsys, "labels", "color", rich, "none", "oak_1")[0] == 0
    labels["oak_1"].color = None
    assert plain(MapFile(rich).labels()) == plain(labels)
    assert run(capsys, "labels", "delete", rich, "oak_1", "a free text")[0] == 0
    assert run(capsys, "labels", "delete", rich, "--class", "grass")[0] == 0
    for text in ("oak_1", "a free text", "grass", "grass_"):
        del labels[text]
    assert plain(MapFile(rich).labels()) == plain(labels)


def test_labels_that_are_in_the_journal_only(rich, rich_mesh, capsys, tmp_path):
    with LabelStore(rich) as store:  # a node
        store.set("tree_9", [1, 2])
        assert "tree_9: 2 faces" in run(capsys, "labels", rich)[1]
        code, _, err = run(capsys, "labels", "delete", rich, "tree_1")
        assert code == 1 and str(os.getpid()) in err and err.count("\n") == 1
        code, _, err = run(capsys, "labels", "delete", rich, "tree_9")
        assert code == 1
    # the node has ended without saving
    assert "tree_9" not in MapFile(rich).label_names()
    assert run(capsys, "validate", rich)[1].count("journal") >= 1
    assert run(capsys, "labels", "delete", rich, "tree_1")[0] == 0
    names = MapFile(rich).label_names()
    assert "tree_9" in names and "tree_1" not in names
    assert os.listdir(tmp_path) == ["rich.h5"]


def test_a_map_of_another_schema_is_read_but_not_changed(tmp_path, rich_mesh, capsys):
    import map_samples

    path = tmp_path / "old.h5"
    map_samples.write_s0(path, rich_mesh)
    assert run(capsys, "labels", path)[0] == 0
    assert run(capsys, "layers", path)[0] == 0
    layer = MapFile(path).layer_names()[0]
    label = MapFile(path).label_names()[0]
    for arguments in (["layers", "delete", path, layer], ["labels", "delete", path, label]):
        code, _, err = run(capsys, *arguments)
        assert code == 1 and "mesh_tool convert" in err
    new = tmp_path / "new.h5"
    assert run(capsys, "convert", path, new)[0] == 0
    assert run(capsys, "layers", "delete", new, layer)[0] == 0
    assert run(capsys, "labels", "delete", new, label)[0] == 0


@pytest.fixture
def labelled(tmp_path):
    """A map with labels that look like options, or like each other."""
    names = ["--", "-q", "--help", "-", "tree_1", "\u00a0tree_1", "tree_1\u200b"]
    mesh = Mesh(np.eye(3, dtype="f4"), np.uint32([[0, 1, 2]]))
    mesh.labels = {name: Label(np.zeros(1, np.uint32)) for name in names}
    MapFile.write(tmp_path / "labelled.h5", mesh)
    return tmp_path / "labelled.h5"


def test_labels_that_look_like_options(labelled, capsys):
    assert run(capsys, "labels", "rename", labelled, "--", "--", "dashes")[0] == 0
    assert run(capsys, "labels", "rename", labelled, "--", "-q", "--")[0] == 0
    assert run(capsys, "labels", "delete", labelled, "--", "--help", "-", "--")[0] == 0
    code, _, err = run(capsys, "labels", "delete", labelled, "--", "--")
    assert code == 1 and "there is no label '--'" in err
    assert run(capsys, "labels", "delete", labelled, "tree_1", "--", "dashes")[0] == 0
    with LabelStore(labelled) as store:
        assert set(store.names()) == {"\u00a0tree_1", "tree_1\u200b"}


def test_labels_that_look_alike_are_told_apart(labelled, capsys):
    lines = run(capsys, "labels", labelled)[1].splitlines()
    assert len(set(lines)) == len(lines)
    assert [line for line in lines if "tree" in line] == [
        "tree_1: 1 faces",
        "tree_1\\u200b: 1 faces",
        "\\xa0tree_1: 1 faces",
    ]
    code, _, err = run(capsys, "labels", "delete", labelled, "tree_2")
    assert code == 1 and "tree_1, tree_1\\u200b, \\xa0tree_1" in err


def test_who_saves_at_the_same_time_is_told_what_to_do(tmp_path, full_mesh, monkeypatch, capsys):
    path = MapFile.write(tmp_path / "a.h5", full_mesh).path

    def stage(self, text):
        if text.startswith("saving"):
            MapFile.write(path, Mesh(full_mesh.vertices + 1, full_mesh.faces), overwrite=True)

    monkeypatch.setattr(ProgressLine, "stage", stage)
    assert main(["layers", "rename", path, "height_diff", "mine"]) == 1
    text = "another program has replaced the mesh (nothing was saved: run it again)\n"
    assert capsys.readouterr().err.endswith(text)
    assert MapFile(path).layer_names() == []


def test_names_that_are_given_twice_are_one(tmp_path, full_mesh, capsys):
    path = MapFile.write(tmp_path / "a.h5", full_mesh).path
    assert main(["layers", "delete", path, "height_diff", "height_diff"]) == 0
    assert capsys.readouterr().out == path + ": deleted layer height_diff\n"
