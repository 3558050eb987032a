"""The marker of a vector field."""

import genpy
import numpy as np

from mesh_navigation import vector_field_marker
from mesh_navigation.vector_field_marker import rainbow


def xyz(points):
    return np.array([[point.x, point.y, point.z] for point in points])


def marker_of(vertices, vectors, potential):
    arrays = (np.array(values, np.float32) for values in (vertices, vectors, potential))
    return vector_field_marker.vector_field_marker(*arrays, "map", genpy.Time(3))


def test_lines_of_vertices_with_a_direction():
    vertices = [[0, 0, 0], [1, 0, 0], [2, 0, 5]]
    marker = marker_of(vertices, [[1, 0, 0], [0, 0, 0], [0, 1, 0]], [1, 0, 2])
    expected = [[0, 0, 0.01], [0.1, 0, 0.01], [2, 0, 5.01], [2, 0.1, 5.01]]
    assert np.allclose(xyz(marker.points), expected)
    assert marker.header.frame_id == "map" and marker.header.stamp == genpy.Time(3)
    assert [marker.colors[2].r, marker.colors[2].g, marker.colors[2].a] == [1, 0, 1]
    assert len(marker.colors) == 4 and marker.pose.orientation.w == 1 and marker.scale.x == 0.01


def test_no_direction_anywhere():
    assert marker_of([[0, 0, 0]], [[0, 0, 0]], [0]).points == []


def test_large_fields_are_thinned_out(monkeypatch):
    monkeypatch.setattr(vector_field_marker, "MAX_LINES", 10)
    for count, lines in ((10, 10), (11, 6), (95, 10)):
        marker = marker_of(np.zeros((count, 3)), np.ones((count, 3)), np.ones(count))
        assert len(marker.points) == 2 * lines


def test_rainbow_runs_from_purple_over_blue_and_green_to_red():
    colors = rainbow(np.array([0.0, 0.2, 0.4, 0.6, 0.8, 1.0]))
    expected = [[1, 0, 1], [0, 0, 1], [0, 1, 1], [0, 1, 0], [1, 1, 0], [1, 0, 0]]
    assert np.allclose(colors, expected)
