"""Barycentric coordinates and closest points."""

import numpy as np
import pytest
from mesh_map.geometry.surface import barycentric_coordinates, is_inside
from mesh_map.map.mesh_map import MeshMap
from mesh_map.spatial.hits import NO_FACE
from mesh_map.spatial.spatial_index import SpatialIndex
from meshes import data_mesh, real, small, terrain
from oracles import distances_to_faces
from scipy.optimize import minimize
from scipy.spatial import cKDTree


def queries(mesh, count, seed=0):
    """Points around the mesh, on its vertices and edges, and on its faces."""
    random = np.random.default_rng(seed)
    vertices = mesh.vertices.astype(np.float64)
    low, high = vertices.min(0), vertices.max(0)
    around = random.uniform(
        low - 0.3 * (high - low) - 0.1, high + 0.3 * (high - low) + 0.1, (count, 3)
    )
    weights = random.dirichlet((1, 1, 1), count)
    weights[::3, 0] = 0
    weights[::5, 1] = 0
    weights /= np.maximum(weights.sum(1, keepdims=True), 1e-9)
    corners = vertices[mesh.faces[random.integers(0, len(mesh.faces), count)]]
    return np.concatenate([around, np.einsum("nk,nkd->nd", weights, corners), vertices[:count]])


def check(mesh, count):
    points = queries(mesh, count)
    found = SpatialIndex(mesh.vertices, mesh.faces).closest_batch(points=points)
    scale = 1 + np.abs(mesh.vertices).max()
    for i, (point, distances) in enumerate(zip(points, distances_to_faces(mesh, points))):
        tolerance = 1e-9 * scale
        assert abs(found.distances[i] - distances.min()) <= tolerance
        assert distances[found.faces[i]] <= distances.min() + tolerance
        corners = mesh.vertices[mesh.faces[found.faces[i]]].astype(np.float64)
        assert np.allclose(found.barycentric[i] @ corners, found.positions[i], atol=tolerance)
        assert is_inside(found.barycentric[i], 1e-12) and np.isclose(found.barycentric[i].sum(), 1)
        gap = np.linalg.norm(found.positions[i] - point)
        assert abs(gap - found.distances[i]) <= tolerance


@small
def test_closest_points_equal_numpy(mesh):
    check(mesh, 40)


@real
def test_closest_points_on_real_meshes(name):
    check(data_mesh(name), 30)


def test_one_point_and_many_find_the_same():
    mesh = terrain(184)  # over 65,536 faces
    points = queries(mesh, 20)
    index = SpatialIndex(mesh.vertices, mesh.faces)
    many = index.closest_batch(points=points)
    for i, point in enumerate(points):
        one = index.closest_batch(points=[point])
        assert all(np.array_equal(a[0], b[i]) for a, b in zip(one, many))


def test_of_faces_as_near_the_first_is_named():
    mesh = terrain(300)
    for vertex in (0, 45_000, 89_999):
        point = mesh.vertices[vertex]
        first = np.flatnonzero((mesh.faces == vertex).any(1))[0]
        found = SpatialIndex(mesh.vertices, mesh.faces).closest_batch(points=[point])
        assert found.faces[0] == first and found.distances[0] == 0


def test_the_first_is_named_whichever_thread_is_faster():
    """The second of two threads has four faces to look at, the first 65,536, its last as near."""
    random = np.random.default_rng(0)
    vertices = np.concatenate([[[9, 9, 0], [10, 9, 0], [9, 10, 0]], random.normal(size=(999, 3))])
    faces = random.integers(3, 1000, (65_540, 3))
    faces[[65_535, 65_536, 65_538]] = 0, 1, 2
    for _ in range(5):
        found = SpatialIndex(vertices, faces).closest_batch(points=[[9.25, 9.25, 0.5]])
        assert found.faces[0] == 65_535 and found.distances[0] == 0.5


def test_distance_limit_counts_on_both_sides():
    mesh_map = MeshMap([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]])
    for height in (0.5, -0.5):
        point = (0.25, 0.25, height)
        hit = mesh_map.closest_face(point, 0.5)
        assert hit.face == 0 and hit.distance == 0.5
        assert hit.position.tolist() == [0.25, 0.25, 0]
        assert hit.barycentric.tolist() == [0.5, 0.25, 0.25]
        assert mesh_map.closest_face(point, np.nextafter(0.5, 0)) is None
    assert mesh_map.nearest_vertex((2, 0, 0), 1.0) == (1, 1.0)
    assert mesh_map.nearest_vertex((2, 0, 0), 0.99) is None


def test_points_that_are_not_finite_find_nothing():
    mesh = terrain(5)
    bad = [[np.nan, 0, 0], [0, np.inf, 0], [0, 0, -np.inf]]
    found = SpatialIndex(mesh.vertices, mesh.faces).closest_batch(points=bad + [[0, 0, 0]])
    assert (found.faces[:3] == NO_FACE).all() and found.faces[3] != NO_FACE
    mesh_map = MeshMap(mesh.vertices, mesh.faces)
    assert all(mesh_map.closest_face(point, np.inf) is None for point in bad)
    assert all(mesh_map.nearest_vertex(point, np.inf) is None for point in bad)


def test_bad_questions_are_refused():
    mesh = terrain(5)
    mesh_map = MeshMap(mesh.vertices, mesh.faces)
    for distance in (-1, np.nan):
        with pytest.raises(ValueError, match="maximum distance has to be 0 or more"):
            mesh_map.closest_face((0, 0, 0), distance)
        with pytest.raises(ValueError, match="maximum distance has to be 0 or more"):
            mesh_map.nearest_vertex((0, 0, 0), distance)
    with pytest.raises(ValueError, match=r"point has to have the shape \(3\)"):
        mesh_map.nearest_vertex((0, 0), 1)
    with pytest.raises(ValueError, match=r"points has to have the shape \(N, 3\)"):
        SpatialIndex(mesh.vertices, mesh.faces).closest_batch(points=[[0, 0]])


def test_nearest_vertex_equals_scipy():
    mesh = terrain(80)
    mesh_map = MeshMap(mesh.vertices, mesh.faces)
    points = queries(mesh, 50)
    distances, nearest = cKDTree(mesh.vertices.astype(np.float64)).query(points)
    for point, distance, vertex in zip(points, distances, nearest):
        assert mesh_map.nearest_vertex(point, np.inf) == (vertex, pytest.approx(distance))


def test_isolated_vertices_are_not_near():
    mesh_map = MeshMap([[9, 9, 9], [0, 0, 0], [1, 0, 0], [0, 1, 0]], [[1, 2, 3]])
    assert mesh_map.nearest_vertex((9, 9, 9), np.inf)[0] in (2, 3)


def test_barycentric_coordinates():
    """The projection is the nearest point of the plane; inside means all weights in [0, 1]."""
    random = np.random.default_rng(0)
    a, b, c, points = random.normal(size=(4, 200, 3))
    weights = barycentric_coordinates(points, a, b, c)
    foot = weights[:, :1] * a + weights[:, 1:2] * b + weights[:, 2:] * c
    np.testing.assert_allclose(weights.sum(1), 1)
    for side in (b - a, c - a):
        np.testing.assert_allclose(np.sum((points - foot) * side, 1), 0, atol=1e-9)
    inside = is_inside(weights)
    assert np.array_equal(inside, (weights.min(1) >= 0)) and 0 < inside.sum() < 200
    least = minimize(
        lambda w: np.sum((points[0] - a[0] - w[0] * (b - a)[0] - w[1] * (c - a)[0]) ** 2),
        (0, 0),
        tol=1e-14,
    )
    np.testing.assert_allclose(weights[0, 1:], least.x, atol=1e-5)
    assert barycentric_coordinates((0.25, 0.5, 9), (0, 0, 0), (1, 0, 0), (0, 1, 0)).tolist() == [
        0.25,
        0.25,
        0.5,
    ]


def test_barycentric_coordinates_without_area():
    weights = barycentric_coordinates([[0, 0, 0], [5, 0, 0]], (0, 0, 0), (1, 0, 0), (2, 0, 0))
    assert np.isnan(weights).all() and not is_inside(weights).any()
    assert is_inside((-0.005, 0.5, 0.505), 0.01) and not is_inside((-0.005, 0.5, 0.505))
