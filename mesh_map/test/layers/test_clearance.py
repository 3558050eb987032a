"""The layer of clearances, against every ray and every face in plain NumPy."""

import gc
import weakref

import numpy as np
import pytest
from mesh_map.layers import clearance
from mesh_map.layers.clearance import ClearanceLayer, clearances
from mesh_map.map.mesh_map import MeshMap
from meshes import SMALL, small, terrain


def plate(height, turned=False, at=(0.0, 0.0), size=2.0):
    """A square of two faces around a place."""
    corners = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]]) * size / 2 + at
    vertices = np.column_stack([corners, np.full(4, float(height))])
    faces = np.array([[0, 1, 2], [0, 2, 3]])
    return vertices, faces[:, ::-1] if turned else faces


def joined(*parts, shift=(0.0, 0.0, 0.0)):
    vertices, faces, count = [], [], 0
    for part_vertices, part_faces in parts:
        vertices.append(part_vertices + shift)
        faces.append(part_faces + count)
        count += len(part_vertices)
    return np.concatenate(vertices).astype(np.float32), np.concatenate(faces).astype(np.uint32)


def brute_force(mesh_map):
    """Each ray against each face: Moeller and Trumbore, without a tolerance; (V,) distances and
    whether a ray passes an edge or a vertex so closely that rounding decides."""
    normals = mesh_map.vertex_normals.astype(np.float64)
    origins = mesh_map.vertices + 1e-3 * normals
    best, close = np.full(len(origins), np.inf), np.zeros(len(origins), bool)
    a, b, c = (mesh_map.vertices[mesh_map.faces[:, k]].astype(np.float64) for k in range(3))
    with np.errstate(divide="ignore", invalid="ignore"):
        for v, (origin, way) in enumerate(zip(origins, normals)):
            p = np.cross(way, c - a)
            det = np.einsum("ij,ij->i", b - a, p)
            s = origin - a
            u = np.einsum("ij,ij->i", s, p) / det
            q = np.cross(s, b - a)
            w = q @ way / det
            t = np.einsum("ij,ij->i", c - a, q) / det
            hit = (u >= 0) & (w >= 0) & (u + w <= 1) & (t >= 0)
            best[v] = t[hit].min() if hit.any() else np.inf
            margin = np.minimum(np.minimum(u, w), np.minimum(1 - u - w, t))
            close[v] = (np.abs(margin) < 1e-6).any() or (np.abs(det) < 1e-9).any()
    return best + 1e-3, close


def expected_costs(room, height, inflation):
    """The sheet's formula, one vertex after the other."""
    costs = []
    for c in room:
        if c < height:
            costs.append(1.0)
        elif c < height + inflation:
            costs.append((np.cos(np.pi * (c - height) / inflation) + 1) / 2)
        else:
            costs.append(0.0)
    return np.array(costs)


MESHES = [mesh for mesh in SMALL if len(mesh.faces) < 500] + [terrain(12)]


@pytest.mark.parametrize("mesh", MESHES, ids=[mesh.name for mesh in MESHES])
def test_clearance_equals_brute_force(mesh):
    mesh_map = MeshMap(mesh.vertices, mesh.faces)
    room = clearances(mesh_map.geometry)
    expected, close = brute_force(mesh_map)
    np.testing.assert_allclose(room[~close], expected[~close], rtol=1e-5, atol=1e-6)
    assert not np.isnan(room).any() and (room > 0).all()


def test_brute_force_decides_enough():
    decided = [(~brute_force(MeshMap(mesh.vertices, mesh.faces))[1]).sum() for mesh in MESHES]
    assert sum(decided) > 500


@small
def test_costs_follow_the_formula(mesh):
    mesh_map = MeshMap(mesh.vertices, mesh.faces)
    room = clearances(mesh_map.geometry)
    for height, inflation in ((0.5, 0.3), (1.0, 2.0), (0.05, 0.0), (3.0, 100.0)):
        layer = ClearanceLayer("c", {"robot_height": height, "height_inflation": inflation})
        result = layer.evaluate(mesh_map, {})
        np.testing.assert_allclose(
            result.costs, expected_costs(room.astype(np.float64), height, inflation), atol=2e-6
        )
        np.testing.assert_array_equal(result.lethal, room < np.float32(height))
        np.testing.assert_array_equal(result.costs == 1, result.lethal)
        reused = layer.reuse(result.costs, mesh_map, {})
        np.testing.assert_array_equal(reused.lethal, result.lethal)
        np.testing.assert_array_equal(reused.costs, result.costs)


def test_a_door_of_each_height():
    """Floor vertices below lintels of rising heights; the border of lethal is exact."""
    heights = [0.3, 0.499, 0.5, 0.501, 0.65, 0.799, 0.8, 2.0]
    parts = []
    for number, height in enumerate(heights):
        parts += [plate(0.0, at=(5.0 * number, 0.0)), plate(height, at=(5.0 * number, 0), size=4)]
    mesh_map = MeshMap(*joined(*parts))
    floor = np.arange(len(heights)) * 8
    result = ClearanceLayer("c").evaluate(mesh_map, {})
    assert result.lethal[floor].tolist() == [True, True] + [False] * 6
    room = clearances(mesh_map.geometry)[floor]
    np.testing.assert_allclose(room, heights, atol=1e-6)
    np.testing.assert_allclose(result.costs[floor], expected_costs(room, 0.5, 0.3), atol=1e-6)
    assert result.costs[floor][2] == np.nextafter(np.float32(1), np.float32(0))
    assert 0 < result.costs[floor][4] < 0.6 and result.costs[floor][7] == 0


@pytest.mark.parametrize("turned", [False, True])
def test_faces_count_from_both_sides(turned):
    mesh_map = MeshMap(*joined(plate(0.0), plate(0.4, turned)))
    np.testing.assert_allclose(clearances(mesh_map.geometry)[:4], 0.4, atol=1e-6)
    upper = clearances(mesh_map.geometry)[4:]
    np.testing.assert_allclose(upper, 0.4 if turned else np.inf, atol=1e-6)


@pytest.mark.parametrize("distance", [0.0, 1e3, 1e5, 1e6])
def test_far_from_the_origin(distance):
    """A surface whose faces do not share vertices has seams that gape by the rounding of its
    coordinates: these do not count as a roof, and the roof is found."""
    mesh = terrain(12)
    ground = (mesh.vertices * (10, 10, 0.1) + (distance, -distance, distance))[mesh.faces.ravel()]
    ground = ground.astype(np.float32)
    random = np.random.default_rng(4)
    for side in (-np.inf, np.inf):
        moved = random.random(ground.shape) < 0.3
        ground[moved] = np.nextafter(ground, np.float32(side))[moved]
    own = np.arange(len(ground)).reshape(-1, 3)
    height = 60.0
    roof_vertices, roof_faces = plate(height, at=(5.5, 5.5), size=300.0)
    roof = (roof_vertices + (distance, -distance, distance), roof_faces)
    mesh_map = MeshMap(*joined((ground, own), roof))
    normals = np.tile(np.float32([0, 0, 1]), (len(mesh_map.vertices), 1))
    upward = MeshMap(mesh_map.vertices, mesh_map.faces, normals)
    room = clearances(upward.geometry)[: len(ground)]
    expected = mesh_map.vertices[-1, 2] - ground[:, 2].astype(np.float64)
    np.testing.assert_allclose(room, expected, rtol=1e-5)


def test_given_normals_and_vertices_without_faces():
    vertices, faces = joined(plate(0.0), plate(0.4))
    vertices = np.append(vertices, [[0, 0, 0.1]], axis=0).astype(np.float32)
    normals = np.tile(np.float32([0, 0, 1]), (len(vertices), 1))
    normals[0] = (0, 0, -1)
    mesh_map = MeshMap(vertices, faces, normals)
    room = clearances(mesh_map.geometry)
    np.testing.assert_allclose(room[[0, 1, 8]], [np.inf, 0.4, 0.3], atol=1e-6)
    costs = ClearanceLayer("c").evaluate(mesh_map, {}).costs
    assert np.isfinite(costs).all() and costs[[0, 1, 8]].tolist() == [0, 1, 1]


def test_rays_are_cast_once_for_a_geometry(monkeypatch):
    mesh = terrain(8)
    first = MeshMap(mesh.vertices, mesh.faces)
    calls = []
    monkeypatch.setattr(
        clearance, "_cast", lambda g, cast=clearance._cast: calls.append(1) or cast(g)
    )
    for mesh_map in (first, MeshMap.of(first.geometry)):
        for height in (0.2, 0.9):
            ClearanceLayer("c", {"robot_height": height}).compute(mesh_map, {})
    assert len(calls) == 1
    geometry = weakref.ref(first.geometry)
    del first, mesh_map
    gc.collect()
    assert geometry() is None
