"""Rays against NumPy, face by face; native and OpenCL alike."""

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st
from mesh_map.spatial.device_batches import RayCaster
from mesh_map.spatial.hits import NO_FACE
from mesh_map.spatial.spatial_index import SpatialIndex, query_counts
from meshes import SMALL, TestMesh, data_mesh, real, terrain
from oracles import RayTimes, check_hit, ray_times
from spatial_samples import (
    ADVERSARIAL,
    BACK_ENDS,
    adversarial,
    identical_triangles,
    index_of,
    need_opencl,
    same,
    some_rays,
)


def check_rays(mesh, index, rays, back_end, cull=False, mask=None, step=1):
    """A batch against NumPy (every step-th ray); single rays and any hits against the batch."""
    origins, directions, limits = rays
    arguments = {"cull_back_faces": cull, "mask": mask}
    batch = {"origins": origins, "directions": directions, "max_distance": limits}
    hits = index.cast_batch(**batch, **arguments, back_end=back_end)
    any_hits = index.any_hit_batch(**batch, **arguments, back_end=back_end)
    assert np.array_equal(any_hits, hits.faces != NO_FACE) and any_hits.dtype == bool
    positions = hits.positions(origins=origins, directions=directions)
    some = slice(None, None, step)
    expected = zip(*ray_times(mesh, origins[some], directions[some], limits[some], cull))
    for i, times in zip(range(0, len(origins), step), map(RayTimes._make, expected)):
        answer = hits.faces[i], hits.distances[i], hits.barycentric[i]
        check_hit(times, *answer, limits[i], mask)
        one = {"origin": origins[i], "direction": directions[i], "max_distance": limits[i]}
        hit = index.cast(**one, **arguments)
        assert index.any_hit(**one, **arguments) == (hit is not None)
        if hit is None:
            assert hits.faces[i] == NO_FACE and np.isnan(positions[i]).all()
            continue
        assert (hit.face, hit.distance) == (hits.faces[i], hits.distances[i])
        assert np.array_equal(hit.barycentric, hits.barycentric[i])
        size = np.abs(origins[i]).max() + hit.distance
        assert np.allclose(hit.position, positions[i], rtol=0, atol=1e-14 * size)
        corners = mesh.vertices[mesh.faces[hit.face]].astype(np.float64)
        size += np.abs(corners).max()
        if np.isfinite(times.error[hit.face]):
            assert np.allclose(hit.position, hit.barycentric @ corners, rtol=0, atol=1e-6 * size)
    return hits


@BACK_ENDS
@adversarial
def test_rays_equal_numpy(mesh, back_end):
    index = index_of(mesh, back_end)
    random = np.random.default_rng(1)
    rays = some_rays(mesh, random, 60)
    check_rays(mesh, index, rays, back_end)
    mask = random.random(len(mesh.faces)) < 0.6
    check_rays(mesh, index, rays, back_end, cull=True, mask=mask, step=2)


@BACK_ENDS
@real
def test_rays_on_real_meshes(name, back_end):
    mesh = data_mesh(name)
    index = index_of(mesh, back_end)
    rays = some_rays(mesh, np.random.default_rng(2), 4000)
    hits = check_rays(mesh, index, rays, back_end, step=150)
    assert 0.2 < np.mean(hits.faces != NO_FACE) < 0.9


@settings(max_examples=60)
@given(st.sampled_from(ADVERSARIAL), st.integers(0, 2**32 - 1), st.booleans(), st.booleans())
def test_random_rays_equal_numpy(mesh, seed, cull, masked):
    random = np.random.default_rng(seed)
    mask = random.random(len(mesh.faces)) < 0.5 if masked else None
    check_rays(mesh, index_of(mesh), some_rays(mesh, random, 12), "native", cull, mask)


@settings(max_examples=60)
@given(st.sampled_from(ADVERSARIAL), st.integers(0, 2**32 - 1), st.booleans(), st.booleans())
def test_opencl_is_native_to_the_last_bit(mesh, seed, cull, masked):
    index = index_of(mesh, "opencl")
    random = np.random.default_rng(seed)
    mask = random.random(len(mesh.faces)) < 0.5 if masked else None
    origins, directions, limits = some_rays(mesh, random, 300)
    for query in (index.cast_batch, index.any_hit_batch):
        asked = {"origins": origins, "directions": directions, "max_distance": limits}
        asked.update(mask=mask, cull_back_faces=cull)
        assert same(query(**asked, back_end="opencl"), query(**asked, back_end="native"))


def test_a_large_batch_is_the_same_in_chunks():
    """More than two chunks of a device, one origin for all, and a maximum distance for all."""
    mesh = terrain(120)
    index = index_of(mesh, "opencl")
    directions = np.random.default_rng(0).normal(size=(150_001, 3))
    asked = {"origins": mesh.vertices.mean(0) + [0, 0, 1], "directions": directions}
    before = query_counts()["opencl"]["ray"]
    found = index.cast_batch(**asked, max_distance=4.0, back_end="opencl")
    assert same(found, index.cast_batch(**asked, max_distance=4.0, back_end="native"))
    assert 0.1 < np.mean(found.faces != NO_FACE) < 0.9 and found.distances[:9].max() > 0
    assert same(found, index.on_device().cast_batch(**asked, max_distance=4.0))
    any_hits = RayCaster(index, device="auto").any_hit_batch(**asked, max_distance=4.0)
    assert np.array_equal(any_hits, found.faces != NO_FACE)
    assert query_counts()["opencl"]["ray"] - before == 3 * len(directions)


def test_an_index_on_a_device_follows_moved_vertices():
    mesh = terrain(5)
    index = SpatialIndex(mesh.vertices, mesh.faces)
    other = index.on_device()
    index.refit(mesh.vertices + np.float32([0, 0, 5]))
    rays = {"origins": mesh.vertices.mean(0) + [0, 0, 9], "directions": [[0.01, 0.02, -1]]}
    before = query_counts()["opencl"]["ray"]
    assert same(other.cast_batch(**rays), index.cast_batch(**rays))
    native = other.cast_batch(**rays, back_end="native")
    assert native.distances[0] < 6 and same(native, index.cast_batch(**rays))
    if other.wait_for_device():
        assert query_counts()["opencl"]["ray"] - before == 1  # whatever the size of the batch


def test_rays_through_edges_and_corners_of_a_closed_mesh_hit():
    mesh = next(mesh for mesh in SMALL if mesh.name == "sphere")
    index = SpatialIndex(mesh.vertices, mesh.faces)
    corners = mesh.vertices.astype(np.float64)[mesh.faces]
    targets = np.concatenate([corners.reshape(-1, 3), corners[:, [0, 1]].mean(1)])
    for start in ((0, 0, 0), (0.01, 0.02, -0.03)):
        hits = index.cast_batch(origins=start, directions=targets - start)
        assert (hits.faces != NO_FACE).all()
    outside = index.cast_batch(origins=(3, 4, 5), directions=targets - (3, 4, 5))
    assert (outside.faces != NO_FACE).mean() > 0.95  # all but some on the silhouette


def test_of_faces_as_near_the_first_is_named():
    mesh = identical_triangles(100_000)
    index = SpatialIndex(mesh.vertices, mesh.faces)
    ray = {"origin": (0.25, 0.25, 5), "direction": (0, 0, -1)}
    mask = np.ones(100_000, bool)
    for first in (0, 1, 70_000, 99_999):
        mask[:first] = False
        hit = index.cast(**ray, mask=mask)
        assert hit.face == first and hit.distance == 4.875
        assert hit.position.tolist() == [0.25, 0.25, 0.125]
        assert hit.barycentric.tolist() == [0.5, 0.25, 0.25]
    mask[:] = False
    assert index.cast(**ray, mask=mask) is None and not index.any_hit(**ray, mask=mask)


def test_back_faces_and_distances():
    index = SpatialIndex([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]])
    up, down = {"origin": (0.2, 0.2, -2), "direction": (0, 0, 9)}, {
        "origin": (0.2, 0.2, 2),
        "direction": (0, 0, -0.1),
    }
    assert index.cast(**up).distance == index.cast(**down).distance == 2
    assert index.cast(**up, cull_back_faces=True) is None
    assert index.cast(**down, cull_back_faces=True).face == 0
    assert index.cast(**down, max_distance=2.0).face == 0
    assert index.cast(**down, max_distance=np.nextafter(2, 0)) is None
    assert index.cast(origin=(0.2, 0.2, 0), direction=(1, 2, 3)).distance == 0
    assert index.cast(origin=(0.2, 0.2, 0), direction=(1, 2, 0)) is None


@pytest.mark.parametrize("back_end", ["native", "opencl"])
def test_empty_batches(back_end):
    index = index_of(TestMesh("", np.eye(3, dtype=np.float32), np.array([[0, 1, 2]])), back_end)
    for nothing in ([], np.zeros((0, 3))):
        hits = index.cast_batch(origins=nothing, directions=nothing, back_end=back_end)
        assert hits.faces.shape == hits.distances.shape == (0,) and hits.barycentric.shape == (0, 3)
        assert hits.positions(origins=nothing, directions=nothing).shape == (0, 3)
    assert index.any_hit_batch(origins=(0, 0, 0), directions=[], back_end=back_end).shape == (0,)


def test_small_batches_stay_native_and_large_ones_do_not(monkeypatch):
    need_opencl()
    mesh = terrain(30)
    index = index_of(mesh, "opencl")
    monkeypatch.setattr(index._device._session.program, "faster_from", {"ray": 5000})
    for count, back_end in ((100, "native"), (20_000, "opencl")):
        before = query_counts()[back_end]["ray"]
        index.cast_batch(origins=(1, 1, 5), directions=np.tile((0.1, 0.2, -1.0), (count, 1)))
        assert query_counts()[back_end]["ray"] - before == count
