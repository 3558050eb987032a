"""Labels of several maps, and of geometries whose map comes later or never."""
import os

import numpy as np
import pytest

from mesh_msgs_hdf5.label_manager.label_manager_options import LabelOptions, parse
from mesh_msgs_hdf5.label_manager.label_maps import LabelMaps, LooseLabels, loose_uuids
from mesh_msgs_hdf5.labels.label_store import LabelStore
from mesh_msgs_hdf5.map_file import MapFile
from mesh_msgs_hdf5.model.errors import MapFileError
from mesh_msgs_hdf5.model.mesh import Label

UUID = "7f3c1f1e-1111-4222-8333-444455556666"


def plain(labels):
    return {text: (label.faces.tolist(), label.color) for text, label in labels.items()}


@pytest.fixture
def path(tmp_path, full_mesh):
    full_mesh.labels = {"tree_1": Label(np.uint32([1, 2]), (9, 8, 7))}
    return MapFile.write(tmp_path / "a.h5", full_mesh).path


@pytest.fixture
def other_path(tmp_path, full_mesh):
    full_mesh.vertices[0] += 1
    return MapFile.write(tmp_path / "b.h5", full_mesh).path


@pytest.fixture
def folder(tmp_path):
    return tmp_path / "deep" / "labels"


def test_labels_without_a_map_are_kept(folder):
    """As ever, for a user of label_manager alone; in folders that need not exist (defect 10)."""
    maps = LabelMaps(folder)
    assert not folder.exists()
    labels = maps.find_or_make(UUID)
    labels.set("tree_1", [4_000_000_000, 5], color=(1, 2, 3))
    labels.set("tree_1", [6], override=False)
    labels.set("tree_2", [1])
    labels.delete("tree_2")
    assert not labels.dirty and labels.save() == 0 and maps.save() == ([], [])
    maps.close()
    assert os.listdir(folder) == [UUID + ".labels.journal"]
    maps = LabelMaps(folder)
    assert maps.uuids() == [UUID] and maps.find("") is maps.find(UUID)
    assert plain(maps.find(UUID).all()) == {"tree_1": ([5, 6, 4_000_000_000], (1, 2, 3))}
    maps.find(UUID).delete("tree_1")
    maps.close()
    assert os.listdir(folder) == []


def test_they_move_into_the_map_when_it_is_named(folder, path):
    uuid = MapFile(path).uuid
    maps = LabelMaps(folder)
    labels = maps.find_or_make(uuid)
    labels.set("tree_1", [5])
    labels.set("new_1", [7], color=(1, 1, 1))
    labels.set("bad_1", [60])  # the mesh has 60 faces
    maps.close()
    maps = LabelMaps(folder)
    store = maps.add(path)
    notes = "\n".join(maps.taken_notes())
    assert "2 labels moved" in notes and "label bad_1" in notes and maps.taken_notes() == []
    expected = {"new_1": ([7], (1, 1, 1)), "tree_1": ([1, 2, 5], (9, 8, 7))}
    assert maps.find(uuid) is store and plain(store.all()) == expected
    assert maps.save() == (["2 labels saved to %s" % path], [])
    maps.close()
    assert plain(MapFile(path).labels()) == expected
    with LooseLabels(folder, uuid) as rest:
        assert rest.names() == ["bad_1"]


def test_an_unknown_uuid_is_an_error_that_names_the_known(folder, path, other_path):
    maps = LabelMaps(folder)
    with pytest.raises(MapFileError, match="known: none"):
        maps.find(UUID)
    first = maps.add(path)
    assert maps.find("") is first and maps.find("mesh") is first and maps.find(first.uuid) is first
    assert maps.find_or_make("mesh") is first and maps.is_known("mesh")
    second = maps.add(other_path)
    for uuid in ("x", "", "mesh"):
        with pytest.raises(MapFileError) as refused:
            maps.find(uuid)
        assert refused.value.code == "uuid"
        assert first.uuid in str(refused.value) and second.uuid in str(refused.value)
    with pytest.raises(MapFileError, match="a UUID stands for one map"):
        maps.add(path)
    assert maps.find(first.uuid).set("a_1", [1]) is not None  # it still owns its labels
    maps.close()


def test_without_maps_mesh_is_a_uuid_like_any_other(folder):
    """Clients of mesh_msgs_hdf5 1.x call every geometry so."""
    maps = LabelMaps(folder)
    maps.find_or_make(UUID).set("a_1", [1])
    assert not maps.is_known("mesh")
    maps.find_or_make("mesh").set("b_1", [2])
    assert maps.find("mesh").names() == ["b_1"] and maps.find(UUID).names() == ["a_1"]
    with pytest.raises(MapFileError, match="several meshes"):
        maps.find_or_make("")
    maps.close()


@pytest.mark.parametrize(
    "uuid", ["../../etc/passwd", "/tmp/x", "..", ".", "a\nb", "ä", "a%2Fb", "-rf", " ", "\0"]
)
def test_a_uuid_never_leaves_the_folder(tmp_path, folder, uuid):
    """Defect 10: uuid and label went into paths as they were."""
    maps = LabelMaps(folder)
    maps.find_or_make(uuid).set("a_1", [1])
    maps.close()
    (name,) = os.listdir(folder)
    assert name.endswith(".labels.journal") and os.listdir(tmp_path) == ["deep"]
    assert loose_uuids(folder) == [uuid]
    assert LabelMaps(folder).find(uuid).names() == ["a_1"]


@pytest.mark.parametrize("kind", ["a link that leads out", "a folder"])
def test_what_others_put_in_place_of_a_journal_is_refused(tmp_path, folder, kind):
    """The default folder is in /tmp, where anybody may make one."""
    outside = tmp_path / "outside.journal"
    journal = folder / (UUID + ".labels.journal")
    folder.mkdir(parents=True)
    if kind == "a folder":
        journal.mkdir()
    else:
        journal.symlink_to(outside)
    maps = LabelMaps(folder)
    (note,) = maps.taken_notes()
    assert "leads out of the folder" in note or "is no regular file" in note
    with pytest.raises(MapFileError) as refused:
        maps.find_or_make(UUID)
    assert refused.value.code == "name" and not outside.exists()


@pytest.mark.parametrize("uuid", ["x" * 201, "ä" * 34, "\udcff", ""])
def test_a_uuid_that_makes_no_file_name_is_refused(folder, uuid):
    with pytest.raises(MapFileError) as refused:
        LabelMaps(folder).find_or_make(uuid)
    assert refused.value.code == "uuid" and not folder.exists()


def test_a_number_of_uuids_is_enough(folder, monkeypatch):
    monkeypatch.setattr("mesh_msgs_hdf5.label_manager.label_maps._MAX_LOOSE", 3)
    maps = LabelMaps(folder)
    for i in range(3):
        maps.find_or_make("u%d" % i)
    with pytest.raises(MapFileError, match="no more are kept"):
        maps.find_or_make("u3")
    maps.close()


def dat_folder(tmp_path, uuid):
    """What label_manager 1.x has left; returns the folder."""
    old = tmp_path / "old"
    for name in (uuid, "mesh", "stranger"):
        (old / name).mkdir(parents=True)
    (old / uuid / "tree_1.dat").write_bytes(b",5,3")
    (old / uuid / "house_1.dat").write_bytes(b"59")
    (old / uuid / "bad_1.dat").write_bytes(b"60")
    (old / uuid / "torn_1.dat").write_bytes(b"1,x")
    (old / "mesh" / "bush_1.dat").write_bytes(b"4")
    (old / "stranger" / "rock_1.dat").write_bytes(b"4000")
    return old


def test_old_labels_are_imported_on_request(tmp_path, folder, path):
    """Defect 8: the comma before the first face is no face 0."""
    old = dat_folder(tmp_path, MapFile(path).uuid)
    maps = LabelMaps(folder)
    store = maps.add(path)
    for _ in range(2):  # twice changes nothing
        lines = maps.import_folder(old)
        assert sum(line.startswith("not imported") for line in lines) == 2
        assert any("torn_1.dat" in line and "byte 2" in line for line in lines)
        assert any("bad_1.dat" in line and " 60" in line for line in lines)
        assert plain(store.all()) == {
            "bush_1": ([4], None),
            "house_1": ([59], None),
            "tree_1": ([1, 2, 3, 5], (9, 8, 7)),
        }
        assert plain(maps.find("stranger").all()) == {"rock_1": ([4000], None)}
    assert (old / "stranger" / "rock_1.dat").read_bytes() == b"4000"
    (tmp_path / "empty").mkdir()
    with pytest.raises(MapFileError, match="no folders of .dat files"):
        maps.import_folder(tmp_path / "empty")
    maps.close()


def test_old_labels_in_the_own_folder_are_there(tmp_path):
    """As the released launch file has it: ~folder_path is that of label_manager 1.x."""
    old = dat_folder(tmp_path, UUID)
    before = {path: path.read_bytes() for path in old.rglob("*.dat")}
    maps = LabelMaps(old)
    assert maps.uuids() == [UUID, "mesh", "stranger"]
    labels = maps.find(UUID)
    assert plain(labels.all()) == {
        "bad_1": ([60], None),
        "house_1": ([59], None),
        "tree_1": ([3, 5], None),
    }
    assert labels.groups() == ["bad", "house", "tree"] and list(labels.group("tree")) == ["tree_1"]
    notes = "\n".join(maps.taken_notes())
    assert "3 labels of label_manager 1.x" in notes and "torn_1.dat" in notes and "byte 2" in notes
    assert labels.delete("house_1").faces.tolist() == [59]
    labels.set("tree_1", [7], override=False)
    maps.close()
    maps = LabelMaps(old)  # what was deleted does not come back, what was added stays
    expected = {"bad_1": ([60], None), "tree_1": ([3, 5, 7], None)}
    assert plain(maps.find(UUID).all()) == expected
    maps.close()
    assert {path: path.read_bytes() for path in old.rglob("*.dat")} == before


def test_old_labels_in_the_own_folder_move_into_the_map_once(tmp_path, path):
    uuid = MapFile(path).uuid
    old = dat_folder(tmp_path, uuid)
    for start in range(2):
        maps = LabelMaps(old)
        store = maps.add(path)
        maps.move_to_the_only_map()
        notes = "\n".join(maps.taken_notes())
        assert ("2 labels moved" in notes and "1 labels moved" in notes) == (start == 0)
        assert "label bad_1" in notes  # of a face that the mesh does not have
        expected = {"bush_1": ([4], None), "house_1": ([59], None)}
        if not start:
            expected["tree_1"] = ([1, 2, 3, 5], (9, 8, 7))
        assert plain(store.all()) == expected == plain(maps.find("mesh").all())
        if not start:
            store.delete("tree_1")
        maps.save()
        maps.close()
    assert sorted(MapFile(path).label_names()) == ["bush_1", "house_1"]


def test_old_labels_for_any_mesh_stay_where_two_maps_are(tmp_path, path, other_path):
    maps = LabelMaps(dat_folder(tmp_path, UUID))
    for name in (path, other_path):
        maps.add(name)
    maps.move_to_the_only_map()
    assert maps.find("mesh").names() == ["bush_1"]
    maps.close()


def test_a_map_that_another_process_owns_is_read(folder, path):
    owner = LabelStore(path, owner_info={"node": "/server"})
    maps = LabelMaps(folder)
    store = maps.add(path)
    owner.set("a_1", [1])
    assert not store.is_owner and store.names() == ["a_1", "tree_1"] and maps.save() == ([], [])
    maps.close()
    assert owner.is_owner


def test_what_cannot_be_saved_is_said_and_the_rest_is_saved(folder, path, other_path, full_mesh):
    maps = LabelMaps(folder)
    for name in (path, other_path):
        maps.add(name).set("a_1", [1])
    full_mesh.vertices[1] += 1
    MapFile.write(path, full_mesh)
    saved, failed = maps.save()
    assert saved == ["1 labels saved to %s" % other_path]
    assert len(failed) == 1 and "another program has replaced the mesh" in failed[0]
    maps.close()


def test_a_replaced_map_without_edits_is_nothing_to_save(folder, path, full_mesh):
    maps = LabelMaps(folder)
    store = maps.add(path)
    full_mesh.vertices[0] += 1
    MapFile.write(path, full_mesh)
    assert maps.save() == ([], [])
    with pytest.raises(MapFileError, match="replaced the mesh"):
        store.set("tree_2", [1])
    maps.close()


def test_parameters(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert parse({}) == LabelOptions("/tmp/label_manager", [], None, "/tmp/label_manager", False)
    (tmp_path / "here.h5").write_bytes(b"")
    options = parse(
        {
            "folder_path": "labels/",
            "map_file": ["here.h5", "there.h5", "/a/b.h5"],
            "inputFile": "/a/b.h5",
            "mesh_part": 7,
            "import_folder": "old",
        }
    )
    here = str(tmp_path)
    assert options == LabelOptions(
        here + "/labels",
        [here + "/here.h5", here + "/labels/there.h5", "/a/b.h5"],
        "7",
        here + "/old",
        True,
    )
    assert parse({"map_file": "", "import_folder": ""}) == parse({})
    for name, value in (
        ("folder_path", 5),
        ("folder_path", "a\0"),
        ("import_folder", ["a"]),
        ("map_file", True),
        ("map_file", {"a": 1}),
        ("inputFile", ["a\0"]),
        ("mesh_part", [1]),
    ):
        with pytest.raises(ValueError, match="~" + name):
            parse({name: value})
