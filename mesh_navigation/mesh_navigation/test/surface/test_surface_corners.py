"""Which vertices lie along ways over the surface, against points all along them."""

import numpy as np
import pytest
from navigation_test_maps import BY_NAME, PASSABLE, random_pairs

from mesh_map.map.mesh_map import MeshMap
from mesh_navigation.surface.surface_corners import corners_along, nearest_corners


@pytest.mark.parametrize("mesh", PASSABLE, **BY_NAME)
def test_corners_along_walks_are_those_of_points_all_along(mesh):
    geometry = MeshMap(mesh.vertices, mesh.faces).geometry
    random = np.random.default_rng(1)
    size, checked = float(np.ptp(mesh.vertices, axis=0).max()), 0
    for (face, point), _ in random_pairs(mesh, 10, seed=2):
        start = geometry.closest_face(point, np.inf)
        walk = geometry.walker.walk(
            start=start, direction=random.normal(size=3), length=size * random.random(), path=True
        )
        if walk.path is None or not len(walk.path.faces):
            continue
        found = corners_along(geometry, walk.path)
        assert (np.diff(found.entered) >= -1e-12).all() and found.entered[0] == 0.0
        assert (np.diff(found.vertices) != 0).all()
        before = 0.0
        for face, begin, end in zip(walk.path.faces, walk.path.points, walk.path.points[1:]):
            length = np.linalg.norm(end - begin)
            # Not the ends: there the next face may have another nearest corner.
            shares = np.linspace(0, 1, 30)[1:-1]
            points = begin + shares[:, None] * (end - begin)
            corners = mesh.vertices[mesh.faces[face]].astype(np.float64)
            distances = np.linalg.norm(points[:, None] - corners, axis=2)
            index = np.searchsorted(found.entered, before + shares * length, side="right") - 1
            for distance, there in zip(distances, found.vertices[index]):
                if length > 1e-6 * (1 + size):
                    said = distance[mesh.faces[face].tolist().index(there)]
                    assert said <= distance.min() + 1e-6 * (1 + size)
                    checked += 1
            before += length
    assert checked > 100


def test_a_third_corner_that_is_nearest_in_the_middle():
    vertices = np.array([[0, 0, 0], [4, 0, 0], [2, 1, 0]], np.float32)
    geometry = MeshMap(vertices, [[0, 1, 2]]).geometry
    start = geometry.closest_face((0.5, 0.2, 0), 1.0)
    walk = geometry.walker.walk(start=start, direction=(1, 0, 0), length=3.0, path=True)
    found = corners_along(geometry, walk.path)
    assert found.vertices.tolist() == [0, 2, 1]
    # Equally near (0, 0) and (2, 1): 4 x + 2 y = 5.
    np.testing.assert_allclose(found.entered, [0.0, 1.15 - 0.5, 4 - 1.15 - 0.5], atol=1e-6)


def test_a_way_of_no_length():
    vertices = np.array([[0, 0, 0], [4, 0, 0], [2, 1, 0]], np.float32)
    geometry = MeshMap(vertices, [[0, 1, 2]]).geometry
    start = geometry.closest_face((3, 0.1, 0), 1.0)
    walk = geometry.walker.walk(start=start, direction=(1, 0, 0), length=0.0, path=True)
    assert corners_along(geometry, walk.path).vertices.tolist() in ([], [1])


def test_points_have_the_nearest_corner():
    vertices = np.array([[0, 0, 0], [4, 0, 0], [2, 1, 0]], np.float32)
    geometry = MeshMap(vertices, [[0, 1, 2]]).geometry
    points = [[0.2, 0.05, 0], [2, 0.3, 0], [3.9, 0, 0.1]]
    carried = geometry.spatial_index.closest_batch(points=np.array(points), max_distance=1.0)
    found = nearest_corners(geometry, carried.faces, carried.positions)
    assert found.tolist() == [0, 2, 1]
    assert nearest_corners(geometry, np.zeros(0, np.int64), np.zeros((0, 3))).tolist() == []
