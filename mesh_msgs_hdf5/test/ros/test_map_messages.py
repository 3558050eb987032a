"""What is served of a map, and that only what is asked for is read."""
import io

import genpy
import mesh_msgs.msg
import numpy as np
import pytest
from mesh_msgs import validation
from server_samples import everything

from mesh_msgs_hdf5.formats.any_mesh import MeshMembers
from mesh_msgs_hdf5.model.errors import MapFileError
from mesh_msgs_hdf5.model.mesh import Materials, Mesh
from mesh_msgs_hdf5.ros.map_messages import (
    FACES,
    NORMALS,
    VERTICES,
    MapMessages,
    clusters,
    materials_message,
)

STAMP = genpy.Time(7, 5)


class Watched:
    """A source that notes what is read of it."""

    def __init__(self, mesh):
        self.mesh = mesh
        self.read = []
        self._source = MeshMembers("a.h5", mesh)

    def __getattr__(self, name):
        self.read.append(name)
        return getattr(self._source, name)


@pytest.fixture
def mesh():
    return everything()


@pytest.fixture
def source(mesh):
    return Watched(mesh)


@pytest.fixture
def messages(source):
    made = MapMessages(source, source.mesh.uuid, STAMP)
    del source.read[:]
    return made


@pytest.fixture
def bare():
    mesh = everything()
    plain = Mesh(mesh.vertices, mesh.faces)
    return MapMessages(MeshMembers("a.ply", plain), plain.uuid, STAMP)


def stock(message):
    """The message as a client with the generated classes gets it."""
    buffer = io.BytesIO()
    message.serialize(buffer)
    kind = getattr(mesh_msgs.msg, message._type.split("/")[1])
    return kind().deserialize(buffer.getvalue())


def xyz(points):
    return np.array([[p.x, p.y, p.z] for p in points]).reshape(-1, 3)


@pytest.mark.parametrize(
    "parts",
    [(VERTICES, FACES, NORMALS), (VERTICES,), (FACES,), (NORMALS,)],
)
def test_geometry_and_its_parts(messages, source, mesh, parts):
    message = messages.geometry(parts)
    assert sorted(source.read) == sorted(parts)
    assert (message.header.frame_id, message.header.stamp) == ("floor", STAMP)
    assert message.uuid == mesh.uuid
    geometry = stock(message).mesh_geometry
    faces = np.array([f.vertex_indices for f in geometry.faces]).reshape(-1, 3)
    for name, found in (
        (VERTICES, xyz(geometry.vertices)),
        (NORMALS, xyz(geometry.vertex_normals)),
        (FACES, faces),
    ):
        expected = getattr(mesh, name) if name in parts else np.zeros((0, 3))
        np.testing.assert_array_equal(found, expected)


def test_colors_are_bytes_by_255_and_opaque(messages, source, mesh):
    message = stock(messages.vertex_colors())
    assert source.read == ["vertex_colors"]
    found = [(c.r, c.g, c.b, c.a) for c in message.mesh_vertex_colors.vertex_colors]
    expected = [
        (*(float(np.float32(byte) / np.float32(255)) for byte in row), 1.0)
        for row in mesh.vertex_colors
    ]
    assert found == expected


def test_one_layer_is_read_alone(messages, source, mesh):
    message = stock(messages.vertex_costs("height_diff"))
    assert source.read == ["vertex_costs"]
    assert message.type == "height_diff"
    expected = mesh.vertex_costs["height_diff"]
    np.testing.assert_array_equal(np.float32(message.mesh_vertex_costs.costs), expected)


def test_vertex_attributes_that_a_message_can_carry_are_vertex_costs(mesh):
    count = len(mesh.vertices)
    ids = np.arange(count)
    mesh.vertex_attributes = {
        "class_id": ids.astype(np.uint8),
        "echo": np.where(ids < 2, np.nan, 0.5).astype(np.float64),
        "large": ids.astype(np.uint32) + np.uint32(2**24),
        "pair": np.zeros((count, 2), np.float32),
        "tenth": np.full(count, 0.1),
    }
    source = MeshMembers("a.h5", mesh)
    messages = MapMessages(source, "some uuid", genpy.Time())
    names = sorted(mesh.vertex_costs) + ["class_id", "echo"]
    assert messages.vertex_cost_names() == names == messages.vertex_cost_names()
    for name in ("large", "pair", "tenth"):
        assert messages.vertex_costs(name) is None
    for name in ("class_id", "echo"):
        message = messages.vertex_costs(name)
        costs = message.mesh_vertex_costs.costs
        assert message.type == name and costs.dtype == np.float32
        np.testing.assert_array_equal(costs, mesh.vertex_attributes[name])
    with pytest.raises(MapFileError):
        messages.vertex_costs("nothing")


def test_only_face_attributes_that_are_costs_are_face_costs(messages, mesh):
    message = stock(messages.face_costs("slope"))
    assert message.type == "slope"
    expected = mesh.face_attributes["slope"]
    np.testing.assert_array_equal(np.float32(message.mesh_face_costs.costs), expected)
    assert messages.face_costs("face_normals") is None


@pytest.mark.parametrize("dtype", ["<f8", "<u4", "|i1"])
def test_a_face_attribute_of_other_numbers_is_no_cost(mesh, dtype):
    mesh.face_attributes["zone"] = np.zeros(len(mesh.faces), dtype)
    assert MapMessages(MeshMembers("a.h5", mesh), "u", STAMP).face_costs("zone") is None


def test_materials_one_cluster_each(messages, source, mesh):
    message = messages.materials()
    assert sorted(source.read) == ["materials", "texture_coordinates"]
    assert not validation.mesh_materials_stamped(message, len(mesh.vertices), len(mesh.faces))
    parts = stock(message).mesh_materials
    assert list(parts.cluster_materials) == [0, 1, 2]
    faces, order = mesh.materials.face_materials, [2, 0, 1]
    for number, cluster in zip(order, parts.clusters):
        assert list(cluster.face_indices) == [i for i, m in enumerate(faces) if m == number]
        assert cluster.label == ""
    assert [m.has_texture for m in parts.materials] == [True, True, False]
    # -1, "no texture", must not become 4294967295
    assert [m.texture_index for m in parts.materials] == [0, 3, 2]
    for material, color in zip(parts.materials, mesh.materials.colors[order]):
        shown = [material.color.r, material.color.g, material.color.b, material.color.a]
        expected = [float(np.float32(byte) / np.float32(255)) for byte in color] + [1.0]
        assert shown == expected
    found = np.float32([[c.u, c.v] for c in parts.vertex_tex_coords])
    np.testing.assert_array_equal(found, mesh.texture_coordinates)


def released_plugin(materials):
    """What rviz_map_plugin 1.1 does with materials: the index of the OGRE material of each.

    It never looks at has_texture. OGRE refuses a second resource of one name, which ends RViz.
    """
    names, found = [], []
    for material in materials:
        name = "TextureMaterial_%d" % material.texture_index
        assert name not in names, "%s already exists" % name
        names.append(name)
        found.append(names[material.texture_index])  # of a vector, so far as it is filled
    assert found == names
    return names


@pytest.mark.parametrize(
    "indices, in_order",
    [
        ([-1, -1, -1], True),
        ([-1, 0, -1], True),
        ([1, -1, 0], True),
        ([-1, -1, 2, 0, 1], True),
        ([0, 1, 2], True),
        ([5, -1, 0, -1], False),  # a texture whose number is no material's: that RViz fails
        ([-1, 1, 1, -1], False),  # two materials with one texture: that RViz fails, too
    ],
)
def test_the_released_rviz_makes_a_material_of_each(indices, in_order):
    count = len(indices)
    colors = np.arange(count, dtype=np.uint8)[:, None].repeat(3, 1)
    faces = np.arange(count, dtype=np.uint32)[::-1].copy()
    materials = Materials(colors, np.array(indices, np.int32), faces)
    message = materials_message(materials, None)
    if in_order:
        released_plugin(message.materials)
    bare = [m.texture_index for m in message.materials if not m.has_texture]
    assert len(set(bare)) == len(bare) and not set(bare) & set(indices)
    seen = {}
    for cluster, number in zip(message.clusters, message.cluster_materials):
        material = message.materials[number]
        index = material.texture_index if material.has_texture else -1
        (face,) = cluster.face_indices.tolist()
        seen[face] = (index, round(material.color.r * 255))
    assert seen == {face: (indices[m], m) for face, m in enumerate(faces.tolist())}


def test_clusters_of_many_faces_are_ascending():
    faces = np.random.default_rng(1).integers(0, 5, 5000).astype(np.uint32)
    materials = Materials(np.zeros((5, 3), np.uint8), np.full(5, -1, np.int32), faces)
    for number, cluster in enumerate(materials_message(materials, None).clusters):
        np.testing.assert_array_equal(cluster.face_indices, np.flatnonzero(faces == number))


@pytest.mark.parametrize("index, encoding", [(0, "rgb8"), (3, "rgba8")])
def test_one_texture_is_read_alone(messages, source, mesh, index, encoding):
    message = messages.texture(index)
    assert source.read == ["texture"]
    assert not validation.mesh_texture(message, mesh.uuid)
    image = stock(message).image
    height, width, channels = mesh.textures[index].shape
    assert (message.uuid, message.texture_index) == (mesh.uuid, index)
    assert (image.encoding, image.step) == (encoding, channels * width)
    assert (image.height, image.width, image.is_bigendian) == (height, width, 0)
    assert image.data == mesh.textures[index].tobytes()


def test_labels_as_clusters(mesh):
    found = {c.label: c.face_indices.tolist() for c in clusters(mesh.labels)}
    assert found == {"tree_1": [0, 2], "tree_2": [1], "bench_left": [3, 4, 5]}


def test_features(messages, source, mesh):
    message = stock(messages.features())
    assert source.read == ["features"]
    assert message.map_uuid == mesh.uuid
    np.testing.assert_array_equal(
        xyz([f.location for f in message.features]), mesh.features.locations
    )
    found = np.float32([[number.data for number in f.descriptor] for f in message.features])
    np.testing.assert_array_equal(found, mesh.features.descriptors)


def test_what_a_map_does_not_have_is_empty(bare):
    assert bare.geometry().mesh_geometry.vertex_normals.shape == (0, 3)
    assert bare.vertex_colors().mesh_vertex_colors.vertex_colors.shape == (0, 4)
    parts = stock(bare.materials()).mesh_materials
    assert not any((parts.clusters, parts.materials, parts.cluster_materials))
    assert not parts.vertex_tex_coords
    assert bare.features() is None


def test_what_was_received_has_its_own_stamp(messages):
    later = genpy.Time(9, 1)
    messages.touch("vertex_costs", "roughness", later)
    assert messages.vertex_costs("roughness").header.stamp == later
    assert messages.vertex_costs("height_diff").header.stamp == STAMP
    assert messages.vertex_colors().header.stamp == STAMP


def test_what_costs_mean_is_read_once_and_of_a_layer_that_is_replaced_anew(mesh, source, messages):
    mesh.layer_parameters = {
        name: {"layer_info": {"comparison": "above", "threshold": 0.5}}
        for name in mesh.vertex_costs
    }
    names = sorted(mesh.vertex_costs)
    assert len(names) > 1
    assert [layer.name for layer in messages.layer_info().layers] == names
    del source.read[:]
    assert [layer.name for layer in messages.layer_info().layers] == names
    assert messages.layer_replaced(names[0])
    assert source.read.count("vertex_costs") == 1  # to count what is lethal in the one layer
    mesh.layer_parameters[names[0]] = {}
    assert messages.layer_replaced(names[0])
    assert [layer.name for layer in messages.layer_info().layers] == names[1:]
    assert not messages.layer_replaced(names[0])
