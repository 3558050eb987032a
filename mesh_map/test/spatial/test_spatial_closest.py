"""Closest points against NumPy, face by face; native and OpenCL alike."""

import math

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st
from mesh_map import MeshMap
from mesh_map.spatial.device_batches import ClosestPointFinder
from mesh_map.spatial.hits import NO_FACE
from mesh_map.spatial.spatial_index import SpatialIndex, query_counts
from mesh_msgs import zoo
from meshes import data_mesh, real, terrain
from oracles import distances_to_faces, needle_doubts, normals_within
from spatial_samples import (
    ADVERSARIAL,
    BACK_ENDS,
    adversarial,
    identical_triangles,
    index_of,
    same,
    some_points,
)


def check_points(mesh, index, points, back_end, limit=np.inf, mask=None, step=1):
    """A batch against NumPy (every step-th point), single questions against the batch."""
    asked = {"max_distance": limit, "mask": mask}
    found = index.closest_batch(points=points, **asked, back_end=back_end)
    counts = np.ones(len(mesh.faces), bool) if mask is None else mask
    needles = needle_doubts(mesh)
    largest = np.abs(mesh.vertices[mesh.faces]).max()
    expected = np.where(counts, distances_to_faces(mesh, points[::step]), np.inf)
    for i, distances in zip(range(0, len(points), step), expected):
        point, face = points[i], found.faces[i]
        doubt = 1e-11 * (1 + largest + np.abs(point).max())
        doubt += needles[np.argmin(distances)] + (0 if face == NO_FACE else needles[face])
        one = index.closest(point=point, **asked)
        if face == NO_FACE:
            assert distances.min() > limit - doubt and one is None
            assert found.distances[i] == np.inf and not found.barycentric[i].any()
            continue
        assert counts[face] and found.distances[i] <= limit
        assert abs(found.distances[i] - distances.min()) <= doubt
        assert distances[face] <= distances.min() + doubt
        corners = mesh.vertices[mesh.faces[face]].astype(np.float64)
        assert found.barycentric[i].min() > -1e-12 and abs(found.barycentric[i].sum() - 1) < 1e-12
        assert np.allclose(found.barycentric[i] @ corners, found.positions[i], atol=10 * doubt)
        gap = np.linalg.norm(found.positions[i] - point)
        assert abs(gap - found.distances[i]) <= doubt
        assert same(tuple(map(np.float64, one)), tuple(np.float64(array[i]) for array in found))
    return found


@BACK_ENDS
@adversarial
def test_closest_points_equal_numpy(mesh, back_end):
    index = index_of(mesh, back_end)
    random = np.random.default_rng(1)
    points = some_points(mesh, random, 30)
    check_points(mesh, index, points, back_end)
    mask = random.random(len(mesh.faces)) < 0.5
    check_points(mesh, index, points, back_end, limit=0.3, mask=mask)


@BACK_ENDS
@real
def test_closest_points_on_real_meshes(name, back_end):
    mesh = data_mesh(name)
    index = index_of(mesh, back_end)
    points = some_points(mesh, np.random.default_rng(2), 3000)
    check_points(mesh, index, points, back_end, step=150)


@settings(max_examples=50)
@given(st.sampled_from(ADVERSARIAL), st.integers(0, 2**32 - 1), st.sampled_from([0, 0.2, np.inf]))
def test_opencl_is_native_to_the_last_bit(mesh, seed, limit):
    index = index_of(mesh, "opencl")
    random = np.random.default_rng(seed)
    points = some_points(mesh, random, 150)
    rows = random.choice(len(points), 8, replace=False)
    odd = random.choice([np.nan, np.inf, -np.inf, 1e300, -1e-310], 8)
    points[rows, random.integers(0, 3, 8)] = odd
    for mask in (None, random.random(len(mesh.faces)) < 0.5):
        asked = {"points": points, "max_distance": limit, "mask": mask}
        native = index.closest_batch(**asked, back_end="native")
        assert same(index.closest_batch(**asked, back_end="opencl"), native)
        assert (native.faces[rows[np.abs(odd) == np.inf]] == NO_FACE).all()


@settings(max_examples=50)
@given(st.sampled_from(ADVERSARIAL), st.integers(0, 2**32 - 1))
def test_limited_normals_equal_numpy(mesh, seed):
    index = SpatialIndex(mesh.vertices, mesh.faces)
    random = np.random.default_rng(seed)
    points, angle = some_points(mesh, random, 4), random.uniform(0, math.pi)
    normals, needles = random.normal(size=points.shape), needle_doubts(mesh)
    found = index.closest_batch(points=points, normals=normals, max_angle=angle)
    for i, (point, distances) in enumerate(zip(points, distances_to_faces(mesh, points))):
        within = normals_within(mesh, normals[i], angle)
        doubt = 1e-11 * (1 + np.abs(mesh.vertices[mesh.faces]).max() + np.abs(point).max())
        one = index.closest(point=point, normal=normals[i], max_angle=angle)
        if found.faces[i] == NO_FACE:
            assert not within.surely.any() and one is None
            continue
        assert (one.face, one.distance) == (found.faces[i], found.distances[i])
        assert within.perhaps[one.face]
        doubt += needles[one.face]
        assert one.distance <= np.where(within.surely, distances + needles, np.inf).min() + doubt
        assert abs(one.distance - distances[one.face]) <= doubt
    alike = index.closest_batch(points=points, normals=[0.0, 0.0, 2.0], max_angle=angle)
    rows = np.tile([0.0, 0.0, 2.0], (len(points), 1))
    assert same(alike, index.closest_batch(points=points, normals=rows, max_angle=angle))


def test_the_storey_is_told_by_normals():
    """A robot under the ceiling stands on the floor, whose normal points up."""
    storeys = zoo.two_storeys()
    mesh_map = MeshMap(storeys.vertices, storeys.faces)
    below = mesh_map.vertices[:, 2].max() - 0.4
    point = (*mesh_map.vertices[mesh_map.vertices[:, 2] == mesh_map.vertices[:, 2].max()][0][:2],)
    near = mesh_map.closest_face((*point, below), 10.0)
    assert near.distance <= 0.4 + 1e-6
    down = mesh_map.closest_face((*point, below), 10.0, normal=(0, 0, -1), max_angle=1.0)
    assert down is None  # no face looks down
    up = mesh_map.closest_face((*point, below), 10.0, normal=(0, 0, 1), max_angle=1.0)
    assert (up.face, up.distance) == (near.face, near.distance)


def test_of_faces_as_near_the_first_is_named():
    mesh = identical_triangles(100_000)
    index = SpatialIndex(mesh.vertices, mesh.faces)
    mask = np.ones(100_000, bool)
    for first in (0, 1, 70_000, 99_999):
        mask[:first] = False
        hit = index.closest(point=(-3, -4, 0), mask=mask)
        assert hit.face == first and hit.distance == 5.0
        assert hit.position.tolist() == [0, 0, 0] and hit.barycentric.tolist() == [1, 0, 0]


def test_a_large_batch_is_the_same_in_chunks():
    mesh = terrain(120)
    index = index_of(mesh, "opencl")
    points = np.random.default_rng(0).uniform(-1, 13, (140_001, 3))
    before = query_counts()["opencl"]["closest_point"]
    native = index.closest_batch(points=points, max_distance=5.0, back_end="native")
    assert same(ClosestPointFinder(index).closest_batch(points=points, max_distance=5.0), native)
    asked = {"points": points, "max_distance": 5.0, "back_end": "opencl"}
    assert same(index.closest_batch(**asked), native)
    assert query_counts()["opencl"]["closest_point"] - before == 2 * len(points)
    assert 0.1 < (native.faces == NO_FACE).mean() < 0.9


@pytest.mark.parametrize("back_end", ["native", "opencl"])
def test_nothing_is_found_for_odd_numbers(back_end):
    mesh = terrain(5)
    index = index_of(mesh, back_end)
    for limit in (-1.0, np.nan):
        found = index.closest_batch(points=[[0, 0, 0]], max_distance=limit, back_end=back_end)
        assert found.faces[0] == NO_FACE and found.distances[0] == np.inf
    assert index.closest(point=(0, 0, np.nan)) is None
    assert index.closest(point=(0, 0, 0), normal=(0, 0, 0), max_angle=1) is None
    assert index.closest(point=(0, 0, 0), normal=(0, 0, np.nan), max_angle=1) is None
    assert index.closest_batch(points=[], back_end=back_end).positions.shape == (0, 3)
