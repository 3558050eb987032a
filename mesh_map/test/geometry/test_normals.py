"""Normals against plain NumPy."""

import numpy as np
import pytest
from mesh_map.geometry.normals import face_normals, vertex_normals
from mesh_map.geometry.topology import Topology
from meshes import BOTANICAL, TestMesh, data_mesh, real, renumbered, small, terrain


def both(mesh):
    topology = Topology(faces=mesh.faces, vertex_count=len(mesh.vertices))
    normals, without_area = face_normals(mesh.vertices, mesh.faces)
    return normals, without_area, vertex_normals(topology, normals, without_area)


def check(mesh):
    a, b, c = np.swapaxes(mesh.vertices.astype(np.float64)[mesh.faces], 0, 1)
    area = np.cross(b - a, c - a)
    norm = np.linalg.norm(area, axis=1)
    expected = np.where(norm[:, None] > 0, area / np.where(norm > 0, norm, 1)[:, None], (0, 0, 1))
    normals, without_area, at_vertices = both(mesh)
    assert np.array_equal(without_area, norm == 0)
    np.testing.assert_allclose(normals, expected, atol=1e-6)

    total = np.zeros((len(mesh.vertices), 3))
    for face, normal, ignored in zip(mesh.faces, normals.astype(np.float64), without_area):
        for vertex in {*face.tolist()} if not ignored else ():
            total[vertex] += normal
    norm = np.linalg.norm(total, axis=1)
    sure = norm > 1e-5  # normals that cancel out leave a direction made of rounding
    np.testing.assert_allclose(at_vertices[sure], total[sure] / norm[sure, None], atol=1e-5)
    assert np.allclose(np.linalg.norm(at_vertices, axis=1), 1, atol=1e-6)
    assert (at_vertices[norm == 0] == (0, 0, 1)).all()


@small
def test_normals_equal_numpy(mesh):
    check(mesh)


@real
def test_normals_of_real_meshes_equal_numpy(name):
    check(data_mesh(name))


def test_share_of_faces_that_point_down():
    mesh = data_mesh(BOTANICAL)
    normals, _ = face_normals(mesh.vertices, mesh.faces)
    assert round(100 * (normals[:, 2] < 0).mean()) == 38


def test_each_face_counts_the_same():
    """A huge flat face and a tiny upright one: the mean is at 45 degrees, whatever the areas."""
    vertices = [[0, 0, 0], [100, 0, 0], [0, 100, 0], [0, 0, 0.01]]
    mesh = TestMesh("corner", np.array(vertices, np.float32), np.array([[0, 1, 2], [0, 3, 1]]))
    normals, _, at_vertices = both(mesh)
    np.testing.assert_allclose(normals, [[0, 0, 1], [0, 1, 0]], atol=1e-7)
    np.testing.assert_allclose(at_vertices[0], np.array([0, 1, 1]) / np.sqrt(2), atol=1e-6)


def test_the_order_of_vertices_does_not_matter():
    mesh = terrain()
    other, new = renumbered(mesh)
    assert np.array_equal(both(mesh)[2], both(other)[2][new])


def test_far_from_the_origin():
    """1000 km away, float32 vertices are on a raster of 6 cm; their normals are still exact."""
    near = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0.25]], np.float32)
    far = near + np.float32(1 << 20)
    assert np.array_equal(face_normals(near, [[0, 1, 2]])[0], face_normals(far, [[0, 1, 2]])[0])


def test_arrays_of_another_mesh_are_refused():
    mesh = terrain(5)
    normals, without_area = face_normals(mesh.vertices, mesh.faces)
    topology = Topology(faces=mesh.faces[:-1], vertex_count=len(mesh.vertices))
    with pytest.raises(ValueError, match="ignored has to have the shape"):
        vertex_normals(topology, normals, without_area[:-1])
    larger = Topology(faces=mesh.faces, vertex_count=len(mesh.vertices))
    with pytest.raises(ValueError, match="vertex_faces has the index"):
        vertex_normals(larger, normals[:-1], without_area[:-1])
    with pytest.raises(ValueError, match="faces has the index 25 at position 2"):
        face_normals(mesh.vertices, [[0, 1, 25]])
