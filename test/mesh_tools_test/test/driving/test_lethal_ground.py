"""Distances of poses from what is lethal, along the surface, against plane geometry."""

import numpy as np
import pytest
from mesh_map.map.mesh_map import MeshMap
from mesh_msgs import zoo
from mesh_tools_test.driving.lethal_ground import FARTHEST, LethalGround


def grid_map(cells=10, size=2.0):
    mesh = zoo.grid(cells=cells, size=size)
    return MeshMap(mesh.vertices, mesh.faces)


def costs_with(mesh_map, lethal, value=np.inf):
    costs = np.zeros(len(mesh_map.vertices), np.float32)
    costs[lethal] = value
    return costs


@pytest.mark.parametrize("value", [np.inf, np.nan])
def test_of_a_vertex_an_edge_and_a_face(value):
    mesh_map = grid_map()
    lethal = [
        int(np.argmin(np.linalg.norm(mesh_map.vertices - [*place, 0.0], axis=1)))
        for place in ((0.4, 0.4), (1.4, 0.6), (1.4, 0.8), (1.0, 1.6), (1.2, 1.6), (1.2, 1.8))
    ]
    ground = LethalGround(mesh_map, costs_with(mesh_map, lethal, value))
    random = np.random.default_rng(0)
    points = np.column_stack([random.uniform(0.0, 2.0, (60, 2)), np.zeros(60)])
    x, y = points[:, :2].T
    expected = np.minimum(np.hypot(x - 0.4, y - 0.4), np.hypot(x - 1.4, y - np.clip(y, 0.6, 0.8)))
    corners = np.array([(1.0, 1.6), (1.2, 1.6), (1.2, 1.8)])
    shares = np.linspace(0.0, 1.0, 2001)[:, None]
    for a, b in ((0, 1), (1, 2), (2, 0)):
        side = corners[a] + shares * (corners[b] - corners[a])
        offsets = np.linalg.norm(points[:, None, :2] - side, axis=2)
        expected = np.minimum(expected, offsets.min(axis=1))
    inside = (x > 1.0) & (x < 1.2) & (y > 1.6) & (y - 1.6 < x - 1.0)
    expected[inside] = 0.0
    np.testing.assert_allclose(ground.straight(points), expected, atol=1e-5)
    near = expected < FARTHEST
    assert near.sum() > 20
    along = [ground.along_surface(point) for point in points[near]]
    np.testing.assert_allclose(along, expected[near], atol=1e-5)
    assert ground.nearest(points).number == np.argmin(expected)
    assert ground.along_surface(np.array([1.1, 1.65, 0.0])) == 0.0


def test_what_is_near_through_space_alone_is_not_near():
    """A sheet 0.1 m above the ground, in which everything is lethal."""
    below, above = zoo.grid(cells=10, size=2.0), zoo.grid(cells=10, size=2.0)
    count = len(below.vertices)
    vertices = np.concatenate([below.vertices, above.vertices + np.float32([0.0, 0.0, 0.1])])
    mesh_map = MeshMap(vertices, np.concatenate([below.faces, above.faces + count]))
    ground = LethalGround(mesh_map, costs_with(mesh_map, np.arange(count, 2 * count)))
    point = np.array([[0.71, 0.93, 0.0]])
    assert ground.straight(point)[0] == pytest.approx(0.1, abs=1e-6)
    assert ground.along_surface(point[0]) == np.inf
    assert ground.nearest(point).distance == FARTHEST


def test_around_a_corner_of_the_surface():
    """Two walls meet the floor at right angles: along the surface it is the sum."""
    mesh = zoo.grid(cells=8, size=0.8)
    vertices = mesh.vertices.copy()
    folded = vertices[:, 0] > 0.4
    vertices[folded, 2] = vertices[folded, 0] - 0.4
    vertices[folded, 0] = 0.4
    mesh_map = MeshMap(vertices, mesh.faces)
    lethal = np.flatnonzero(np.isclose(mesh.vertices[:, 0], 0.6))
    ground = LethalGround(mesh_map, costs_with(mesh_map, lethal))
    point = np.array([0.27, 0.43, 0.0])
    assert ground.along_surface(point) == pytest.approx(0.13 + 0.2, abs=1e-6)
    assert ground.straight(point[None])[0] == pytest.approx(np.hypot(0.13, 0.2), abs=1e-6)
    found = ground.nearest(np.array([[0.1, 0.1, 0.0], point]))
    assert found.number == 1 and found.distance == pytest.approx(0.33, abs=1e-6)


def test_nothing_is_lethal():
    mesh_map = grid_map()
    ground = LethalGround(mesh_map, costs_with(mesh_map, []))
    assert ground.nearest(np.zeros((3, 3))) == (np.inf, -1)
