"""Which messages are said to be stored: only what was in the map when it was saved."""
import genpy
import numpy as np
import pytest
from mesh_msgs import arrays, msg
from server_samples import everything, layer_message

from mesh_msgs_hdf5.map_file import MapFile
from mesh_msgs_hdf5.model.errors import MapFileError
from mesh_msgs_hdf5.ros.map_messages import MapMessages
from mesh_msgs_hdf5.server import received
from mesh_msgs_hdf5.server.map_loading import load
from mesh_msgs_hdf5.server.map_overlay import MapOverlay
from mesh_msgs_hdf5.server.pending import Pending, Sent, sent_on
from mesh_msgs_hdf5.server.server_options import MapRequest

COSTS = "store/vertex_costs"


def sent(name, second, topic=COSTS):
    return Sent(topic, name, genpy.Time(second))


def test_the_newest_of_each_topic_and_name_stands_for_those_before_it():
    pending = Pending()
    for second in (1, 2):
        pending.add("vertex_costs", sent("a", second))
    pending.add("vertex_costs", sent("b", 3))
    pending.add("vertex_costs", sent("a", 4, "store/vertex_costs_update"))
    now = pending.now()
    expected = [sent("a", 2), sent("b", 3), sent("a", 4, "store/vertex_costs_update")]
    assert now == expected
    assert pending.take_stored() == []
    pending.store(now)
    assert pending.take_stored() == expected
    assert pending.take_stored() == [] and pending.now() == []


def test_what_comes_while_it_is_saved_is_pending_still():
    pending = Pending()
    pending.add("vertex_costs", sent("a", 1))
    now = pending.now()
    pending.add("vertex_costs", sent("a", 1))  # an equal stamp does not make it the same message
    pending.store(now)
    assert pending.take_stored() == [sent("a", 1)]
    assert pending.now() == [sent("a", 1)]


def test_a_reason_is_told_once_for_each_message():
    pending = Pending()
    pending.add("vertex_costs", sent("a", 1))
    assert pending.take_waiting("locked") == [sent("a", 1)]
    assert pending.take_waiting("locked") == []
    assert pending.take_waiting("full") == [sent("a", 1)]
    pending.add("vertex_costs", sent("b", 2))
    assert pending.take_waiting("locked") == [sent("b", 2)]
    pending.add("vertex_costs", sent("a", 3))
    assert pending.take_waiting("locked") == [sent("a", 3)]


def test_what_a_message_is_called():
    stamp = genpy.Time(7, 8)
    layer = layer_message("slope")
    layer.header.stamp = stamp
    assert sent_on(COSTS, layer) == Sent(COSTS, "slope", stamp)
    texture = msg.MeshTexture(texture_index=3)
    texture.image.header.stamp = stamp
    assert sent_on("store/texture", texture) == Sent("store/texture", "3", stamp)
    features = msg.MeshFeatures()
    assert sent_on("store/features", features) == Sent("store/features", "", genpy.Time())
    colors = arrays.MeshVertexColorsStamped()
    colors.header.stamp = stamp
    assert sent_on("store/vertex_colors", colors) == Sent("store/vertex_colors", "", stamp)
    label = msg.MeshFaceClusterStamped()
    label.header.stamp, label.cluster.label = stamp, "tree_1"
    assert sent_on("cluster_label", label) == Sent("cluster_label", "tree_1", stamp)


@pytest.fixture
def served(tmp_path):
    path = str(tmp_path / "a.h5")
    MapFile.write(path, everything())
    (found,), _ = load(MapRequest(path), genpy.Time(1), {"node": "/here"}, False)
    yield found
    found.labels.close()


def store(served, read, message, topic):
    served.store(read, message, genpy.Time(5), sent_on(topic, message))


def test_stored_is_what_is_in_the_file(served):
    store(served, received.vertex_costs, layer_message("new", 1.0), COSTS)
    assert served.pending.take_stored() == []
    served.save()
    assert [found[:2] for found in served.pending.take_stored()] == [(COSTS, "new")]
    assert np.all(MapFile(served.path).vertex_costs("new") == 1.0)


def test_a_message_that_comes_during_the_save_is_not_said_to_be_stored(served, monkeypatch):
    store(served, received.vertex_costs, layer_message("new", 1.0), COSTS)
    write = type(served)._write

    def write_slowly(self, edit):
        store(served, received.vertex_costs, layer_message("newer", 2.0), COSTS)
        write(self, edit)

    monkeypatch.setattr(type(served), "_write", write_slowly)
    served.save()
    assert [found.name for found in served.pending.take_stored()] == ["new"]
    assert [found.name for found in served.pending.now()] == ["newer"]


def test_what_cannot_be_saved_is_not_said_to_be_stored(served, monkeypatch):
    def full(self, edit):
        raise MapFileError("save", self.path, "no room")

    store(served, received.vertex_costs, layer_message("new", 1.0), COSTS)
    with monkeypatch.context() as changed:
        changed.setattr(type(served), "_write", full)
        with pytest.raises(MapFileError):
            served.save()
    assert served.pending.take_stored() == []
    served.save()
    assert [found.name for found in served.pending.take_stored()] == ["new"]


def test_materials_wait_for_their_textures(served, tmp_path):
    path = tmp_path / "textured.h5"
    textured = everything(2)
    MapFile.write(path, textured)
    messages = MapMessages(MapOverlay(MapFile(path)), textured.uuid, genpy.Time(1))
    materials = messages.materials()
    for material in materials.mesh_materials.materials:
        material.texture_index += 100
    store(served, received.materials, materials, "store/materials")
    store(served, received.vertex_costs, layer_message("new", 1.0), COSTS)
    _, waits = served.save()
    assert "wait for the textures" in waits
    assert [found.topic for found in served.pending.take_stored()] == [COSTS]
    store(served, received.vertex_costs, layer_message("newer", 1.0), COSTS)  # does not wait
    told = served.pending.take_waiting(waits, "materials")
    assert [found.topic for found in told] == ["store/materials"]
    for index in textured.textures:
        texture = messages.texture(index)
        texture.texture_index += 100
        store(served, received.texture, texture, "store/texture")
    served.save()
    topics = sorted(found.topic for found in served.pending.take_stored())
    assert topics == ["store/materials"] + ["store/texture"] * len(textured.textures) + [COSTS]
