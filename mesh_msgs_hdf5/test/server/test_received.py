"""Received messages as changes of a map: what was served comes back as it was."""
import io
import math

import genpy
import mesh_msgs.msg
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp
from mesh_msgs import arrays
from mesh_msgs.msg import Feature, MeshFeatures, MeshMaterial, MeshTexture
from sensor_msgs.msg import Image
from server_samples import everything
from std_msgs.msg import ColorRGBA, Float32

from mesh_msgs_hdf5.formats.any_mesh import MeshMembers
from mesh_msgs_hdf5.map_file import MapFile
from mesh_msgs_hdf5.model.mesh import Features, Label, Materials, Mesh
from mesh_msgs_hdf5.ros.map_messages import (
    MapMessages,
    cluster,
    materials_message,
    wire_order,
)
from mesh_msgs_hdf5.server import received
from mesh_msgs_hdf5.server.map_overlay import MapOverlay
from mesh_msgs_hdf5.server.received import Refused

VERTICES, FACES = 12, 9


def overlay(mesh=None):
    return MapOverlay(MeshMembers("a.h5", mesh or everything()))


def bare_overlay():
    mesh = everything()
    return overlay(Mesh(mesh.vertices, mesh.faces))


def messages(target):
    return MapMessages(target, target.uuid, genpy.Time())


def stock(message):
    """The message in the generated classes, as it arrives."""
    buffer = io.BytesIO()
    message.serialize(buffer)
    kind = getattr(mesh_msgs.msg, message._type.split("/")[1])
    return kind().deserialize(buffer.getvalue())


def wire(message):
    buffer = io.BytesIO()
    message.serialize(buffer)
    return buffer.getvalue()


SENT = {
    received.vertex_costs: lambda m: m.vertex_costs("height_diff"),
    received.face_costs: lambda m: m.face_costs("slope"),
    received.vertex_colors: lambda m: m.vertex_colors(),
    received.materials: lambda m: m.materials(),
    received.texture: lambda m: m.texture(3),
    received.features: lambda m: m.features(),
}


@pytest.mark.parametrize("as_stock", [False, True])
@pytest.mark.parametrize("read", SENT, ids=lambda f: f.__name__)
def test_what_is_served_and_received_is_served_again(read, as_stock):
    """The whole way: a map -> message -> a map without anything -> message, byte for byte."""
    make = SENT[read]
    sent = make(messages(overlay()))
    target = bare_overlay()
    target.frame_id = "floor"
    result = read(stock(sent) if as_stock else sent, target)
    assert result.notes == []
    target.change(result.edit)
    assert wire(make(messages(target))) == wire(sent)


@pytest.mark.parametrize("as_stock", [False, True])
@pytest.mark.parametrize("name", [b"h\xffight_diff", b"\xe4\xb6name", b"cut_off_\xe2\x82"])
def test_a_name_that_is_no_utf8_is_refused(as_stock, name):
    target = overlay()
    update = arrays.MeshVertexCostsSparseStamped()
    update.mesh_vertex_costs = arrays.MeshVertexCostsSparse([0], [1.0], 0.0)
    label = arrays.MeshFaceClusterStamped()
    label.cluster = arrays.MeshFaceCluster(np.uint32([0]), "@" * len(name))
    costs, faces = messages(target).vertex_costs("height_diff"), messages(target).face_costs(
        "slope"
    )
    for message in (costs, faces, update):
        message.type = "@" * len(name)
    for message, read in (
        (costs, received.vertex_costs),
        (update, received.vertex_costs_update),
        (faces, received.face_costs),
        (label, received.label),
    ):
        kind = type(stock(message) if as_stock else message)
        sent = kind().deserialize(wire(message).replace(b"@" * len(name), name))
        with pytest.raises(Refused, match="is no UTF-8"):
            read(sent, target)


@given(hnp.arrays(np.uint8, (VERTICES, 3)))
def test_colors_come_back_exactly(colors):
    mesh = everything()
    mesh.vertex_colors = colors
    target = overlay(mesh)
    edit = received.vertex_colors(messages(target).vertex_colors(), target).edit
    np.testing.assert_array_equal(edit.vertex_colors, colors)
    assert edit.vertex_colors.dtype == np.uint8


def test_every_byte_is_its_own_inverse():
    steps = np.arange(256, dtype=np.uint8)
    np.testing.assert_array_equal(received.to_bytes(steps / np.float32(255)), steps)


@given(st.floats(0, 1, width=32))
def test_any_color_becomes_the_nearest_step(value):
    found = int(received.to_bytes(np.array([value], np.float32))[0])
    assert abs(found - value * 255) <= 0.5 + 1e-4


@given(st.data())
def test_materials_of_any_kind_come_back(data):
    count = data.draw(st.integers(1, 6))
    found = Materials(
        data.draw(hnp.arrays(np.uint8, (count, 3))),
        data.draw(hnp.arrays(np.int32, count, elements=st.integers(-1, 2**31 - 1))),
        data.draw(hnp.arrays(np.uint32, FACES, elements=st.integers(0, count - 1))),
    )
    message = arrays.MeshMaterialsStamped(mesh_materials=materials_message(found, None))
    result = received.materials(message, overlay())
    order = np.array(wire_order(found.texture_indices))  # numbered anew, else the same
    assert sorted(order) == list(range(count))
    numbers = np.argsort(order).astype(np.uint32)
    there = Materials(
        found.colors[order], found.texture_indices[order], numbers[found.face_materials]
    )
    for name in ("colors", "texture_indices", "face_materials"):
        values, expected = getattr(result.edit.materials, name), getattr(there, name)
        np.testing.assert_array_equal(values, expected)
        assert values.dtype == expected.dtype
    assert result.notes == []


@given(
    hnp.arrays(
        np.float32,
        VERTICES,
        elements=st.floats(width=32).filter(lambda cost: cost != -math.inf),
    )
)
def test_costs_come_back_with_their_special_values(costs):
    message = arrays.MeshVertexCostsStamped(type="a", uuid="u")
    message.mesh_vertex_costs.costs = costs
    found = received.vertex_costs(message, overlay()).edit.vertex_costs["a"]
    np.testing.assert_array_equal(found, costs)
    assert found.dtype == np.float32


def test_what_is_kept_does_not_hold_the_message():
    message = arrays.MeshVertexCostsStamped().deserialize(
        wire(messages(overlay()).vertex_costs("roughness"))
    )
    found = received.vertex_costs(message, overlay()).edit.vertex_costs["roughness"]
    assert found.base is None and found.flags.writeable


def sparse(name, vertices, costs, default=0.5):
    message = arrays.MeshVertexCostsSparseStamped(type=name)
    message.mesh_vertex_costs = arrays.MeshVertexCostsSparse(vertices, costs, default)
    return message


def test_an_update_changes_only_what_it_names():
    target = overlay()
    before = target.vertex_costs("roughness").copy()
    update = sparse("roughness", [2, 0, 2], [np.inf, 7, np.nan])
    target.change(received.vertex_costs_update(update, target).edit)
    expected = before.copy()
    expected[[0, 2]] = 7, np.nan
    np.testing.assert_array_equal(target.vertex_costs("roughness"), expected)
    np.testing.assert_array_equal(target.source.vertex_costs("roughness"), before)


def test_an_update_of_no_layer_makes_it():
    target = overlay()
    target.change(received.vertex_costs_update(sparse("new", [1], [3.0], 0.25), target).edit)
    expected = np.full(VERTICES, 0.25, np.float32)
    expected[1] = 3
    np.testing.assert_array_equal(target.vertex_costs("new"), expected)


def materials(clusters, indices, count=1, **more):
    message = arrays.MeshMaterialsStamped()
    made = [MeshMaterial(color=ColorRGBA(0, number / 255, 1, 1), **more) for number in range(count)]
    message.mesh_materials = arrays.MeshMaterials(
        [arrays.MeshFaceCluster(faces, "") for faces in clusters], made, indices, []
    )
    return message


def test_clusters_may_share_a_material_and_faces():
    message = materials([[0, 1], [2, 3, 4], list(range(4, FACES))], [1, 0, 1], 2)
    result = received.materials(message, overlay())
    expected = [1, 1, 0, 0, 1, 1, 1, 1, 1]
    assert result.edit.materials.face_materials.tolist() == expected
    assert result.notes == ["1 faces are in several clusters: the last of them counts"]


def test_faces_without_a_cluster_get_a_gray_material():
    result = received.materials(materials([[0, 5]], [0]), overlay())
    found = result.edit.materials
    assert found.colors.tolist() == [[0, 0, 255], [204, 204, 204]]
    assert found.texture_indices.tolist() == [-1, -1]
    assert found.face_materials.tolist() == [0, 1, 1, 1, 1, 0, 1, 1, 1]
    assert result.notes == ["7 faces are in no cluster (first 1): they get a gray material"]


def test_no_materials_remove_them():
    target = overlay()
    for _ in range(2):  # those of the file, then those that were received
        target.change(received.materials(arrays.MeshMaterialsStamped(), target).edit)
        assert target.materials is None and target.texture_coordinates is None
        target.change(received.materials(messages(overlay()).materials(), target).edit)
        assert target.materials is not None and target.texture_coordinates is not None


def test_no_features_remove_them():
    target = overlay()
    for _ in range(2):  # those of the file, then those that were received
        target.change(received.features(MeshFeatures(), target).edit)
        assert target.features is None
        target.change(received.features(messages(overlay()).features(), target).edit)
        assert target.features is not None


def test_alpha_is_noted():
    message = messages(overlay()).vertex_colors()
    message.mesh_vertex_colors.vertex_colors[4:6, 3] = 0.5
    (note,) = received.vertex_colors(message, overlay()).notes
    assert "2 vertex colors is not 1 (first at vertex 4)" in note
    message = messages(overlay()).materials()
    message.mesh_materials.materials[1].color.a = 0
    (note,) = received.materials(message, overlay()).notes
    assert "1 materials is not 1 (first of material 1)" in note


def texture(encoding, data, step, index=1, width=2, height=2):
    image = Image(height=height, width=width, encoding=encoding, step=step, data=bytes(data))
    return MeshTexture(uuid="u", texture_index=index, image=image)


@pytest.mark.parametrize(
    "encoding, step, data, expected",
    [
        ("rgb8", 6, range(12), [[0, 1, 2], [3, 4, 5], [6, 7, 8], [9, 10, 11]]),
        ("rgb8", 7, range(14), [[0, 1, 2], [3, 4, 5], [7, 8, 9], [10, 11, 12]]),
        ("rgb8", 6, range(20), [[0, 1, 2], [3, 4, 5], [6, 7, 8], [9, 10, 11]]),
        ("bgr8", 6, range(12), [[2, 1, 0], [5, 4, 3], [8, 7, 6], [11, 10, 9]]),
        ("mono8", 2, range(4), [[0] * 3, [1] * 3, [2] * 3, [3] * 3]),
        ("bgra8", 8, range(16), [[2, 1, 0, 3], [6, 5, 4, 7], [10, 9, 8, 11], [14, 13, 12, 15]]),
        ("rgba8", 8, range(16), np.arange(16).reshape(4, 4).tolist()),
    ],
)
def test_textures_of_several_encodings(encoding, step, data, expected):
    found = received.texture(texture(encoding, data, step), overlay()).edit.textures[1]
    assert found.reshape(4, -1).tolist() == expected
    assert found.dtype == np.uint8 and found.shape[:2] == (2, 2)


def costs(name="a", values=(0.0,) * VERTICES):
    message = arrays.MeshVertexCostsStamped(type=name)
    message.mesh_vertex_costs.costs = values
    return message


def face_costs(name="a", values=(0.0,) * FACES):
    message = arrays.MeshFaceCostsStamped(type=name)
    message.mesh_face_costs.costs = values
    return message


def colors(values):
    message = arrays.MeshVertexColorsStamped()
    message.mesh_vertex_colors.vertex_colors = values
    return message


def features(*descriptors, x=0.0):
    found = []
    for numbers in descriptors:
        feature = Feature(descriptor=[Float32(number) for number in numbers])
        feature.location.x = x
        found.append(feature)
    return MeshFeatures(features=found)


NEGATIVE = [0.0] * 3 + [-np.inf, -np.inf] + [0.0] * (VERTICES - 5)
BAD = [
    (received.vertex_costs, costs(values=[0.0] * 5), "5 costs for 12 vertices"),
    (received.vertex_costs, costs(values=NEGATIVE), "cost 3 is -inf"),
    (received.vertex_costs, costs(""), "layer name '' is empty"),
    (received.vertex_costs, costs("a/b"), "contains a slash"),
    (received.vertex_costs, costs("vertices"), "kept for mesh data"),
    (received.vertex_costs, costs("x" * 300), "too long"),
    (received.vertex_costs, costs("a\nb"), "printable"),
    (received.face_costs, face_costs(values=[0.0] * VERTICES), "12 costs for 9 faces"),
    (received.face_costs, face_costs("../a"), "slash"),
    (received.vertex_costs_update, sparse("a", [VERTICES], [0.0]), "refers to vertex 12"),
    (received.vertex_costs_update, sparse("a", [1, 2], [0.0]), "1 costs for 2"),
    (received.vertex_costs_update, sparse("a", [1], [0.0], -np.inf), "default_value"),
    (received.vertex_colors, colors([[0.0] * 4] * 5), "5 colors for 12 vertices"),
    (received.vertex_colors, colors([[0.0, 2, 0, 1]] * VERTICES), "not between 0 and 1"),
    (received.vertex_colors, colors([[0.0, np.nan, 0, 1]] * VERTICES), "not finite"),
    (received.materials, materials([[FACES]], [0]), "refers to face 9"),
    (received.materials, materials([[0]], [1]), "refers to material 1"),
    (received.materials, materials([[0]], []), "0 cluster_materials for 1 clusters"),
    (received.materials, materials([[0]], [0], 0), "material"),
    (received.materials, materials([[0]], [0], texture_index=2**32 - 1, has_texture=1), "429496"),
    (received.texture, texture("rgb8", range(11), 6), "step of 6 and 11 bytes"),
    (received.texture, texture("rgb8", range(12), 5), "step of 5"),
    (received.texture, texture("jpeg", range(12), 6), "encoding 'jpeg'"),
    (received.texture, texture("mono16", range(16), 8), "encoding mono16"),
    (received.texture, texture("rgb8", b"", 0, width=0), "0 x 2 pixels"),
    (received.texture, texture("rgb8", range(12), 6, 2**31), "2147483648"),
    (received.features, features([1.0], [1.0, 2.0]), "descriptor of feature 1"),
    (received.features, features([np.nan]), "feature 0"),
    (received.features, features([1.0], x=1e60), "feature 0"),
    (received.features, features([]), "no descriptors"),
]


@pytest.mark.parametrize("read, message, words", BAD)
def test_a_bad_message_is_refused_in_one_sentence(read, message, words):
    target = overlay()
    with pytest.raises(Refused, match=words.replace("(", r"\(")) as refused:
        read(message, target)
    assert "\n" not in str(refused.value)


def labeled(text, faces, **more):
    message = arrays.MeshFaceClusterStamped(**more)
    message.cluster = arrays.MeshFaceCluster(face_indices=faces, label=text)
    return message


@given(st.lists(st.integers(0, FACES - 1), unique=True))
def test_a_label_comes_back(faces):
    message = labeled("tree_1", faces)
    found = received.label(message, overlay())
    assert found.faces.tolist() == faces and found.faces.dtype == np.uint32
    assert cluster("tree_1", found) == message.cluster


@pytest.mark.parametrize(
    "text, faces, words",
    [
        ("", [0], "empty"),
        ("a/b", [0], "contains a slash"),
        ("..", [0], "label '..' is no name"),
        ("a\x07b", [0], "control character"),
        ("x" * 300, [0], "300 bytes"),
        ("tree_1", [0, FACES], "refers to face 9"),
    ],
)
def test_a_bad_label_is_refused(text, faces, words):
    with pytest.raises(Refused, match=words):
        received.label(labeled(text, faces), overlay())


def test_features_and_labels_are_those_of_the_file():
    assert isinstance(overlay().features, Features)
    assert isinstance(overlay().labels()["tree_1"], Label)


@pytest.mark.parametrize("kind", ["whole", "sparse"])
def test_a_vertex_attribute_is_not_replaced_by_a_layer(kind):
    mesh = everything()
    mesh.vertex_attributes = {"class_id": np.zeros(len(mesh.vertices), np.uint8)}
    target = overlay(mesh)
    if kind == "whole":
        message = messages(target).vertex_costs("class_id")
        receive = received.vertex_costs
    else:
        sparse = arrays.MeshVertexCostsSparse(np.uint32([0]), np.float32([1]), 0.0)
        message = arrays.MeshVertexCostsSparseStamped(
            uuid=target.uuid, type="class_id", mesh_vertex_costs=sparse
        )
        receive = received.vertex_costs_update
    with pytest.raises(Refused, match="'class_id' is a vertex attribute of the map"):
        receive(message, target)


def test_a_file_that_cannot_be_read_now_keeps_no_layer_out(tmp_path):
    """It may be there again when it is saved."""
    target = MapOverlay(MapFile.write(tmp_path / "a.h5", everything()))
    message = messages(target).vertex_costs("height_diff")
    (tmp_path / "a.h5").rename(tmp_path / "away.h5")
    assert list(received.vertex_costs(message, target).edit.vertex_costs) == ["height_diff"]
