"""Faces that are turned so that they agree and face up, up directions, and weighted normals."""

import numpy as np
import pytest
from mesh_map.base.errors import MeshMapError
from mesh_map.geometry.mesh_geometry import MeshGeometry
from mesh_map.geometry.normals import corner_angles, unit_normals
from mesh_map.geometry.orientation import orient_faces
from mesh_map.geometry.topology import Topology
from meshes import BOTANICAL, TRAY, data_mesh, small, terrain


def mixed(mesh, seed=0):
    """The mesh with half of its faces turned."""
    faces = mesh.faces.copy()
    some = np.random.default_rng(seed).random(len(faces)) < 0.5
    faces[some] = faces[some][:, [0, 2, 1]]
    return faces, some


def oriented(mesh, faces, **options):
    return MeshGeometry(mesh.vertices, faces, orient=True, **options)


def test_what_was_turned_is_turned_back():
    mesh = terrain()
    faces, some = mixed(mesh)
    geometry = oriented(mesh, faces)
    assert np.array_equal(geometry.faces, mesh.faces)
    assert np.array_equal(geometry.orientation.turned, some)
    assert not geometry.topology.inconsistent_edges.any()
    as_they_were = MeshGeometry(mesh.vertices, mesh.faces)
    assert np.array_equal(geometry.face_normals, as_they_were.face_normals)
    assert np.array_equal(geometry.vertex_normals, as_they_were.vertex_normals)
    expected = "%s faces turned in 1 piece" % format(int(some.sum()), ",")
    assert geometry.report().endswith(expected)
    below = oriented(mesh, faces, up_direction=(0, 0, -1))
    assert np.array_equal(below.orientation.turned, ~some)


@small
def test_nothing_is_left_out_and_neighbors_agree(mesh):
    faces, _ = mixed(mesh)
    geometry = oriented(mesh, faces)
    assert np.array_equal(np.sort(geometry.faces, axis=1), np.sort(mesh.faces, axis=1))
    again = Topology(faces=geometry.faces, vertex_count=len(mesh.vertices))
    assert again.inconsistent_edges.sum() == geometry.orientation.conflicts
    assert np.array_equal(geometry.topology.inconsistent_edges, again.inconsistent_edges)
    assert np.array_equal(geometry.topology.face_edges, again.face_edges)
    twice = oriented(mesh, geometry.faces)
    if not geometry.orientation.conflicts:
        assert not twice.orientation.turned.any()


@pytest.mark.parametrize("name", [TRAY, BOTANICAL])
def test_real_meshes(name):
    mesh = data_mesh(name)
    geometry = oriented(mesh, mixed(mesh)[0])
    assert geometry.topology.inconsistent_edges.sum() == geometry.orientation.conflicts
    assert np.array_equal(np.sort(geometry.faces, axis=1), np.sort(mesh.faces, axis=1))

    def seen_from_above(faces):
        a, b, c = np.swapaxes(mesh.vertices.astype(np.float64)[faces], 0, 1)
        return np.cross(b - a, c - a)[:, 2].sum()

    assert seen_from_above(geometry.faces) >= seen_from_above(mesh.faces) - 1e-6


def test_the_identity_is_that_of_the_given_faces():
    mesh = terrain(10)
    faces, _ = mixed(mesh)
    given = MeshGeometry(mesh.vertices, faces)
    assert oriented(mesh, faces).uuid == given.uuid == given.content_uuid
    assert given.orientation is None and np.array_equal(given.faces, faces)


def test_other_queries_see_the_turned_faces():
    mesh = terrain(10)
    geometry = oriented(mesh, mesh.faces[:, ::-1].copy())
    point = mesh.vertices.mean(axis=0) + (0, 0, 1)
    up = {"normal": (0, 0, 1), "max_angle": 1.5}
    assert geometry.closest_face(point, 5.0, **up) is not None
    assert MeshGeometry(mesh.vertices, mesh.faces[:, ::-1]).closest_face(point, 5.0, **up) is None


def test_given_normals():
    mesh = terrain(10)
    computed = MeshGeometry(mesh.vertices, mesh.faces).vertex_normals
    given = -computed
    assert np.array_equal(MeshGeometry(mesh.vertices, mesh.faces, given).vertex_normals, given)
    turned = MeshGeometry(mesh.vertices, mesh.faces, given, orient=True)
    assert np.array_equal(turned.vertex_normals, computed)
    weighted = MeshGeometry(mesh.vertices, mesh.faces, given, normals="angle").vertex_normals
    assert (np.einsum("ij,ij->i", weighted, computed) > 0.9).all()
    of_other_length = MeshGeometry(mesh.vertices, mesh.faces, 3.0 * given).vertex_normals
    np.testing.assert_allclose(of_other_length, given, atol=1e-6)


def test_normals_of_length_one_stay_as_they_are():
    rows = np.array([[0, 0, 1], [0.6, 0.8, 0.0001], [0, 0, 0], [0, 2, 0]], np.float32)
    found = unit_normals(rows, (1.0, 0.0, 0.0))
    assert np.array_equal(found[:2], rows[:2])
    assert found[2:].tolist() == [[1, 0, 0], [0, 1, 0]]
    assert unit_normals(rows[:2]) is rows[:2] or np.array_equal(unit_normals(rows[:2]), rows[:2])


def test_the_topology_of_another_mesh_is_refused():
    """Where its edges do not lead from face to face, nothing is read beyond its arrays."""
    vertices, up = np.eye(5, 3), np.array([0.0, 0.0, 1.0])
    meshes = (
        [[0, 1, 2], [1, 3, 2]],
        [[0, 1, 2], [1, 1, 2]],
        [[0, 1, 2], [0, 1, 2]],
        [[0, 1, 2], [0, 3, 4]],
        [[0, 0, 0], [1, 1, 2]],
    )
    for i, j in ((0, 1), (1, 0), (0, 4), (2, 1), (3, 1), (2, 4)):
        topology = Topology(faces=meshes[j], vertex_count=5)
        with pytest.raises(ValueError, match="the topology is not that of the faces"):
            orient_faces(vertices, meshes[i], topology, up)
        swapped = Topology(faces=meshes[i], vertex_count=5)
        assert orient_faces(vertices, meshes[i], swapped, up).conflicts == 0


@small
def test_weighted_by_angle(mesh):
    corners = mesh.vertices.astype(np.float64)[mesh.faces]
    plain = MeshGeometry(mesh.vertices, mesh.faces)
    total = np.zeros((len(mesh.vertices), 3))
    for face, points, normal, ignored in zip(
        mesh.faces, corners, plain.face_normals, plain.faces_without_area
    ):
        for k in range(3) if not ignored else ():
            u, v = points[k - 2] - points[k], points[k - 1] - points[k]
            angle = np.arctan2(np.linalg.norm(np.cross(u, v)), u @ v)
            total[face[k]] += angle * normal.astype(np.float64)
    norm = np.linalg.norm(total, axis=1)
    sure = norm > 1e-4
    found = MeshGeometry(mesh.vertices, mesh.faces, normals="angle").vertex_normals
    np.testing.assert_allclose(found[sure], total[sure] / norm[sure, None], atol=1e-5)


def test_the_cut_of_a_square_does_not_matter_with_angles():
    """The corner of a cube: three sides, one of them in two faces."""
    vertices = [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0, 0, 1]]
    faces = [[0, 1, 2], [0, 2, 3], [0, 4, 1], [0, 3, 4]]
    found = MeshGeometry(vertices, faces, normals="angle").vertex_normals[0]
    np.testing.assert_allclose(found, np.ones(3) / np.sqrt(3), atol=1e-6)
    mean = MeshGeometry(vertices, faces).vertex_normals[0]
    np.testing.assert_allclose(mean, np.array([1, 1, 2]) / np.sqrt(6), atol=1e-6)


def test_corner_angles_without_area():
    """0 at corners in one place; else those of a face that is nothing but its longest side."""
    line = [[0, 0, 0], [0, 0, 0], [1, 0, 0], [2, 0, 0]]
    faces = [[0, 1, 2], [1, 2, 0], [2, 0, 1], [0, 2, 3], [0, 3, 2], [0, 0, 1], [0, 0, 0]]
    found = corner_angles(line, faces)
    assert found[[0, 1, 2, 5, 6]].tolist() == np.zeros((5, 3)).tolist()
    np.testing.assert_allclose(found[3:5], [[0, np.pi, 0], [0, 0, np.pi]], atol=1e-7)


@pytest.mark.parametrize("size", [5e-324, 1e-200, 1.0, 1e200, 1.7e308])
def test_an_up_direction_may_have_any_length(size):
    faces = [[0, 1, 2]]
    for up in ((0, 0, size), (size, 0, -size)):
        found = MeshGeometry([[0, 0, 0], [1, 0, 0], [0, 1, 0]], faces, up_direction=up).up
        np.testing.assert_allclose(found, np.sign(up) / np.linalg.norm(np.sign(up)), rtol=1e-15)


def test_up_stands_in_where_there_is_no_normal():
    vertices = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [5, 5, 5]]
    geometry = MeshGeometry(vertices, [[0, 1, 2], [0, 0, 1]], up_direction=(0, 3, 4))
    assert geometry.up.tolist() == [0.0, 0.6, 0.8]
    for normal in (geometry.vertex_normals[3], geometry.face_normals[1]):
        np.testing.assert_allclose(normal, (0, 0.6, 0.8), atol=1e-7)


@pytest.mark.parametrize("up", [(0, 0, 0), (0, 1), "up", None, (0, np.nan, 1), (np.inf, 0, 0)])
def test_no_direction(up):
    with pytest.raises(MeshMapError, match="up_direction is .*, but it has to be three finite"):
        MeshGeometry([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]], up_direction=up)


def test_unknown_weights_of_normals():
    with pytest.raises(MeshMapError, match="normals is 'area', but it has to be mean or angle"):
        MeshGeometry([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]], normals="area")
