"""Normals that point up, whichever way the mesh is wound."""

import numpy as np
import pytest

from mesh_msgs import zoo

from mesh_map.geometry.mesh_geometry import MeshGeometry
from mesh_navigation.surface.up_normals import face_up_normals, turned_up, vertex_up_normals


def normals_at(vertices, faces):
    """Those of all vertices."""
    return vertex_up_normals(MeshGeometry(vertices, faces), np.arange(len(vertices)))


def reversed_faces(faces):
    return faces[:, [0, 2, 1]]


@pytest.mark.parametrize(
    "mesh", [m for m in zoo.all_meshes() if len(m.faces)], ids=lambda m: m.name
)
def test_unit_normals_that_do_not_depend_on_winding(mesh):
    normals = normals_at(mesh.vertices, mesh.faces)
    assert np.allclose(np.linalg.norm(normals, axis=1), 1.0, atol=1e-6)
    assert (normals[:, 2] >= 0).all()
    turned = normals_at(mesh.vertices, reversed_faces(mesh.faces))
    assert np.array_equal(normals, turned)
    some = np.random.default_rng(0).integers(len(normals), size=9)
    geometry = MeshGeometry(mesh.vertices, mesh.faces)
    assert np.allclose(vertex_up_normals(geometry, some), normals[some], atol=1e-6)
    assert vertex_up_normals(geometry, some[:0]).shape == (0, 3)


@pytest.mark.parametrize(
    "mesh", [m for m in zoo.all_meshes() if len(m.faces)], ids=lambda m: m.name
)
def test_normals_of_faces(mesh):
    some = np.random.default_rng(1).integers(len(mesh.faces), size=20)
    normals = face_up_normals(MeshGeometry(mesh.vertices, mesh.faces), some)
    assert np.allclose(np.linalg.norm(normals, axis=1), 1.0, atol=1e-6)
    assert (normals[:, 2] >= 0).all()
    for face, normal in zip(some, normals):
        a, b, c = mesh.vertices[mesh.faces[face]].astype(np.float64)
        across = np.cross(b - a, c - a)
        if np.linalg.norm(across) > 1e-12:
            cosine = np.dot(across, normal) / np.linalg.norm(across)
            assert abs(cosine) == pytest.approx(1.0, abs=1e-6)


def test_level_ground_with_a_flipped_face_points_straight_up():
    mesh = zoo.flipped_face()
    assert np.allclose(normals_at(mesh.vertices, mesh.faces), [0, 0, 1])


def test_faces_wound_at_random_on_level_ground():
    mesh = zoo.grid()
    flip = np.random.default_rng(3).random(len(mesh.faces)) < 0.5
    faces = np.where(flip[:, None], reversed_faces(mesh.faces), mesh.faces)
    assert np.allclose(normals_at(mesh.vertices, faces), [0, 0, 1])


def test_a_wall_keeps_its_normal():
    """On a wall rounding decides about up and down; the normals must not cancel out."""
    rng = np.random.default_rng(4)
    mesh = zoo.grid()
    wall = mesh.vertices[:, [2, 0, 1]] + rng.normal(scale=1e-3, size=mesh.vertices.shape)
    normals = normals_at(wall.astype(np.float32), mesh.faces)
    assert np.abs(normals[:, 0]).min() > 0.99


def test_vertices_without_a_face_count_as_level():
    mesh = zoo.isolated_vertex()
    isolated = np.setdiff1d(np.arange(len(mesh.vertices)), mesh.faces)
    assert len(isolated)
    assert np.allclose(normals_at(mesh.vertices, mesh.faces)[isolated], [0, 0, 1])


def test_turned_up_is_the_same_for_a_normal_and_its_opposite():
    normals = np.array([[0, 0, -1], [1, 0, 0], [0, -1, 0], [3, -2, 0], [1, 1, -1e-9], [0, 0, 2.0]])
    assert np.array_equal(turned_up(normals), turned_up(-normals))
    assert (turned_up(normals)[:, 2] >= 0).all()
