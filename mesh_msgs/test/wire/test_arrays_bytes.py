"""Array classes and generated classes write the same bytes and read each other's."""

import io
import struct

import genpy
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from rospy.msg import serialize_message
from samples import ARRAY_CLASSES, ARRAY_MESSAGES, encoded, filled, has_nan, messages, stock_of

import mesh_msgs.msg
from mesh_msgs import arrays

IDS = [cls.__name__ for cls in ARRAY_CLASSES]
FEW = settings(max_examples=40, derandomize=True)


def same_through_both(cls, stock):
    """The four ways between a generated message and bytes agree."""
    wire = encoded(stock)
    converted = cls.from_message(stock)
    decoded = cls().deserialize(wire)
    assert encoded(converted) == wire
    assert encoded(decoded) == wire
    if not has_nan(stock):
        assert converted == decoded
        again = stock_of(cls)().deserialize(encoded(decoded))
        assert again == stock_of(cls)().deserialize(wire)
        assert decoded == stock and stock == decoded


@pytest.mark.parametrize("cls", ARRAY_CLASSES, ids=IDS)
@FEW
@given(data=st.data())
def test_any_message_has_genpys_bytes(cls, data):
    same_through_both(cls, data.draw(messages(stock_of(cls))))


@pytest.mark.parametrize("size", [0, 1, 2, 3, 7, 255, 256, 301])
@pytest.mark.parametrize("cls", ARRAY_CLASSES, ids=IDS)
def test_any_size_has_genpys_bytes(cls, size):
    same_through_both(cls, filled(stock_of(cls), size))


@pytest.mark.parametrize("cls", ARRAY_CLASSES, ids=IDS)
def test_new_message_has_genpys_bytes(cls):
    same_through_both(cls, stock_of(cls)())
    assert encoded(cls()) == encoded(stock_of(cls)())


@pytest.mark.parametrize("cls", ARRAY_CLASSES, ids=IDS)
def test_class_is_what_ros_knows(cls):
    stock = stock_of(cls)
    assert issubclass(cls, stock) and cls.__name__ == stock.__name__
    for name in ("_type", "_md5sum", "_full_text", "_slot_types", "_has_header", "__slots__"):
        if hasattr(stock, name):
            assert getattr(cls, name) == getattr(stock, name)
    assert not hasattr(cls(), "__dict__")


def test_every_message_with_arrays_of_numbers_has_an_array_class():
    """All but features, textures, parts of others, the few label colors, release 1.0's mesh."""
    others = {"Feature", "MeshFeatures", "MeshMaterial", "MeshTexture", "MeshTriangleIndices"}
    others |= {
        "LayerInfo",
        "LayerInfoArray",
        "LocalizationState",
        "MeshLabelColors",
        "MeshVertexTexCoords",
        "StoreResult",
        "TriangleMesh",
        "TriangleMeshStamped",
    }
    types = vars(mesh_msgs.msg).items()  # without names of old releases
    generated = {name for name, c in types if hasattr(c, "_type") and c.__name__ == name}
    assert {cls.__name__ for cls in ARRAY_MESSAGES} == generated - others


@pytest.mark.parametrize("dtype", ["<f4", "<f8", ">f8", ">f4", "f2", "i4", "u1", np.longdouble])
def test_any_float_type_and_layout_is_written_by_value(dtype):
    random = np.random.default_rng(1)
    values = (random.random((31, 3)) * 100).astype(dtype)
    faces = random.integers(0, 31, (57, 3))
    expected = mesh_msgs.msg.MeshGeometry()
    for x, y, z in values.astype(float).tolist():
        expected.vertices.append(genpy_point(x, y, z))
        expected.vertex_normals.append(genpy_point(z, y, x))
    for face in faces.tolist():
        expected.faces.append(mesh_msgs.msg.MeshTriangleIndices(face))
    wire = encoded(expected)
    wide = np.zeros((62, 6), dtype)
    wide[::2, ::2] = values
    for vertices in (values, np.asfortranarray(values), wide[::2, ::2]):
        for indices in (faces, faces.astype("u4"), faces.astype(">i2"), faces.astype("u8")):
            message = arrays.MeshGeometry(vertices, vertices[:, ::-1], indices)
            assert encoded(message) == wire


@pytest.mark.parametrize("count", [43_690, 43_691, 100_003])
def test_large_float32_arrays_are_converted_without_a_seam(count):
    values = np.random.default_rng(2).random((count, 3), np.float32)
    expected = struct.pack("<I", count) + values.astype("<f8").tobytes()
    assert encoded(arrays.MeshGeometry(vertices=values)) == expected + bytes(8)
    assert encoded(arrays.MeshGeometry(vertices=values[::-1])) == (
        struct.pack("<I", count) + values[::-1].astype("<f8").tobytes() + bytes(8)
    )


def genpy_point(x, y, z):
    return genpy.message.get_message_class("geometry_msgs/Point")(x, y, z)


def test_the_framing_of_rospy_is_the_same():
    stock = filled(mesh_msgs.msg.MeshGeometryStamped, 5)
    frames = []
    for message in (stock, arrays.MeshGeometryStamped.from_message(stock)):
        buffer = io.BytesIO()
        serialize_message(buffer, 77, message)
        serialize_message(buffer, 78, message)
        frames.append(buffer.getvalue())
    assert frames[0] == frames[1]


def test_member_of_a_stock_message_list_may_be_of_either_class():
    stock = filled(mesh_msgs.msg.MeshMaterials, 3)
    message = arrays.MeshMaterials.from_message(stock)
    message.clusters = [stock.clusters[0]] + [
        arrays.MeshFaceCluster(np.array(c.face_indices), c.label) for c in stock.clusters[1:]
    ]
    assert encoded(message) == encoded(stock)


def test_bytes_after_the_message_are_left_alone():
    wire = encoded(filled(mesh_msgs.msg.MeshVertexCosts, 4))
    assert encoded(arrays.MeshVertexCosts().deserialize(wire + b"\1\2\3")) == wire


def test_numpy_variants_are_the_same():
    stock = filled(mesh_msgs.msg.MeshVertexCostsStamped, 4)
    wire, buffer = encoded(stock), io.BytesIO()
    message = arrays.MeshVertexCostsStamped().deserialize_numpy(wire, np)
    message.serialize_numpy(buffer, np)
    assert buffer.getvalue() == wire and message == stock
