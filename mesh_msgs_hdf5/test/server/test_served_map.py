"""A map of a server: its changes are served at once and saved later, and none is lost."""
import os
import threading

import genpy
import h5py
import map_samples
import numpy as np
import pytest
from server_samples import everything, layer_message

from mesh_msgs_hdf5.commands.mesh_tool import main
from mesh_msgs_hdf5.formats.any_mesh import MeshMembers
from mesh_msgs_hdf5.labels.label_store import LabelStore
from mesh_msgs_hdf5.map_file import MapFile
from mesh_msgs_hdf5.model.errors import MapFileError
from mesh_msgs_hdf5.model.mesh import Mesh
from mesh_msgs_hdf5.ros.map_messages import MapMessages, wire_order
from mesh_msgs_hdf5.server import received
from mesh_msgs_hdf5.server.map_loading import load, owner_notes, source_now
from mesh_msgs_hdf5.server.map_overlay import MapOverlay
from mesh_msgs_hdf5.server.map_registry import MapRegistry, UnknownMap
from mesh_msgs_hdf5.server.received import Refused
from mesh_msgs_hdf5.server.served_map import STORES_ALL
from mesh_msgs_hdf5.server.server_options import ALL_PARTS, MapRequest
from mesh_writers import ply, xyz

pytestmark = pytest.mark.usefixtures("read_here")

STAMP = genpy.Time(1)
OWNER = {"node": "/here", STORES_ALL: True}


def loaded(path, part=None, read_only=False, owner=None):
    maps, notes = load(MapRequest(str(path), part), STAMP, owner or OWNER, read_only)
    return maps, notes


@pytest.fixture
def opened():
    """Loads the only map of a file, and closes it at the end."""
    found = []

    def open_one(path, **options):
        (served,), notes = loaded(path, **options)
        found.append(served)
        return served, notes

    yield open_one
    for served in found:
        served.labels.close()


@pytest.fixture
def path(tmp_path):
    MapFile.write(tmp_path / "a.h5", everything())
    return tmp_path / "a.h5"


def store_layer(served, name, value=1.0):
    served.store(received.vertex_costs, layer_message(name, value), genpy.Time(5))


def test_a_change_is_served_before_it_is_saved(opened, path):
    served, notes = opened(path)
    assert notes == [] and served.is_saved and served.save() == ("", "")
    store_layer(served, "new")
    assert not served.is_saved
    assert served.overlay.layer_names() == ["height_diff", "new", "roughness"]
    message = served.messages.vertex_costs("new")
    assert message.header.stamp == genpy.Time(5)
    assert "new" not in MapFile(path).layer_names()
    assert served.save() == ("1 layer", "")
    assert served.is_saved
    assert served.messages.vertex_costs("new") == message
    np.testing.assert_array_equal(MapFile(path).vertex_costs("new"), np.ones(12))


def test_what_a_received_layer_was_computed_with_is_not_known(opened, path):
    ones = np.ones(12, np.float32)
    MapFile(path).write_layers({"slope": (ones, {"radius": 1}), "keep": (ones, {"a": 2})})
    served, _ = opened(path)
    store_layer(served, "slope", 3.0)
    served.save()
    assert MapFile(path).layer_parameters("slope") == {}
    assert MapFile(path).layer_parameters("keep") == {"a": 2}


def test_materials_wait_for_their_textures(opened, tmp_path):
    mesh = everything()
    MapFile.write(tmp_path / "a.h5", Mesh(mesh.vertices, mesh.faces))
    served, _ = opened(tmp_path / "a.h5")
    source = MapMessages(_members(mesh), "u", STAMP)
    served.store(received.materials, source.materials(), STAMP)
    store_layer(served, "new")
    done, waits = served.save()
    assert (done, waits) == (
        "1 layer, texture coordinates",
        "materials wait for the textures 0, 3: send them on store/texture",
    )
    assert MapFile(tmp_path / "a.h5").materials is None
    assert served.messages.materials().mesh_materials == source.materials().mesh_materials
    for index in (0, 3):
        served.store(received.texture, source.texture(index), STAMP)
    assert served.save() == ("2 textures, materials", "")
    assert served.is_saved
    found = MapFile(tmp_path / "a.h5").materials
    numbers = np.argsort(wire_order(mesh.materials.texture_indices))
    np.testing.assert_array_equal(found.face_materials, numbers[mesh.materials.face_materials])


def _members(mesh):
    return MapOverlay(MeshMembers("a.h5", mesh))


def test_what_cannot_be_saved_stays_and_is_tried_again(opened, path):
    served, _ = opened(path)
    store_layer(served, "new")
    away = str(path) + ".away"
    os.rename(path, away)
    for _ in range(2):
        with pytest.raises(MapFileError, match="no such file"):
            served.save()
    os.rename(away, path)
    store_layer(served, "newer")
    assert served.save() == ("2 layers", "")


def test_what_was_stored_before_the_end_is_saved(opened, path):
    served, _ = opened(path)
    store_layer(served, "new")

    def read(message, overlay):  # the end comes while a message is read
        ender.start()
        return received.vertex_costs(message, overlay)

    ender = threading.Thread(target=served.end, args=("the server is ending",))
    served.store(read, layer_message("newer"), genpy.Time(5))
    ender.join()
    assert served.is_ended
    with pytest.raises(Refused, match="^the server is ending$"):
        store_layer(served, "newest")
    assert served.save() == ("2 layers", "")


def test_an_imported_mesh_gets_a_map_file_when_there_is_something_to_store(opened, tmp_path):
    mesh = everything()
    path, target = tmp_path / "b.ply", tmp_path / "b.h5"
    path.write_bytes(ply(xyz(mesh.vertices), mesh.faces))
    served, _ = opened(path)
    assert served.save() == ("", "")
    assert not target.exists()
    store_layer(served, "new")
    assert served.save() == ("1 layer", "")
    assert served.overlay.layer_names() == ["new"]
    served.labels.set("tree_1", [3])
    assert served.fold_labels() == ("1 label", "")
    served.labels.close()
    file = MapFile(target)
    assert file.layer_names() == ["new"] and file.label("tree_1").faces.tolist() == [3]
    again, notes = opened(path)
    assert notes == ["%s is served from %s, with what was stored there" % (path, target)]
    assert again.overlay.layer_names() == ["new"]
    assert list(again.labels.all()) == ["tree_1"]


@pytest.mark.parametrize("write", [map_samples.write_s0, map_samples.write_s2])
def test_a_map_of_another_schema_is_stored_beside_it(opened, tmp_path, write):
    path, target = tmp_path / "a.h5", tmp_path / "a_s1.h5"
    mesh = write(path, everything())
    before = path.read_bytes()
    served, _ = opened(path)
    found = served.messages.geometry().mesh_geometry
    np.testing.assert_array_equal(found.faces, mesh.faces)
    store_layer(served, "new")
    served.labels.set("tree_9", [4])
    assert not target.exists()
    assert served.save() == ("1 layer", "")
    assert served.fold_labels() == ("1 label", "")
    served.labels.close()
    assert path.read_bytes() == before
    again, (note,) = opened(path)
    assert note.endswith("is served from %s, with what was stored there" % target)
    assert again.overlay.layer_names() == sorted([*mesh.vertex_costs, "new"])
    assert sorted(again.labels.all()) == sorted([*mesh.labels, "tree_9"])
    store_layer(again, "newer")
    assert again.save() == ("1 layer", "")


@pytest.mark.parametrize("content", [everything(5), b"no map"])
def test_a_file_beside_it_that_is_another_one_is_not_touched(opened, tmp_path, content):
    mesh = everything()
    path, target = tmp_path / "b.ply", tmp_path / "b.h5"
    path.write_bytes(ply(xyz(mesh.vertices), mesh.faces))
    if isinstance(content, bytes):
        target.write_bytes(content)
    else:
        MapFile.write(target, content)
    before = target.read_bytes()
    served, (note,) = opened(path)
    assert "labels cannot be changed: %s" % target in note
    assert served.uuid == mesh.uuid
    assert served.labels.all() == {}
    with pytest.raises(Refused, match="nothing is stored: %s" % target):
        store_layer(served, "new")
    with pytest.raises(MapFileError):
        served.labels.set("tree_1", [0], override=True)
    assert target.read_bytes() == before


def test_read_only_leaves_no_trace(opened, path, tmp_path):
    before = os.stat(path)
    served, _ = opened(path, read_only=True)
    with pytest.raises(Refused, match="~read_only"):
        store_layer(served, "new")
    assert list(served.labels.all()) == ["bench_left", "tree_1", "tree_2"]
    assert os.listdir(tmp_path) == ["a.h5"] and os.stat(path) == before


@pytest.mark.parametrize("stores_all", [True, False])
def test_what_another_server_owns_is_stored_there(opened, path, stores_all):
    with LabelStore(path, owner_info={"node": "/other", STORES_ALL: stores_all}):
        served, _ = opened(path)
        (note,) = owner_notes([served], False)
        assert "its labels belong to /other" in note
        assert owner_notes([served], True) == []
        if stores_all:
            with pytest.raises(Refused, match="belongs to /other .*: store it there"):
                store_layer(served, "new")
        else:  # a label_manager stores labels alone
            store_layer(served, "new")
            assert served.save() == ("1 layer", "")
    store_layer(served, "newer")
    assert served.save() == ("1 layer", "")


def test_labels_with_a_journal_of_another_mesh_are_shown_only(opened, path):
    with LabelStore(path) as labels:
        labels.set("tree_1", [1])
    MapFile.write(path, everything(3))
    served, (note,) = opened(path)
    assert "labels cannot be changed" in note and "journal" in note
    assert served.labels.groups() == ["bench", "tree"]
    assert sorted(served.labels.group("tree")) == ["tree_1", "tree_2"]
    with pytest.raises(MapFileError):
        served.labels.delete("tree_1")
    store_layer(served, "new")
    assert served.save() == ("1 layer", "")
    assert served.fold_labels() == ("", "")


def test_parts(tmp_path):
    one, other = everything(1), everything(2)
    MapFile.write(tmp_path / "a.h5", one, part="ground")
    MapFile.write(tmp_path / "b.h5", other, part="upstairs")
    with h5py.File(tmp_path / "a.h5", "r+") as file, h5py.File(tmp_path / "b.h5", "r") as source:
        source.copy("upstairs", file)
    with pytest.raises(MapFileError, match="ground, upstairs"):
        loaded(tmp_path / "a.h5")
    maps, _ = loaded(tmp_path / "a.h5", ALL_PARTS)
    assert [served.uuid for served in maps] == [one.uuid, other.uuid]
    assert [served.name for served in maps] == [
        "%s, part %s" % (tmp_path / "a.h5", part) for part in ("ground", "upstairs")
    ]
    for number, served in enumerate(maps):
        store_layer(served, "new", number)
        assert served.labels.set("tree_1", [number]).faces.tolist() == [number]
    for served in maps:
        served.save()
        served.fold_labels()
        served.labels.close()
    for number, part in enumerate(("ground", "upstairs")):
        file = MapFile(tmp_path / "a.h5", part)
        np.testing.assert_array_equal(file.vertex_costs("new"), np.full(12, number))
        assert file.label("tree_1").faces.tolist() == [number]


def test_registry(opened, path, tmp_path):
    MapFile.write(tmp_path / "b.h5", everything(2))
    one, other = opened(path)[0], opened(tmp_path / "b.h5")[0]
    maps = MapRegistry()
    maps.add(one)
    assert maps.find(one.uuid) is maps.find("") is maps.find("mesh") is one
    with pytest.raises(UnknownMap, match="no map of uuid 'x'; known: %s" % one.uuid):
        maps.find("x")
    with pytest.raises(ValueError, match="a UUID stands for one map"):
        maps.add(one)
    maps.add(other)
    assert maps.uuids() == [one.uuid, other.uuid] and list(maps) == [one, other]
    assert maps.find(other.uuid) is other
    for uuid in ("", "mesh"):
        with pytest.raises(UnknownMap, match="several.*%s, %s" % (one.uuid, other.uuid)):
            maps.find(uuid)
    MapFile.write(tmp_path / "c.h5", everything(3))
    new = opened(tmp_path / "c.h5")[0]
    maps.replace(one, new)
    assert list(maps) == [new, other] and maps.find(new.uuid) is new
    with pytest.raises(UnknownMap):
        maps.find(one.uuid)
    with pytest.raises(ValueError, match="a UUID stands for one map"):
        maps.replace(new, other)
    assert list(maps) == [new, other]


UTM = "v 500000.1 5800000.1 0\nv 500001.3 5800000.1 0\nv 500000.1 5800001.7 0.3\nf 1 2 3\n"


def test_coordinates_that_float32_cannot_hold_are_refused_with_the_way_out(tmp_path, opened):
    source, target = tmp_path / "a.obj", tmp_path / "a_near.h5"
    source.write_text(UTM)
    request = MapRequest(str(source))
    for refused in (lambda: loaded(source), lambda: source_now(request)):
        with pytest.raises(MapFileError, match=r"a\.obj: .* up to 0\.\d+ m \(.*--origin auto") as e:
            refused()
        assert e.value.code == "rounded"
    assert main(["import", str(source), str(target), "--origin", "auto"]) == 0
    served, notes = opened(target)
    assert not notes
    saved = MapFile(target)
    assert served.overlay.uuid == saved.uuid
    place = saved.vertices + np.array(saved.origin)
    assert np.abs(place[1] - [500001.3, 5800000.1, 0]).max() < 1e-6
    source.write_text(UTM.replace("500000", "5000").replace("5800000", "5800"))
    assert opened(source)[0].overlay.face_count == 1  # within 1 mm
