"""Parts of a map file are added, replaced, renamed, deleted and copied; all else stays."""
import h5py
import numpy as np
import pytest
from map_samples import assert_same_mesh, write_s0, write_s2
from raw_contents import raw_contents, without

from mesh_msgs_hdf5.files import save
from mesh_msgs_hdf5.isolation import IsolatedMapFile
from mesh_msgs_hdf5.map_file import MapFile
from mesh_msgs_hdf5.map_file.map_file import parts_of
from mesh_msgs_hdf5.map_file.part_changes import delete_parts
from mesh_msgs_hdf5.model.errors import MapFileError
from mesh_msgs_hdf5.model.mesh import Label

BOTH = pytest.mark.parametrize("kind", [MapFile, IsolatedMapFile])


@pytest.fixture
def path(tmp_path, strange_data):
    """A map of everything, with what other programs keep in it."""
    path = tmp_path / "a.h5"
    path.write_bytes(strange_data)
    return path


@pytest.fixture
def two(path, full_mesh):
    """The same with a second part, which has things of others in it, too."""
    MapFile.write_part(path, full_mesh, "floor2")
    with h5py.File(path, "r+") as file:
        part = file["floor2"]
        part["scan"] = np.arange(7)
        part.attrs["operator"] = "somebody"
        part["scan"].attrs["of"] = part["channels/vertices"].ref
        part["same scan"] = part["scan"]
        part["soft"] = h5py.SoftLink("/nowhere")
    return path


def refused(call, *arguments, **keywords):
    with pytest.raises(MapFileError) as error:
        call(*arguments, **keywords)
    assert "\n" not in str(error.value)
    return error.value


@BOTH
def test_a_part_is_added(path, full_mesh, rich_mesh, kind):
    before = raw_contents(path)
    file = kind.write_part(path, full_mesh, "floors/2", compression="none")
    assert file.part == "floors/2" and parts_of(path) == ["mesh", "floors/2"]
    assert_same_mesh(file.read(), full_mesh)
    assert_same_mesh(MapFile(path).read(), rich_mesh)
    assert without(raw_contents(path), ["/floors"]) == before


@BOTH
def test_a_part_is_replaced(two, full_mesh, rich_mesh, kind):
    before = raw_contents(two)
    rich_mesh.vertices[0] += 1
    assert refused(kind.write_part, two, rich_mesh, "floor2").code == "exists"
    assert raw_contents(two) == before
    kind.write_part(two, rich_mesh, "floor2", overwrite=True)
    assert_same_mesh(MapFile(two, "floor2").read(), rich_mesh)
    after = raw_contents(two)
    assert without(after, ["/floor2"]) == without(before, ["/floor2"])
    for name in ("scan", "same scan", "soft"):
        assert after["/floor2/" + name] == before["/floor2/" + name]
    assert after["/floor2"][1]["operator"] == before["/floor2"][1]["operator"]


@BOTH
def test_a_part_is_renamed(two, full_mesh, kind):
    before = raw_contents(two)
    file = kind(two, "floor2")
    file.rename_part("floors/second")
    assert file.part == "floors/second" and parts_of(two) == ["mesh", "floors/second"]
    assert_same_mesh(file.read(), full_mesh)
    after = raw_contents(two)
    assert without(after, ["/floors"]) == without(before, ["/floor2"])
    file.rename_part("floor2")  # the group that was made on the way stays, as all groups do
    after = raw_contents(two)
    assert after.pop("/floors") == ("group", {}) and after == before
    file.rename_part("floors")  # and is no obstacle, because it says nothing
    assert parts_of(two) == ["floors", "mesh"]


@BOTH
def test_a_part_is_deleted(two, path, rich_mesh, kind):
    before = raw_contents(two)
    kind(two, "floor2").delete_part()
    assert parts_of(two) == ["mesh"] and raw_contents(two) == without(before, ["/floor2"])
    assert_same_mesh(MapFile(two).read(), rich_mesh)
    error = refused(kind(two).delete_part)
    assert error.code == "part" and "--force" in error.hint
    kind(two).delete_part(last=True)
    assert parts_of(two) == []
    # what another group has, too, is still there
    assert "/raw/scans" in raw_contents(two)


@BOTH
def test_a_part_is_copied_as_it_is_stored(two, full_mesh, tmp_path, kind):
    before = raw_contents(two)
    kind(two, "floor2").copy_part("floors/copy")
    after = raw_contents(two)
    assert without(after, ["/floors"]) == before
    old = {name: kind for name, kind in before.items() if name.startswith("/floor2/")}
    new = {"/floor2" + name[12:]: kind for name, kind in after.items() if "/copy/" in name}
    scan = new.pop("/floor2/scan"), new.pop("/floor2/same scan")
    assert new == {name: kind for name, kind in old.items() if "scan" not in name}
    with h5py.File(two, "r") as file:
        copy = file["floors/copy"]
        assert file[copy["scan"].attrs["of"]] == copy["channels/vertices"]
        assert copy["scan"] == copy["same scan"] and len(scan) == 2
    assert_same_mesh(MapFile(two, "floors/copy").read(), full_mesh)

    other = tmp_path / "other.h5"
    MapFile.write(other, full_mesh)
    before = raw_contents(other)
    kind(two, "floor2").copy_part("floor2", other)
    assert without(raw_contents(other), ["/floor2"]) == before
    assert_same_mesh(MapFile(other, "floor2").read(), full_mesh)


def test_the_labels_of_a_copy_may_be_changed(path, rich_mesh):
    before = raw_contents(path)
    changes = {"tree_1": Label(np.uint32([9]), (1, 2, 3)), "tree_2": None, "new_1": Label([4])}
    changes["new_1"].faces = np.uint32([4])
    MapFile(path).copy_part("copy", label_changes=changes)
    assert without(raw_contents(path), ["/copy"]) == before
    rich_mesh.labels.update(changes)
    del rich_mesh.labels["tree_2"]
    assert_same_mesh(MapFile(path, "copy").read(), rich_mesh)
    assert "/copy/labels/tree/notes" in raw_contents(path)


def test_a_part_of_strange_things_is_copied_and_renamed(path, rich_mesh):
    MapFile(path).copy_part("b")
    assert_same_mesh(MapFile(path, "b").read(), rich_mesh)
    MapFile(path).rename_part("c")
    assert_same_mesh(MapFile(path, "c").read(), rich_mesh)
    assert parts_of(path) == ["b", "c"]


@pytest.mark.parametrize(
    "name,code,words",
    [
        ("", "part", "components"),
        ("/", "part", "components"),
        ("a/b/c/d", "part", "components"),
        ("a/../b", "part", "name '..'"),
        ("mesh", "exists", "/mesh"),
        ("mesh/upper", "part", "inside the other"),
        ("floors", "part", "inside the other"),
        ("raw", "part", "called raw"),
        ("raw/scans/z", "part", "called raw"),
        ("hall/channels", "part", "called channels"),
        ("type/a", "exists", "/type"),
        ("outside", "exists", "/outside"),
        ("outside/a", "exists", "/outside"),
        ("mesh 2", "exists", "/mesh 2"),
    ],
)
def test_where_something_is_no_part_is_made(path, full_mesh, name, code, words):
    MapFile.write_part(path, full_mesh, "floors/1")
    before = path.read_bytes()
    file = MapFile(path, "floors/1")
    for call in (
        lambda: MapFile.write_part(path, full_mesh, name),
        lambda: file.rename_part(name),
        lambda: file.copy_part(name),
    ):
        if call.__code__.co_names == ("rename_part",) and name == "floors":
            continue  # what was in the way is the part itself
        error = refused(call)
        assert error.code == code and words in str(error)
    assert path.read_bytes() == before


def test_a_part_may_take_the_place_of_the_group_that_it_was_in(path, full_mesh):
    MapFile.write_part(path, full_mesh, "floors/1")
    error = refused(MapFile(path, "floors/1").rename_part, "floors")
    assert error.code == "exists" and parts_of(path) == ["mesh", "floors/1"]


@pytest.mark.parametrize("write", [write_s0, write_s2])
def test_parts_of_other_schemas_are_only_read(tmp_path, rich_mesh, full_mesh, write):
    path = tmp_path / "old.h5"
    write(path, rich_mesh)
    before = raw_contents(path)
    file = MapFile(path)
    for call in (
        lambda: file.rename_part("b"),
        lambda: file.delete_part(last=True),
        lambda: file.copy_part("b"),
        lambda: MapFile.write_part(path, full_mesh, file.part or "geometry", overwrite=True),
    ):
        assert refused(call).code in ("schema", "part", "exists")
    assert raw_contents(path) == before
    MapFile.write_part(path, full_mesh, "b")  # another one may be beside them
    assert_same_mesh(MapFile(path, "b").read(), full_mesh)
    assert without(raw_contents(path), ["/b"]) == before


def test_what_is_not_there_is_an_error_that_names_what_is(two, full_mesh):
    before = two.read_bytes()
    error = refused(delete_parts, two, ["floor2", "floor3"])
    assert error.code == "part" and "floor2" in error.hint and "mesh" in error.hint
    assert two.read_bytes() == before
    error = refused(MapFile.write_part, two.parent / "none.h5", full_mesh, "b")
    assert error.code == "missing"


def test_a_part_that_others_refer_to_is_not_deleted(two):
    with h5py.File(two, "r+") as file:
        file["raw"].attrs["of"] = file["floor2/channels/vertices"].ref
    before = two.read_bytes()
    error = refused(MapFile(two, "floor2").delete_part)
    assert error.code == "link" and "/floor2/channels/vertices" in error.message
    assert two.read_bytes() == before


def test_references_in_a_copy_lead_to_what_they_led_to(two, full_mesh, tmp_path):
    """Out of the part, where that is in the same file."""
    with h5py.File(two, "r+") as file:
        file["floor2/scan"].attrs["out"] = file["mesh/channels/vertices"].ref
    MapFile(two, "floor2").copy_part("new")
    with h5py.File(two, "r") as file:
        scan = file["new/scan"]
        assert file[scan.attrs["of"]] == file["new/channels/vertices"]
        assert file[scan.attrs["out"]] == file["mesh/channels/vertices"]
    other = tmp_path / "other.h5"
    MapFile.write(other, full_mesh)
    before = other.read_bytes()
    error = refused(MapFile(two, "floor2").copy_part, "new", str(other))
    assert error.code == "link" and other.read_bytes() == before


@pytest.mark.parametrize(
    "change",
    [
        lambda path, mesh: MapFile.write_part(path, mesh, "new"),
        lambda path, mesh: MapFile.write_part(path, mesh, "floor2", overwrite=True),
        lambda path, mesh: MapFile(path, "floor2").rename_part("new"),
        lambda path, mesh: MapFile(path, "floor2").delete_part(),
        lambda path, mesh: MapFile(path, "floor2").copy_part("new"),
    ],
)
def test_it_is_one_step_that_is_not_done_where_another_program_saves(
    two, full_mesh, monkeypatch, change
):
    """The new file is whole before it takes the place of the old one, which has changed."""
    fill, data = save._fill, two.read_bytes()

    def slow(*arguments):
        fill(*arguments)
        two.write_bytes(data)

    monkeypatch.setattr(save, "_fill", slow)
    assert refused(change, two, full_mesh).code == "changed"
    assert two.read_bytes() == data and [p.name for p in two.parent.iterdir()] == ["a.h5"]
