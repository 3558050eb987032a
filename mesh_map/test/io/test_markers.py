"""Markers."""

import genpy
import numpy as np
import pytest
from mesh_map.io import markers
from mesh_map.io.markers import no_marker, sphere_marker, triangles_marker
from mesh_msgs_hdf5.rendering.render_scale import RAINBOW, scale_colors
from visualization_msgs.msg import Marker

STAMP = genpy.Time(3)


def xyz(points):
    return np.array([[point.x, point.y, point.z] for point in points])


def field_of(vertices, vectors, values, **more):
    arrays = (np.array(numbers, np.float32) for numbers in (vertices, vectors, values))
    return markers.vector_field_marker(*arrays, "map", STAMP, **more)


def rgba(color):
    return [color.r, color.g, color.b, color.a]


def check(marker, kind, namespace):
    """What all markers have in common."""
    assert (marker.type, marker.ns, marker.action) == (kind, namespace, Marker.ADD)
    assert marker.header.frame_id == "map" and marker.header.stamp == STAMP
    turn = marker.pose.orientation
    assert (turn.x, turn.y, turn.z, turn.w) == (0, 0, 0, 1)


def test_lines_of_vertices_with_a_direction():
    vertices = [[0, 0, 0], [1, 0, 0], [2, 0, 5]]
    marker = field_of(vertices, [[1, 0, 0], [0, 0, 0], [0, 1, 0]], [1, 0, 2])
    check(marker, Marker.LINE_LIST, "vector_field")
    expected = [[0, 0, 0.01], [0.1, 0, 0.01], [2, 0, 5.01], [2, 0.1, 5.01]]
    assert np.allclose(xyz(marker.points), expected)
    assert rgba(marker.colors[2]) == [1, 0, 0, 1]
    assert len(marker.colors) == 4 and marker.scale.x == 0.01
    check(field_of(vertices, np.eye(3), [1, 2, 3], namespace="b"), Marker.LINE_LIST, "b")


def test_values_that_are_not_finite_are_red():
    marker = field_of(np.zeros((3, 3)), np.ones((3, 3)), [0, np.inf, np.nan])
    colors = [rgba(color) for color in marker.colors[::2]]
    assert colors == [[1, 0, 1, 1], [1, 0, 0, 1], [1, 0, 0, 1]]


def test_no_direction_anywhere():
    assert field_of([[0, 0, 0]], [[0, 0, 0]], [0]).points == []


def test_lines_of_faces():
    """From the middle of each face that has a direction; the mean at its corners is their color."""
    vertices = np.float32([[0, 0, 0], [3, 0, 0], [0, 3, 3], [3, 3, 0]])
    faces = np.uint32([[0, 1, 2], [1, 3, 2], [0, 1, 3]])
    vectors = np.float32([[0, 0, 0], [0, 1, 0], [1, 0, 0]])
    values = np.float32([0, 1, 2, 6])
    marker = field_of(vertices, vectors, values, faces=faces)
    check(marker, Marker.LINE_LIST, "vector_field")
    expected = [[2, 2, 1.01], [2, 2.1, 1.01], [2, 1, 0.01], [2.1, 1, 0.01]]
    assert np.allclose(xyz(marker.points), expected)
    assert rgba(marker.colors[0]) == [1, 0, 0, 1]  # 3, the largest mean
    half = scale_colors(RAINBOW, np.array([7 / 9]))[0]
    assert np.allclose(rgba(marker.colors[2])[:3], half)
    values[0] = np.inf
    marker = field_of(vertices, vectors, values, namespace="b", faces=faces)
    check(marker, Marker.LINE_LIST, "b")
    assert [rgba(color) for color in marker.colors] == [[1, 0, 0, 1]] * 4


@pytest.mark.parametrize("count, lines", [(10, 10), (11, 6), (95, 10)])
def test_large_fields_are_thinned_out(monkeypatch, count, lines):
    monkeypatch.setattr(markers, "MAX_LINES", 10)
    marker = field_of(np.zeros((count, 3)), np.ones((count, 3)), np.ones(count))
    assert len(marker.points) == 2 * lines


def test_sphere():
    marker = sphere_marker("here", np.float32([1, 2, 3]), "map", STAMP, (0, 1, 0, 0.5))
    check(marker, Marker.SPHERE, "here")
    assert xyz([marker.pose.position]).tolist() == [[1, 2, 3]]
    assert rgba(marker.color) == [0, 1, 0, 0.5]
    assert (marker.scale.x, marker.scale.y, marker.scale.z) == (0.05, 0.05, 0.05)


def test_triangles():
    corners = np.arange(18.0).reshape(6, 3)
    marker = triangles_marker("faces", corners, "map", STAMP)
    check(marker, Marker.TRIANGLE_LIST, "faces")
    assert np.array_equal(xyz(marker.points), corners) and marker.scale.x == 1
    lifted = triangles_marker("faces", corners, "map", STAMP, normal=(0, 0, 1))
    assert np.allclose(xyz(lifted.points), corners + [0, 0, 0.01])


def test_a_marker_that_takes_another_away():
    marker = no_marker("here", "map", STAMP)
    assert (marker.ns, marker.action, marker.pose.orientation.w) == ("here", Marker.DELETE, 1)
