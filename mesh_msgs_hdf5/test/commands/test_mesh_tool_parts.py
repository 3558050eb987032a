"""The command mesh_tool: parts of a map file, and import into one of them."""
import hashlib
import json
import os

import h5py
import numpy as np
import pytest
from map_samples import assert_same_mesh, write_s0
from mesh_writers import SQUARE, ply, xyz
from raw_contents import raw_contents, without

from mesh_msgs_hdf5.commands.mesh_tool import main
from mesh_msgs_hdf5.labels.label_store import LabelStore, journal_path
from mesh_msgs_hdf5.map_file import MapFile
from mesh_msgs_hdf5.map_file.map_file import parts_of
from mesh_msgs_hdf5.model.mesh import Label, Mesh

pytestmark = pytest.mark.usefixtures("read_here")


def run(capsys, *arguments):
    """(exit code, output, errors)"""
    code = main([str(argument) for argument in arguments])
    return (code, *capsys.readouterr())


def labels(path, part=None):
    return {text: label.faces.tolist() for text, label in MapFile(path, part).labels().items()}


@pytest.fixture
def square(tmp_path):
    path = tmp_path / "square.ply"
    path.write_bytes(ply(xyz(SQUARE), [[0, 1, 2, 3]]))
    return path


@pytest.fixture
def path(tmp_path, strange_data, full_mesh):
    """A map of two parts and what other programs keep."""
    path = tmp_path / "a.h5"
    path.write_bytes(strange_data)
    full_mesh.labels = {"tree_1": Label(np.uint32([1, 2]))}
    MapFile.write_part(path, full_mesh, "floor2")
    return path


@pytest.fixture
def journalled(path):
    """The same; edits of the labels of floor2 stand in its journal."""
    with LabelStore(path, "floor2") as store:
        store.set("new_1", [7])
        store.delete("tree_1")
    return path


def test_a_list_of_the_parts(journalled, capsys):
    path = journalled
    for words in (["parts"], ["parts", "list"]):
        code, out, _ = run(capsys, *words, path)
        assert code == 0 and out.splitlines() == [
            "floor2: 40 vertices, 60 faces, 1 labels, frame floor_2, 2 label edits in the journal",
            "mesh: 40 vertices, 60 faces, 9 labels, frame floor_2",
        ]
    found = json.loads(run(capsys, "parts", path, "--json")[1])
    assert found["parts"][0] == {
        "part": "floor2",
        "schema": "S1",
        "vertices": 40,
        "faces": 60,
        "labels": 1,
        "unsaved_labels": 2,
        "frame_id": "floor_2",
        "uuid": MapFile(path, "floor2").uuid,
    }


def test_add_rename_copy_and_delete(path, square, tmp_path, capsys):
    before = raw_contents(path)
    code, out, _ = run(capsys, "parts", "add", path, "b/new", square)
    assert code == 0 and out.startswith("  note: 1 faces of more than three corners were cut")
    assert out.endswith("%s: added part b/new\n" % path)
    assert MapFile(path, "b/new").vertex_count == 4
    assert run(capsys, "parts", "rename", path, "b/new", "c", "-q") == (0, "", "")
    assert run(capsys, "parts", "copy", path, "c", "d")[0] == 0
    assert run(capsys, "parts", "copy", path, "mesh", "--from", path)[0] == 1
    assert parts_of(path) == ["c", "d", "floor2", "mesh"]
    code, out, _ = run(capsys, "parts", "delete", path, "c", "d", "--json")
    assert code == 0 and json.loads(out)["done"] == "deleted part c, d"
    assert without(raw_contents(path), ["/b"]) == before
    other = tmp_path / "other.h5"
    run(capsys, "import", square, other)
    assert run(capsys, "parts", "copy", other, "floor2", "--from", path)[0] == 0
    assert parts_of(other) == ["floor2", "mesh"]
    assert_same_mesh(MapFile(other, "floor2").read(), MapFile(path, "floor2").read())
    assert sorted(os.listdir(tmp_path)) == ["a.h5", "other.h5", "square.ply"]


@pytest.mark.parametrize(
    "arguments,words",
    [
        (["rename", "MAP", "floor3", "x"], "parts of this file: floor2, mesh"),
        (["rename", "MAP", "floor2", "mesh"], "there is /mesh in it already"),
        (["delete", "MAP", "floor2", "floor3"], "parts of this file: floor2, mesh"),
        (["delete", "MAP", "floor2", "mesh"], "no mesh would be left in it (--force"),
        (["copy", "MAP", "floor2"], "a name of its own"),
        (["copy", "MAP", "floor2", "mesh"], "there is /mesh in it already"),
        (
            ["copy", "MAP", "floor2", "raw"],
            "a part cannot be called raw: the file keeps this name for the scans",
        ),
        (["add", "MAP", "floor2", "PLY"], "use --force to replace it"),
        (["add", "MAP", "floor2/b", "PLY"], "inside the other"),
        (["add", "nothing.h5", "b", "PLY"], "no such file"),
        (["add", "MAP", "b", "nothing.ply"], "no such file"),
        (["list", "nothing.h5"], "no such file"),
    ],
)
def test_what_cannot_be_done_is_one_line_and_changes_nothing(
    path, square, capsys, arguments, words
):
    before = hashlib.sha256(path.read_bytes()).digest()
    meant = {"MAP": path, "PLY": square}
    code, out, err = run(capsys, "parts", *[meant.get(word, word) for word in arguments])
    assert (code, out) == (1, "") and words in err, err
    assert err.startswith("mesh_tool: error: ") and err.count("\n") == 1
    assert hashlib.sha256(path.read_bytes()).digest() == before
    assert sorted(os.listdir(path.parent)) == ["a.h5", "square.ply"]


@pytest.mark.parametrize("option", ["--part", "--to-part"])
def test_import_changes_the_part_that_is_named_and_nothing_else(path, square, capsys, option):
    before = raw_contents(path)
    code, _, err = run(capsys, "import", square, path, option, "floor2")
    assert code == 1 and "/floor2" in err and "--force" in err and raw_contents(path) == before
    assert run(capsys, "import", square, path, option, "floor2", "--force")[0] == 0
    assert MapFile(path, "floor2").vertex_count == 4
    assert without(raw_contents(path), ["/floor2"]) == without(before, ["/floor2"])
    assert run(capsys, "import", square, path, option, "floor3", "--frame", "odom")[0] == 0
    assert parts_of(path) == ["floor2", "floor3", "mesh"]
    assert MapFile(path, "floor3").frame_id == "odom"
    new = path.parent / "new.h5"
    assert run(capsys, "import", square, new, option, "floor2")[0] == 0
    assert parts_of(new) == ["floor2"]


def test_a_part_of_one_map_into_another_map(path, square, tmp_path, capsys):
    other = tmp_path / "other.h5"
    run(capsys, "import", square, other)
    assert run(capsys, "import", path, other, "--part", "floor2", "--to-part", "upper")[0] == 0
    assert_same_mesh(MapFile(other, "upper").read(), MapFile(path, "floor2").read())
    assert MapFile(other).vertex_count == 4


def test_what_would_be_lost_with_the_whole_file_is_named(path, square, tmp_path, capsys):
    before = path.read_bytes()
    code, _, err = run(capsys, "import", square, path, "--force")
    assert code == 1 and "1 other part (floor2) and" in err and "/raw" in err and "--to-part" in err
    for verb in ("convert", "repack"):
        source = tmp_path / "one.h5"
        MapFile.write(source, Mesh(SQUARE, np.uint32([[0, 1, 2]])))
        code, _, err = run(capsys, verb, source, path, "--force")
        assert code == 1 and "1 other part (floor2)" in err and err.count("\n") == 1
    assert path.read_bytes() == before
    for verb in ("convert", "repack"):  # to the file that it was made of before
        for _ in range(2):
            assert run(capsys, verb, path, tmp_path / "new.h5", "--force")[0] == 0
    run(capsys, "parts", "delete", path, "floor2")
    code, _, err = run(capsys, "import", square, path, "--force")
    assert code == 1 and "other objects (/" in err and "other part" not in err
    alone = tmp_path / "alone.h5"
    MapFile.write(alone, Mesh(SQUARE, np.uint32([[0, 1, 2]])), part="upper")
    assert run(capsys, "import", square, alone, "--force")[0] == 0  # it is what FILE stands for


def test_a_renamed_part_takes_its_label_edits_along(journalled, capsys):
    assert run(capsys, "parts", "rename", journalled, "floor2", "second")[0] == 0
    assert labels(journalled, "second") == {"new_1": [7]}
    assert os.listdir(journalled.parent) == ["a.h5"]


def test_a_copied_part_has_the_label_edits(journalled, tmp_path, capsys):
    path, other = journalled, tmp_path / "other.h5"
    assert run(capsys, "parts", "copy", path, "floor2", "second")[0] == 0
    MapFile.write(other, Mesh(SQUARE, np.uint32([[0, 1, 2]])))
    with LabelStore(path, "floor2") as node:  # also while a node owns them
        assert run(capsys, "parts", "copy", other, "floor2", "--from", path)[0] == 0
        assert node.names() == ["new_1"]
    assert labels(path, "second") == labels(other, "floor2") == {"new_1": [7]}
    assert labels(path, "floor2") == {"tree_1": [1, 2]}  # until its journal is saved
    assert os.path.exists(journal_path(path, "floor2"))


def test_a_deleted_part_takes_its_journal_along(journalled, square, capsys):
    code, out, _ = run(capsys, "parts", "delete", journalled, "floor2")
    assert code == 0 and "note: with 2 label edits of part floor2 in its journal" in out
    assert sorted(os.listdir(journalled.parent)) == ["a.h5", "square.ply"]
    assert run(capsys, "parts", "add", journalled, "floor2", square)[0] == 0
    assert labels(journalled, "floor2") == {}


@pytest.mark.parametrize("action", [["rename", "MAP", "floor2", "b"], ["delete", "MAP", "floor2"]])
def test_the_part_of_a_node_that_owns_its_labels_stays(journalled, capsys, action):
    before = journalled.read_bytes()
    with LabelStore(journalled, "floor2", {"node": "/server"}) as node:
        words = [journalled if word == "MAP" else word for word in action]
        code, _, err = run(capsys, "parts", *words)
        assert code == 1 and "/server" in err and err.count("\n") == 1
        assert node.names() == ["new_1"] and journalled.read_bytes() == before


def test_label_edits_of_a_replaced_part_are_not_lost(journalled, square, tmp_path, capsys):
    path = journalled
    before = path.read_bytes()
    for words in (["parts", "add", path, "floor2", square], ["import", square, path, "--part"]):
        words += ["--force"] if words[0] == "parts" else ["floor2", "--force"]
        code, _, err = run(capsys, *words)
        assert code == 1 and "2 label edits of the mesh floor2" in err and "repack" in err
    assert path.read_bytes() == before
    same = tmp_path / "same.h5"  # the same geometry: they count for that
    mesh = MapFile(path, "floor2").read()
    mesh.labels = {"tree_1": Label(np.uint32([1])), "tree_2": Label(np.uint32([2]))}
    MapFile.write(same, mesh)
    assert run(capsys, "parts", "add", path, "floor2", same, "--force")[0] == 0
    assert labels(path, "floor2") == {"new_1": [7], "tree_2": [2]}
    assert not os.path.exists(journal_path(path, "floor2"))


def test_a_journal_of_the_new_name_is_in_the_way(path, full_mesh, capsys):
    """Of a part that another program has removed."""
    MapFile.write_part(path, full_mesh, "gone")
    with LabelStore(path, "gone") as store:
        store.set("new_1", [7])
    with h5py.File(path, "r+") as file:
        del file["gone"]
    for words in (["rename", path, "floor2", "gone"], ["copy", path, "floor2", "gone"]):
        code, _, err = run(capsys, "parts", *words)
        assert code == 1 and "1 label edits of the mesh gone" in err
    assert parts_of(path) == ["floor2", "mesh"]


def test_parts_of_a_map_of_another_schema(tmp_path, rich_mesh, square, capsys):
    path = tmp_path / "old.h5"
    write_s0(path, rich_mesh)
    assert "schema S0" in run(capsys, "parts", path)[1]
    code, _, err = run(capsys, "parts", "delete", path, "/")
    assert code == 1 and "mesh_tool convert" in err
    assert run(capsys, "parts", "add", path, "upper", square)[0] == 0
    assert parts_of(path) == ["", "upper"]
    assert run(capsys, "parts", "rename", path, "upper", "lower")[0] == 0
    assert run(capsys, "parts", "delete", path, "lower")[0] == 0
    assert parts_of(path) == [""]


def test_a_part_in_a_national_grid_keeps_its_digits(path, tmp_path, capsys):
    far = tmp_path / "far.obj"
    corners = ((0, 0), (0.25, 0), (0, 0.25))
    lines = ["v %.2f %.2f 1" % (365430.25 + x, 5801230.5 + y) for x, y in corners]
    far.write_text("\n".join(lines + ["f 1 2 3", ""]))
    code, out, _ = run(capsys, "parts", "add", path, "far", far)
    assert code == 0 and "was subtracted from the coordinates" in out
    file = MapFile(path, "far")
    found = file.vertices[:, :2] + np.float64(file.origin[:2])
    assert np.abs(found - np.add(corners, (365430.25, 5801230.5))).max() < 1e-6


@pytest.mark.parametrize(
    "words",
    [
        ["parts", "add", "{map}", "mesh", "{new}", "--force"],
        ["import", "{new}", "{map}", "--to-part", "mesh", "--force"],
        ["import", "{new}", "{map}", "--force"],
    ],
)
def test_what_goes_with_a_mesh_that_is_replaced_is_said(tmp_path, rich_mesh, capsys, words):
    new = Mesh(rich_mesh.vertices[:, ::-1].copy(), rich_mesh.faces)
    new.labels = {"tree_1": rich_mesh.labels["tree_1"]}
    paths = {"map": str(tmp_path / "map.h5"), "new": str(tmp_path / "new.h5")}
    for name, mesh in (("map", rich_mesh), ("new", new)):
        MapFile.write(paths[name], mesh)
    assert main([word.format(**paths) for word in words]) == 0
    (line,) = [line for line in capsys.readouterr().out.splitlines() if "gone with" in line]
    assert line.startswith("  note: gone with the mesh that was replaced: 8 labels (")
    assert ", 2 layers (Grün und weich, height_diff), 10 attributes (" in line
    assert main([word.format(**paths) for word in words]) == 0
    assert "gone with" not in capsys.readouterr().out  # there is nothing to lose
