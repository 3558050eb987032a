"""The command mesh_tool on maps whose label edits stand in a journal."""
import json
import os

import h5py
import matplotlib.image
import numpy as np
import pytest
from map_samples import write_s0
from released_readers import labels_of_ros2

from mesh_msgs_hdf5.commands.mesh_tool import main
from mesh_msgs_hdf5.formats.importer import read_mesh
from mesh_msgs_hdf5.labels.label_store import LabelStore, journal_path
from mesh_msgs_hdf5.labels.map_contents import open_map
from mesh_msgs_hdf5.map_file import MapFile
from mesh_msgs_hdf5.model.mesh import Label

pytestmark = pytest.mark.usefixtures("read_here")

# what edit() makes of the labels of map_file
EDITED = {"new_1": ([7], (9, 9, 9)), "tree_1": ([0, 1], (0, 128, 255))}
FLOOR = {"desk_1": ([4], None)}


def run(capsys, *arguments):
    """(exit code, output, errors)"""
    code = main([str(argument) for argument in arguments])
    return (code, *capsys.readouterr())


def plain(labels):
    return {text: (sorted(label.faces.tolist()), label.color) for text, label in labels.items()}


def in_file(path, part=None):
    return plain(MapFile(path, part).labels())


def edit(path):
    """What a node that owned the labels, and was killed, has left."""
    with LabelStore(path, "mesh") as store:
        store.set("tree_1", [0, 1])
        store.delete("tree_2")
        store.set("new_1", [7], color=(9, 9, 9))
    with LabelStore(path, "floor2") as store:
        store.set("desk_1", [4])


@pytest.fixture
def path(tmp_path, full_mesh):
    """A map with two parts, whose labels are edited in their journals."""
    full_mesh.labels = {
        "tree_1": Label(np.uint32([5, 3]), (0, 128, 255)),
        "tree_2": Label(np.uint32([9])),
    }
    path = tmp_path / "a.h5"
    MapFile.write(path, full_mesh)
    with h5py.File(path, "r+") as file:
        file.copy("mesh", "floor2")
        del file["floor2/labels/tree"]
    edit(path)
    assert sorted(os.listdir(tmp_path)) == ["a.h5", "a.h5.floor2.journal", "a.h5.journal"]
    return path


@pytest.mark.parametrize("suffix", ["ply", "glb"])
def test_an_exported_mesh_has_them(path, tmp_path, capsys, suffix):
    out = tmp_path / ("a." + suffix)
    assert run(capsys, "export", path, out)[0] == 0
    assert plain(read_mesh(out)[0].labels) == EDITED
    assert run(capsys, "export", path, out, "--part", "floor2", "--force")[0] == 0
    assert plain(read_mesh(out)[0].labels) == FLOOR
    assert run(capsys, "diff", path, out, "--part", "floor2", "--ignore", "source")[:2] == (0, "")


def test_a_new_map_file_has_them_and_needs_no_journal(path, tmp_path, capsys):
    old = path.read_bytes(), (tmp_path / "a.h5.journal").read_bytes()
    for verb, *more in (["import", "--merge-vertices"], ["convert"], ["repack"]):
        new = tmp_path / verb / "new.h5"
        new.parent.mkdir()
        assert run(capsys, verb, path, new, *more)[0] == 0
        assert in_file(new, "mesh") == EDITED and os.listdir(new.parent) == ["new.h5"]
        if verb != "import":  # the other part is carried over, and its labels are not forgotten
            assert in_file(new, "floor2") == FLOOR
    assert (path.read_bytes(), (tmp_path / "a.h5.journal").read_bytes()) == old
    lvr2 = tmp_path / "lvr2.h5"
    assert run(capsys, "convert", path, lvr2, "--for", "lvr2", "--part", "floor2")[0] == 0
    assert (in_file(lvr2, "floor2"), in_file(lvr2, "mesh")) == (FLOOR, EDITED)
    ros2 = tmp_path / "ros2.h5"
    assert run(capsys, "convert", path, ros2, "--for", "ros2")[0] == 0
    assert (in_file(ros2, "mesh"), MapFile(ros2, "mesh").schema) == (EDITED, "S2")
    assert {t: sorted(f) for t, f in labels_of_ros2(ros2, "mesh").items()} == {
        text: faces for text, (faces, _) in EDITED.items()
    }


def test_a_map_with_large_labels_is_repacked_with_its_edits(tmp_path, capsys):
    """Of labels that are stored anew in another way, too."""
    from mesh_msgs import zoo

    from mesh_msgs_hdf5.model.mesh import Mesh

    grid = zoo.grid(60)
    many = np.arange(len(grid.faces), dtype=np.uint32)
    labels = {"big_1": Label(many), "big_2": Label(many[::2].copy()), "big_3": Label(many[1:])}
    MapFile.write(tmp_path / "a.h5", Mesh(grid.vertices, grid.faces, labels=labels))
    with LabelStore(tmp_path / "a.h5") as store:
        store.delete("big_1")
        store.set("big_2", many[:5000])
        expected = plain(store.all())
    for compression in ("none", "gzip"):
        out = tmp_path / (compression + ".h5")
        assert run(capsys, "repack", tmp_path / "a.h5", out, "--compression", compression)[0] == 0
        assert in_file(out) == expected
    assert sorted(expected) == ["big_2", "big_3"]


def test_info_counts_them_and_says_how_many(path, capsys):
    for more in ([], ["--fast"]):
        code, out, _ = run(capsys, "info", path, "--json", *more)
        found = json.loads(out)
        assert code == 0 and found["unsaved_labels"] == 3 and found["notes"] == []
        assert sorted(found["labels"]["classes"]) == ["new", "tree"]
        assert found["labels"]["count"] == 2
    assert found["arrays_read"] == []
    assert "  journal    3 label edits that are not in the file yet" in run(capsys, "info", path)[1]
    assert run(capsys, "repack", path)[0] == 0
    assert "journal" not in run(capsys, "info", path)[1]


def test_diff_and_render_see_them(path, tmp_path, capsys):
    folded = tmp_path / "folded.h5"
    run(capsys, "convert", path, folded)
    assert run(capsys, "diff", path, folded, "--part", "mesh")[:2] == (0, "")
    plain_copy = tmp_path / "copy.h5"
    plain_copy.write_bytes(path.read_bytes())
    code, out, _ = run(capsys, "diff", path, plain_copy, "--part", "mesh")
    assert code == 1 and {"new_1", "tree_1", "tree_2"} <= set(out.replace(":", "/").split("/"))
    pictures = []
    for source in (path, folded, plain_copy):
        picture = tmp_path / (source.name + ".png")
        arguments = ["--labels", "--size", "300x200", "--title", "", "--part", "mesh"]
        assert run(capsys, "render", source, picture, *arguments)[0] == 0
        pictures.append(matplotlib.image.imread(picture))
    assert np.array_equal(pictures[0], pictures[1])
    assert not np.array_equal(pictures[0], pictures[2])


def test_repack_in_place_puts_them_into_the_file(path, tmp_path, capsys):
    assert run(capsys, "repack", path)[0] == 0
    assert (in_file(path, "mesh"), in_file(path, "floor2")) == (EDITED, FLOOR)
    assert os.listdir(tmp_path) == ["a.h5"]


def test_repack_in_place_leaves_them_to_their_owner(path, tmp_path, capsys):
    with LabelStore(path, "mesh") as node:
        code, out, _ = run(capsys, "repack", path)
        assert code == 0 and "3 label edits stay in" in out and str(os.getpid()) in out
        assert in_file(path, "floor2") == FLOOR and in_file(path, "mesh") != EDITED
        assert plain(node.all()) == EDITED and node.save() == 3
    assert in_file(path, "mesh") == EDITED and os.listdir(tmp_path) == ["a.h5"]


def other_mesh(full_mesh, tmp_path):
    full_mesh.vertices[0] += 1
    MapFile.write(tmp_path / "b.h5", full_mesh)
    return tmp_path / "b.h5"


@pytest.mark.parametrize("verb", ["import", "convert", "repack"])
def test_what_would_lose_them_is_refused(full_mesh, tmp_path, capsys, verb):
    path = tmp_path / "a.h5"
    MapFile.write(path, full_mesh)
    with LabelStore(path) as store:
        store.set("new_1", [7])
        store.set("new_2", [8])
    other = other_mesh(full_mesh, tmp_path)
    before = path.read_bytes()
    code, _, err = run(capsys, verb, other, path, "--force")
    assert code == 1 and err.count("\n") == 1
    assert "2 label edits" in err and "a.h5.journal" in err and "mesh_tool repack" in err
    assert path.read_bytes() == before and (tmp_path / "a.h5.journal").exists()
    assert run(capsys, "repack", path)[0] == 0  # the way out
    assert sorted(in_file(path)) == ["new_1", "new_2"]
    assert run(capsys, verb, other, path, "--force")[0] == 0


def test_a_map_of_the_same_mesh_takes_them_over(full_mesh, tmp_path, capsys):
    path, source = tmp_path / "a.h5", tmp_path / "b.h5"
    for name in (path, source):
        MapFile.write(name, full_mesh)
    with LabelStore(path) as store:
        store.set("new_1", [7])
    assert run(capsys, "import", source, path, "--force")[0] == 0
    assert list(in_file(path)) == ["new_1"] and sorted(os.listdir(tmp_path)) == ["a.h5", "b.h5"]


def test_journals_that_belong_to_nothing_yet_count_too(full_mesh, tmp_path, capsys):
    """Of a map that somebody has removed, to make it anew."""
    path = tmp_path / "a.h5"
    MapFile.write(path, full_mesh)
    with LabelStore(path) as store:
        store.set("new_1", [7])
    os.unlink(path)
    code, _, err = run(capsys, "import", other_mesh(full_mesh, tmp_path), path)
    assert code == 1 and "1 label edits" in err and not path.exists()


def test_the_labels_of_a_map_of_another_schema(tmp_path, rich_mesh, capsys):
    path = tmp_path / "old.h5"
    write_s0(path, rich_mesh)
    with LabelStore(path) as store:
        store.set("new_1", [7])
        store.delete("tree_1")
        expected = plain(store.all())
    assert "old_s1.h5.journal" in run(capsys, "validate", path)[1].replace("%2F.", "")
    for _ in range(2):  # in the journal of the file beside it, then in that file
        out = tmp_path / "new.h5"
        assert run(capsys, "convert", path, out, "--force")[0] == 0
        assert in_file(out) == expected and "new_1" in expected and "tree_1" not in expected
        with LabelStore(path) as store:
            store.save()


def test_a_damaged_journal_is_said_in_one_line_and_the_rest_counts(path, tmp_path, capsys):
    journal = tmp_path / "a.h5.journal"
    lines = journal.read_bytes().splitlines(True)
    (number,) = [i for i, line in enumerate(lines) if b'"delete":"tree_2"' in line]
    lines[number] = lines[number].replace(b"tree_2", b"tree_3")
    journal.write_bytes(b"".join(lines))
    expected = dict(EDITED, tree_2=([9], None))
    said = "1 damaged lines of its label edits in %s are not shown" % journal
    out = tmp_path / "new.h5"
    for arguments in (
        ["export", path, tmp_path / "a.ply"],
        ["convert", path, out],
        ["info", path],
        ["render", path, tmp_path / "a.png", "--labels"],
        ["labels", path],
    ):
        code, told, _ = run(capsys, *arguments)
        assert code == 0 and told.count("note: " + said) + told.count("note       " + said) == 1
    code, _, told = run(capsys, "diff", path, out, "--part", "mesh")
    assert code == 0 and told.count(said) == 1
    assert in_file(out, "mesh") == expected == plain(read_mesh(tmp_path / "a.ply")[0].labels)
    code, told, _ = run(capsys, "validate", path)
    assert code == 0 and "a.h5.journal are damaged" in told


def test_a_journal_of_another_mesh_is_said_and_left(full_mesh, tmp_path, capsys):
    path = tmp_path / "a.h5"
    MapFile.write(path, full_mesh)
    with LabelStore(path) as store:
        store.set("new_1", [7])
    full_mesh.vertices[0] += 1
    MapFile.write(path, full_mesh)
    for arguments in (["export", path, tmp_path / "a.ply"], ["repack", path]):
        code, out, _ = run(capsys, *arguments)
        assert code == 0 and "label edits of another mesh" in out
    assert os.path.exists(journal_path(path))
    said = json.loads(run(capsys, "diff", path, path, "--json")[1])
    assert len([note for note in said["notes"] if "label edits of another mesh" in note]) == 2


def test_a_map_that_is_opened_sees_what_its_owner_does(path):
    contents = open_map(path, "mesh").members
    with LabelStore(path, "mesh") as node:
        assert plain(contents.labels()) == EDITED
        node.set("late_1", [3])
        assert plain({"": contents.label("late_1")}) == {"": ([3], None)}
        node.save()
        assert contents.unsaved_count == 0 and "late_1" in contents.label_names()
        assert "late_1" in contents.read(["labels"]).labels
        node.delete("late_1")
        assert contents.label_changes() == {"late_1": None}
