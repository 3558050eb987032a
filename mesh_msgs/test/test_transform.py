"""Transforms of meshes: against tf2's own transform of each point, and back again."""

import copy

import mesh_msgs.msg
import numpy as np
import pytest
import rospy
import tf2_geometry_msgs
import tf2_ros
from geometry_msgs.msg import Point, PointStamped, TransformStamped, Vector3Stamped
from hypothesis import given, settings
from hypothesis import strategies as st
from std_msgs.msg import ColorRGBA

from mesh_msgs import arrays, tf2_support, transform, zoo

FUNCTIONS = {
    "geometry": (transform.transform_geometry, "vertices", "vertex_normals"),
    "field": (transform.transform_vector_field, "positions", "vectors"),
    "triangles": (transform.transform_triangle_mesh, "vertices", "vertex_normals"),
}


def points(array):
    """(N, 3) of an array or a list of messages with x, y, z."""
    if isinstance(array, np.ndarray):
        return array
    return np.array([(p.x, p.y, p.z) for p in array]).reshape(-1, 3)


def stamped(kind, rng, count=30, generated=False):
    """A message of the kind in frame lidar at time 5 with random arrays."""
    xyz, normals = rng.normal(size=(2, count, 3))
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    faces = rng.integers(0, count, (count, 3)).astype(np.uint32)
    if kind == "geometry":
        message = arrays.MeshGeometryStamped(
            uuid="u", mesh_geometry=arrays.MeshGeometry(xyz, normals, faces)
        )
    elif kind == "field":
        message = arrays.VectorFieldStamped(vector_field=arrays.VectorField(xyz, normals))
    else:
        message = mesh_msgs.msg.TriangleMeshStamped()
        message.mesh.vertices = [Point(*row) for row in xyz.tolist()]
        message.mesh.vertex_normals = [Point(*row) for row in normals.tolist()]
        message.mesh.triangles = [mesh_msgs.msg.MeshTriangleIndices(row) for row in faces.tolist()]
        message.mesh.vertex_colors = [ColorRGBA(0.1, 0.2, 0.3, 1)] * count
    message.header.frame_id, message.header.seq = "lidar", 9
    message.header.stamp = rospy.Time(5)
    if generated and kind != "triangles":
        data = message_bytes(message)
        message = getattr(mesh_msgs.msg, type(message).__name__)()
        message.deserialize(data)
    return message


def message_bytes(message):
    import io

    buffer = io.BytesIO()
    message.serialize(buffer)
    return buffer.getvalue()


def inner(message):
    """The member that holds the arrays."""
    return getattr(message, message.__slots__[-1])


def random_transform(rng, target="map", source="lidar", stamp=5):
    result = TransformStamped()
    result.header.frame_id, result.child_frame_id = target, source
    result.header.stamp = rospy.Time(stamp)
    quaternion = rng.normal(size=4)
    quaternion /= np.linalg.norm(quaternion)
    for name, value in zip("xyzw", quaternion):
        setattr(result.transform.rotation, name, float(value))
    for name, value in zip("xyz", rng.normal(size=3) * 100):
        setattr(result.transform.translation, name, float(value))
    return result


def inverse(given_transform):
    rotation, translation = transform.rotation_and_translation(given_transform)
    result = copy.deepcopy(given_transform)
    result.header.frame_id, result.child_frame_id = "lidar", given_transform.header.frame_id
    for name in "xyz":
        setattr(result.transform.rotation, name, -getattr(result.transform.rotation, name))
    for name, value in zip("xyz", -rotation.T @ translation):
        setattr(result.transform.translation, name, float(value))
    return result


def each_by_tf2(given_transform, array, kind=PointStamped):
    result = []
    for row in array:
        message = kind()
        part = message.point if kind is PointStamped else message.vector
        part.x, part.y, part.z = (float(value) for value in row)
        if kind is PointStamped:
            moved = tf2_geometry_msgs.do_transform_point(message, given_transform).point
        else:
            moved = tf2_geometry_msgs.do_transform_vector3(message, given_transform).vector
        result.append((moved.x, moved.y, moved.z))
    return np.array(result)


@pytest.mark.parametrize("generated", [False, True])
@pytest.mark.parametrize("kind", FUNCTIONS)
def test_it_is_what_tf2_makes_of_each_point(kind, generated):
    rng = np.random.default_rng(1)
    function, place, direction = FUNCTIONS[kind]
    message, motion = stamped(kind, rng, generated=generated), random_transform(rng)
    moved = function(message, motion)
    old, new = inner(message), inner(moved)
    expected = each_by_tf2(motion, points(getattr(old, place)))
    np.testing.assert_allclose(points(getattr(new, place)), expected, atol=1e-12)
    expected = each_by_tf2(motion, points(getattr(old, direction)), Vector3Stamped)
    np.testing.assert_allclose(points(getattr(new, direction)), expected, atol=1e-14)


@pytest.mark.parametrize("kind", FUNCTIONS)
def test_stamp_uuid_and_the_rest_are_kept_and_nothing_is_shared(kind):
    rng = np.random.default_rng(2)
    message = stamped(kind, rng)
    before = copy.deepcopy(message)
    moved = FUNCTIONS[kind][0](message, random_transform(rng, stamp=77))
    assert (moved.header.frame_id, moved.header.stamp, moved.header.seq) == (
        "map",
        rospy.Time(5),
        9,
    )
    assert getattr(moved, "uuid", None) == getattr(message, "uuid", None)
    if kind == "geometry":
        assert np.array_equal(moved.mesh_geometry.faces, message.mesh_geometry.faces)
        moved.mesh_geometry.faces[:] = 0
    elif kind == "triangles":
        assert moved.mesh.triangles == message.mesh.triangles
        assert moved.mesh.vertex_colors == message.mesh.vertex_colors
        moved.mesh.vertex_colors[0].r = 0.9
    else:
        moved.vector_field.positions[:] = 0
    moved.header.stamp = rospy.Time(8)
    assert message == before


@settings(max_examples=50)
@given(seed=st.integers(0, 2**32 - 1), kind=st.sampled_from(sorted(FUNCTIONS)))
def test_there_and_back_is_where_it_was(seed, kind):
    rng = np.random.default_rng(seed)
    function, place, direction = FUNCTIONS[kind]
    message, motion = stamped(kind, rng, count=5), random_transform(rng)
    back = function(function(message, motion), inverse(motion))
    for name, error in ((place, 1e-11), (direction, 1e-14)):
        was = points(getattr(inner(message), name))
        assert np.abs(points(getattr(inner(back), name)) - was).max() < error
    lengths = np.linalg.norm(points(getattr(inner(back), direction)), axis=1)
    assert np.abs(lengths - 1).max() < 1e-14


@pytest.mark.parametrize("mesh", zoo.all_meshes(), ids=lambda mesh: mesh.name)
def test_every_mesh_of_the_zoo(mesh):
    message = arrays.MeshGeometryStamped(
        mesh_geometry=arrays.MeshGeometry(vertices=mesh.vertices, faces=mesh.faces)
    )
    moved = transform.transform_geometry(
        message, random_transform(np.random.default_rng(3), "m", "")
    )
    assert moved.mesh_geometry.vertices.shape == mesh.vertices.shape
    assert moved.mesh_geometry.vertex_normals.shape == (0, 3)
    assert np.array_equal(moved.mesh_geometry.faces, mesh.faces)


def test_a_received_message_is_moved():
    message = stamped("geometry", np.random.default_rng(4))
    received = arrays.MeshGeometryStamped()
    received.deserialize(message_bytes(message))
    motion = random_transform(np.random.default_rng(5))
    assert transform.transform_geometry(received, motion) == transform.transform_geometry(
        message, motion
    )


@pytest.mark.parametrize(
    "change, reason",
    [
        (lambda t: setattr(t.transform.rotation, "w", float("nan")), "not finite"),
        (lambda t: setattr(t.transform.translation, "x", float("inf")), "not finite"),
        (
            lambda t: setattr(t.transform, "rotation", type(t.transform.rotation)()),
            "length 0, not 1",
        ),
        (lambda t: setattr(t.transform.rotation, "w", 9.0), "not 1"),
        (lambda t: setattr(t, "child_frame_id", "camera"), "from 'camera' to 'map'.*in 'lidar'"),
    ],
)
@pytest.mark.parametrize("kind", FUNCTIONS)
def test_what_is_no_motion_of_this_frame_is_refused(kind, change, reason):
    rng = np.random.default_rng(6)
    motion = random_transform(rng)
    change(motion)
    with pytest.raises(transform.TransformError, match=reason):
        FUNCTIONS[kind][0](stamped(kind, rng), motion)


def buffer_of(*transforms):
    buffer = tf2_ros.Buffer(rospy.Duration(100), debug=False)
    for one in transforms:
        buffer.set_transform(one, "test")
    return buffer


@pytest.mark.parametrize("generated", [False, True])
@pytest.mark.parametrize("kind", FUNCTIONS)
def test_a_tf2_buffer_transforms_it(kind, generated):
    rng = np.random.default_rng(7)
    early, late = random_transform(rng, stamp=4), random_transform(rng, stamp=6)
    buffer = buffer_of(early, late)
    message = stamped(kind, rng, generated=generated)
    by_tf2 = buffer.lookup_transform("map", "lidar", rospy.Time(5))
    expected = FUNCTIONS[kind][0](message, by_tf2)
    assert buffer.transform(message, "map") == expected
    assert tf2_support.transform_at(buffer, message, "map") == expected
    at_end = tf2_support.transform_at(buffer, message, "map", rospy.Time(6))
    assert at_end == FUNCTIONS[kind][0](message, late) != expected
    assert tf2_support.transform_at(buffer, message, "map", rospy.Time(0)) == at_end
    assert at_end.header.stamp == rospy.Time(5)


def test_between_two_times_through_a_fixed_frame():
    rng = np.random.default_rng(8)
    early, late = random_transform(rng, stamp=5), random_transform(rng, stamp=6)
    message = stamped("geometry", rng)
    moved = tf2_support.transform_between_times(
        buffer_of(early, late), message, "lidar", rospy.Time(6), "map"
    )
    expected = transform.transform_geometry(
        transform.transform_geometry(message, early), inverse(late)
    )
    assert moved.header.stamp == rospy.Time(6) and moved.header.frame_id == "lidar"
    assert moved.uuid == message.uuid
    np.testing.assert_allclose(
        moved.mesh_geometry.vertices, expected.mesh_geometry.vertices, atol=1e-11
    )
    np.testing.assert_allclose(
        moved.mesh_geometry.vertex_normals, expected.mesh_geometry.vertex_normals, atol=1e-13
    )


@pytest.mark.parametrize(
    "frame, time, error",
    [
        ("nowhere", rospy.Time(5), tf2_ros.LookupException),
        ("map", rospy.Time(50), tf2_ros.ExtrapolationException),
    ],
)
def test_tf2_says_why_there_is_no_transform(frame, time, error):
    buffer = buffer_of(random_transform(np.random.default_rng(9)))
    message = stamped("geometry", np.random.default_rng(9))
    with pytest.raises(error):
        tf2_support.transform_at(buffer, message, frame, time)


def test_another_message_is_refused():
    buffer = buffer_of(random_transform(np.random.default_rng(10)))
    message = mesh_msgs.msg.MeshVertexCostsStamped()
    message.header.frame_id = "lidar"
    with pytest.raises(tf2_ros.TypeException):
        tf2_support.transform_at(buffer, message, "map")
