"""Labels of a map: what an edit returns is safe, and nobody's labels are lost."""
import errno
import os
import shutil
import subprocess
import sys
import threading
from pathlib import Path

import numpy as np
import pytest

from mesh_msgs_hdf5.labels import label_edits

from mesh_msgs_hdf5.model.edit import Edit
from mesh_msgs_hdf5.model.errors import MapFileError
from mesh_msgs_hdf5.labels.label_store import LabelStore, journal_path, label_target
from mesh_msgs_hdf5.map_file import MapFile
from mesh_msgs_hdf5.model.mesh import Label, Mesh
from mesh_msgs_hdf5.map_file.reading import label_reader

pytestmark = pytest.mark.usefixtures("read_here")

FACES = 60


def plain(labels):
    return {text: (label.faces.tolist(), label.color) for text, label in labels.items()}


def label(*faces, color=None):
    return Label(np.array(faces, np.uint32), color)


@pytest.fixture
def path(tmp_path, full_mesh):
    full_mesh.labels = {"tree_1": label(5, 3, color=(1, 2, 3)), "house_1": label(7)}
    return MapFile.write(tmp_path / "a.h5", full_mesh).path


@pytest.fixture
def in_this_process(monkeypatch):
    """Map files are read in this process, so that what a test replaces is used."""
    monkeypatch.setattr("mesh_msgs_hdf5.labels.label_store.IsolatedMapFile", MapFile)
    return MapFile


def listed(path):
    return sorted(os.listdir(os.path.dirname(path)))


def in_file(path):
    return plain(MapFile(path).labels())


def test_labels_of_the_file_with_edits_on_top(path):
    with LabelStore(path) as store:
        assert store.is_owner and store.owner is None and store.refusal is None and not store.notes
        assert store.names() == ["house_1", "tree_1"] and not store.dirty
        assert plain({"": store.get("tree_1")}) == {"": ([5, 3], (1, 2, 3))}
        made = store.set("tree_10", [9, 8, 9, 1], color=(0, 0, 255))
        assert plain({"": made}) == {"": ([1, 8, 9], (0, 0, 255))}
        store.set("tree_2", np.array([4], np.int64))
        assert plain({"": store.delete("house_1")}) == {"": ([7], None)}
        expected = {
            "tree_1": ([5, 3], (1, 2, 3)),
            "tree_2": ([4], None),
            "tree_10": ([1, 8, 9], (0, 0, 255)),
        }
        assert plain(store.all()) == expected and list(store.all()) == list(expected)
        assert store.dirty and plain(MapFile(path).labels()) != expected
        assert store.save() == 3 and not store.dirty and store.save() == 0
        assert plain(store.all()) == expected == in_file(path)
    assert listed(path) == ["a.h5"]


def test_what_is_set_adds_to_or_replaces_what_is_there(path):
    """Defect 6 (override ignored) and 10 (override with no faces does not clear)."""
    with LabelStore(path) as store:
        assert store.set("tree_1", [4, 5], override=False).faces.tolist() == [3, 4, 5]
        assert store.set("tree_1", [], override=False).faces.tolist() == [3, 4, 5]
        assert store.set("tree_1", [9]).faces.tolist() == [9]
        cleared = store.set("tree_1", [])
        assert cleared.faces.tolist() == [] and cleared.color == (1, 2, 3)  # colors persist
        store.set("house_1", [1], color=(9, 9, 9))
        store.save()
    expected = {"house_1": ([1], (9, 9, 9)), "tree_1": ([], (1, 2, 3))}
    assert in_file(path) == expected
    with LabelStore(path) as store:
        assert plain(store.all()) == expected


@pytest.mark.parametrize("override", [True, False])
def test_no_faces_make_no_label(path, override):
    """A deleted label would come back, where two nodes hear of the edit that empties it."""
    with LabelStore(path) as store:
        store.delete("tree_1")
        assert store.set("tree_1", [], override=override).faces.tolist() == []
        assert "tree_1" not in store.names()
        store.save()
        assert "tree_1" not in store.names() and "tree_1" not in in_file(path)
        store.set("tree_1", [], color=(1, 2, 3))  # who gives it a color wants it
        assert "tree_1" in store.names()


def test_a_union_of_many_faces(tmp_path, path):
    """Defect 10: every face was compared with every other."""
    count = 200_000
    mesh = Mesh(np.eye(3, dtype=np.float32), np.tile(np.uint32([0, 1, 2]), (count, 1)))
    MapFile.write(tmp_path / "b.h5", mesh)
    with LabelStore(tmp_path / "b.h5") as store:
        store.set("a_1", np.arange(0, count, 2))
        both = store.set("a_1", np.arange(count - 1, -1, -1), override=False)
        np.testing.assert_array_equal(both.faces, np.arange(count))


def test_groups_are_exact(path):
    """Defect 10: "tree" matched treehouse_1."""
    with LabelStore(path) as store:
        store.set("treehouse_1", [1])
        store.set("tree", [2])
        store.set("tree_1_b", [3])
        assert store.groups() == ["house", "tree", "treehouse"]
        assert list(store.group("tree")) == ["tree", "tree_1", "tree_1_b"]
        assert list(store.group("treehouse")) == ["treehouse_1"]
        assert store.group("tre") == {} == store.group("")


@pytest.mark.parametrize(
    "text,faces,color,code,words",
    [
        ("a/b", [1], None, "label", "slash"),
        ("..", [1], None, "label", "label '..'"),
        ("", [1], None, "label", "empty"),
        ("a\n1", [1], None, "label", "control character"),
        ("x" * 256, [1], None, "label", "has 256 bytes"),
        ("a_1", [3, FACES, 70], None, "index", "entry 1"),
        ("a_1", [3, -1], None, "index", "-1"),
        ("a_1", [0.5], None, "dtype", ""),
        ("a_1", [[1, 2]], None, "shape", ""),
        ("a_1", [1], (1, 2), "value", "color"),
        ("a_1", [1], (1, 2, 256), "value", "color"),
    ],
)
def test_what_is_no_label_is_refused(path, text, faces, color, code, words):
    with LabelStore(path) as store:
        with pytest.raises(MapFileError, match=words) as refused:
            store.set(text, faces, color)
        assert refused.value.code == code and not store.dirty
    assert listed(path) == ["a.h5"]


def test_an_unknown_label_is_an_error_that_names_near_ones(path):
    with LabelStore(path) as store:
        for call in (store.get, store.delete):
            with pytest.raises(MapFileError, match="did you mean tree_1?") as refused:
                call("tree_11")
            assert refused.value.code == "label"
            with pytest.raises(MapFileError, match="labels: house_1, tree_1"):
                call("zzz")
        assert not store.dirty


def test_no_more_labels_than_are_read_again(path, monkeypatch):
    monkeypatch.setattr(label_edits, "MAX_LABELS", 3)
    with LabelStore(path) as store:
        store.set("a_1", [1])
        store.set("a_1", [2])
        with pytest.raises(MapFileError) as refused:
            store.set("a_2", [1])
        assert refused.value.code == "size"
    assert label_reader.MAX_LABELS >= 10_000


def test_edits_are_there_after_a_crash(path):
    program = (
        "import sys, os; from mesh_msgs_hdf5.labels.label_store import LabelStore\n"
        "store = LabelStore(sys.argv[1])\n"
        "store.set('tree_1', [1]); store.set('new_1', [2], (7, 8, 9)); store.delete('house_1')\n"
        "os.kill(os.getpid(), 9)"
    )
    subprocess.run([sys.executable, "-c", program, path], check=False, timeout=60)
    expected = {"new_1": ([2], (7, 8, 9)), "tree_1": ([1], (1, 2, 3))}
    with LabelStore(path, read_only=True) as reader:
        assert plain(reader.all()) == expected and not reader.is_owner and reader.owner is None
    for _ in range(2):
        with LabelStore(path) as store:
            assert plain(store.all()) == expected and store.dirty
            assert len(store.notes) == 1 and "3 label edits" in store.notes[0]
    with LabelStore(path) as store:
        store.save()
    assert in_file(path) == expected and listed(path) == ["a.h5"]


def test_a_crash_between_saving_and_emptying_the_journal(path, monkeypatch):
    with LabelStore(path) as store:
        store.set("tree_1", [1])
        store.delete("house_1")
        journal = Path(store.journal_path).read_bytes()
        store.save()
        after = in_file(path)
    Path(journal_path(path)).write_bytes(journal)
    with LabelStore(path) as store:
        assert plain(store.all()) == after
        store.save()
    assert in_file(path) == after and listed(path) == ["a.h5"]


def test_labels_of_another_program_survive(path, monkeypatch, in_this_process):
    """It saves the map before this one does, and while this one does."""
    with LabelStore(path) as store:
        store.set("ours_1", [1])
        MapFile(path).update(Edit(labels={"theirs_1": label(2), "house_1": None}))
        assert store.names() == ["ours_1", "theirs_1", "tree_1"]
        original, calls = MapFile.update, []

        def update(self, edit):
            if not calls:
                calls.append(1)
                original(MapFile(path), Edit(labels={"late_1": label(3)}))
                raise MapFileError("changed", path, "another program saved it meanwhile", "")
            original(self, edit)

        monkeypatch.setattr(MapFile, "update", update)
        store.save()
        expected = ["late_1", "ours_1", "theirs_1", "tree_1"]
        assert store.names() == expected and not store.dirty
    assert list(in_file(path)) == expected


def test_an_edit_during_a_save_waits_for_the_next_one(path, monkeypatch, in_this_process):
    with LabelStore(path) as store:
        store.set("a_1", [1])
        store.set("a_2", [2])
        original, blocked = MapFile.update, []

        def update(self, edit):
            thread = threading.Thread(target=lambda: blocked.append(store.set("a_2", [9])))
            thread.start()
            thread.join(20)
            assert len(blocked) == 1  # it did not wait
            original(self, edit)

        with monkeypatch.context() as patch:
            patch.setattr(MapFile, "update", update)
            store.save()
        assert store.dirty and store.get("a_2").faces.tolist() == [9]
        assert in_file(path)["a_2"] == ([2], None)
        again = os.path.join(os.path.dirname(path), "b.h5")  # as after a crash
        shutil.copy(path, again)
        shutil.copy(store.journal_path, journal_path(again))
        with LabelStore(again) as crashed:
            assert crashed.get("a_2").faces.tolist() == [9]
            assert crashed.get("a_1").faces.tolist() == [1]


def test_a_replaced_mesh_is_refused_and_the_journal_kept(path, full_mesh):
    store = LabelStore(path)
    store.set("ours_1", [59])
    full_mesh.vertices[0] += 1
    full_mesh.labels = {}
    MapFile.write(path, full_mesh)
    for call in (store.save, store.names, lambda: store.set("b_1", [1])):
        with pytest.raises(MapFileError, match="another program has replaced the mesh") as refused:
            call()
        assert refused.value.code == "changed"
    store.close()
    with pytest.raises(MapFileError, match="edits of another mesh") as refused:
        LabelStore(path)
    assert refused.value.code == "journal"
    with LabelStore(path, read_only=True) as reader:
        assert reader.names() == [] and "edits of another mesh" in reader.notes[0]
    assert listed(path) == ["a.h5", "a.h5.journal"] and in_file(path) == {}


@pytest.mark.parametrize("when", ["update", "clear"])
def test_a_failing_save_keeps_everything(path, monkeypatch, when, in_this_process):
    def fail(*_):
        raise OSError(errno.ENOSPC, "No space left on device")

    def refuse(*_):
        raise MapFileError("save", path, "no space left", "")

    with LabelStore(path) as store:
        store.set("a_1", [1])
        with monkeypatch.context() as patch:
            if when == "update":
                patch.setattr(MapFile, "update", refuse)
            else:
                patch.setattr("mesh_msgs_hdf5.labels.journal.cut", fail)
            with pytest.raises(MapFileError, match="space left") as refused:
                store.save()
            assert refused.value.code == "save"
        assert store.dirty and "a_1" in store.names()
        store.save()
        assert not store.dirty
    assert "a_1" in in_file(path) and listed(path) == ["a.h5"]


def test_a_full_disk_changes_nothing(path, monkeypatch):
    with LabelStore(path) as store:
        store.set("a_1", [1])

        def fail(*_):
            raise OSError(errno.ENOSPC, "No space left on device")

        with monkeypatch.context() as patch:
            patch.setattr("mesh_msgs_hdf5.labels.journal_files.os.write", fail)
            for call in (lambda: store.set("a_1", [2]), lambda: store.delete("tree_1")):
                with pytest.raises(MapFileError, match="nothing was changed.*make room"):
                    call()
        assert store.get("a_1").faces.tolist() == [1] and "tree_1" in store.names()
        store.set("a_1", [2])


def test_one_owner_whom_the_others_follow(path):
    owner = LabelStore(path, owner_info={"node": "/map_server", "topic": "/cluster_label"})
    other = LabelStore(path)
    assert not other.is_owner and other.owner["node"] == "/map_server"
    assert other.owner["pid"] == os.getpid() and other.owner["topic"] == "/cluster_label"
    for call in (lambda: other.set("a_1", [1]), lambda: other.delete("tree_1"), other.save):
        with pytest.raises(MapFileError, match="edited by /map_server") as refused:
            call()
        assert refused.value.code == "owned"
    owner.set("a_1", [1, 2])
    assert other.get("a_1").faces.tolist() == [1, 2] and not other.dirty
    owner.save()
    owner.delete("tree_1")
    assert other.names() == ["a_1", "house_1"] == owner.names()
    owner.close()
    assert other.owner is None and other.names() == ["a_1", "house_1"]
    assert other.set("a_1", [3]).faces.tolist() == [3] and other.is_owner  # takes over
    assert "tree_1" not in other.names()
    other.close()
    with LabelStore(path, read_only=True) as reader:
        with pytest.raises(MapFileError, match="read only"):
            reader.set("a_1", [1])
        assert plain(reader.all())["a_1"] == ([3], None)


def test_two_parts_have_two_owners(tmp_path, path):
    import h5py

    with h5py.File(path, "r+") as file:
        file.copy("mesh", "other")
    with LabelStore(path) as one, LabelStore(path, "other") as other:
        assert one.is_owner and other.is_owner and one.journal_path != other.journal_path
        one.set("one_1", [1])
        other.set("other_1", [2])
        one.save()
        other.save()
    assert "one_1" in in_file(path) and "other_1" not in in_file(path)
    assert "other_1" in MapFile(path, "other").label_names()


def test_threads_lose_nothing(path):
    with LabelStore(path) as store:

        def work(number):
            for i in range(20):
                store.set("t_%d" % number, [i], override=False)
                store.names()
                if number == 0 and i % 8 == 0:
                    store.save()

        threads = [threading.Thread(target=work, args=(number,)) for number in range(4)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join(100)
        for number in range(4):
            assert store.get("t_%d" % number).faces.tolist() == list(range(20))
        store.save()
    assert {"t_%d" % number: (list(range(20)), None) for number in range(4)}.items() <= in_file(
        path
    ).items()


def test_a_long_journal_is_written_anew(path, monkeypatch):
    monkeypatch.setattr(label_edits, "_SMALL", 4000)
    with LabelStore(path) as store:
        sizes = []
        for i in range(200):
            store.set("a_%d" % (i % 3), [i % FACES])
            sizes.append(os.path.getsize(store.journal_path))
        store.set("b_1", [1])
        store.delete("b_1")
        assert max(sizes) < 6000
        expected = plain(store.all())
    with LabelStore(path) as store:
        assert plain(store.all()) == expected


def test_a_removed_journal_is_made_again(path):
    with LabelStore(path) as store:
        store.set("a_1", [1])
        os.unlink(store.journal_path)
        store.set("a_2", [2])
        assert {"a_1", "a_2"} < set(LabelStore(path, read_only=True).names())


@pytest.mark.parametrize("size", [0, 100, 10000])
@pytest.mark.parametrize("next_step", ["edit", "close"])
def test_a_journal_that_somebody_has_changed_is_made_again(path, size, next_step):
    with LabelStore(path) as store:
        store.set("a_1", [1])
        os.truncate(store.journal_path, size)
        assert store.file_notes() == []
        if next_step == "edit":
            store.set("a_2", [2])
            (note,) = store.file_notes()
            assert "changed (%d bytes, were" % size in note and "by another program" in note
            store.set("a_3", [3])
            assert store.file_notes() == [note]  # it is whole
    with LabelStore(path, read_only=True) as found:
        assert {"a_1", "a_2", "a_3"} & set(found.names()) == (
            {"a_1", "a_2", "a_3"} if next_step == "edit" else {"a_1"}
        )
        assert found.notes == []  # nothing is damaged


def test_a_read_only_folder_is_said_and_labels_are_read(path, monkeypatch):
    original = os.open

    def refuse(name, flags, *arguments, **more):
        if flags & os.O_CREAT:
            raise OSError(errno.EROFS, "Read-only file system")
        return original(name, flags, *arguments, **more)

    with monkeypatch.context() as patch:
        patch.setattr("mesh_msgs_hdf5.labels.journal_files.os.open", refuse)
        store = LabelStore(path)
        assert not store.is_owner and store.names() == ["house_1", "tree_1"]
        assert len(store.notes) == 1 and "Read-only file system" in store.notes[0]
        with pytest.raises(MapFileError, match="copy the map to another folder"):
            store.set("a_1", [1])
        assert store.refusal.code == "save" and len(store.notes) == 1
    store.set("a_1", [1])  # there is room again
    store.close()


def test_a_link_to_a_map_has_the_same_owner(tmp_path, path):
    (tmp_path / "elsewhere").mkdir()
    os.symlink(path, tmp_path / "elsewhere" / "link.h5")
    with LabelStore(tmp_path / "elsewhere" / "link.h5") as store:
        store.set("a_1", [1])
        assert not LabelStore(path).is_owner
        store.save()
    assert "a_1" in in_file(path) and os.listdir(tmp_path / "elsewhere") == ["link.h5"]


def test_labels_of_a_mesh_go_to_a_map_beside_it(tmp_path):
    from mesh_writers import SQUARE, TWO_FACES, ply, xyz

    source = tmp_path / "garden.ply"
    source.write_bytes(ply(xyz(SQUARE), TWO_FACES))
    target = str(tmp_path / "garden.h5")
    assert label_target(source) == target
    with LabelStore(source) as store:
        assert (store.path, store.names(), store.face_count) == (target, [], 2)
        store.set("a_1", [1], color=(1, 2, 3))
    assert listed(target) == ["garden.h5.journal", "garden.ply"]
    with LabelStore(source) as store:
        assert store.names() == ["a_1"]
        store.save()
        assert store.names() == ["a_1"]
        store.set("a_2", [0])
    assert in_file(target) == {"a_1": ([1], (1, 2, 3))}
    with LabelStore(target) as store:  # the same labels, whichever is named
        assert store.names() == ["a_1", "a_2"]
        store.save()
    assert MapFile(target).read().uuid == store.uuid
    assert listed(target) == ["garden.h5", "garden.ply"]
    source.write_bytes(ply(xyz(SQUARE + 1), TWO_FACES))
    with pytest.raises(MapFileError, match="holds another mesh") as refused:
        LabelStore(source)
    assert refused.value.code == "exists"


def test_labels_of_an_old_map_go_to_a_map_beside_it(tmp_path, full_mesh):
    import h5py

    path = tmp_path / "old.h5"
    with h5py.File(path, "w") as file:  # schema S0
        for name in ("geometry", "attributes", "clustersets", "textures", "labels"):
            file.create_group(name)
        file["geometry/vertices"] = full_mesh.vertices.reshape(-1)
        file["geometry/faces"] = full_mesh.faces.reshape(-1)
        file["labels/tree/1"] = np.uint32([3, 4])
    before = path.read_bytes()
    with LabelStore(path) as store:
        assert store.path == str(tmp_path / "old_s1.h5") and store.names() == ["tree_1"]
        store.set("tree_2", [5])
        store.delete("tree_1")
        store.save()
        assert store.names() == ["tree_2"]
    assert path.read_bytes() == before
    assert MapFile(store.path).schema == "S1" and in_file(store.path) == {"tree_2": ([5], None)}
    with LabelStore(path) as store:
        assert store.names() == ["tree_2"]
    assert listed(str(path)) == ["old.h5", "old_s1.h5"]


def test_labels_of_a_mesh_whose_coordinates_float32_cannot_hold_are_refused(tmp_path):
    """Its UUID would be that of rounded coordinates, and so would be the map file beside it."""
    lines = ["v 500000.1 5800000.1 0", "v 500001.3 5800000.1 0", "v 500000.1 5800001.7 0"]
    (tmp_path / "a.obj").write_text("\n".join(lines + ["f 1 2 3", ""]))
    with pytest.raises(MapFileError, match="--origin auto") as error:
        LabelStore(tmp_path / "a.obj")
    assert error.value.code == "rounded" and os.listdir(tmp_path) == ["a.obj"]
