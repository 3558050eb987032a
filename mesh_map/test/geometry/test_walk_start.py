"""In which face walks begin on edges and at corners."""

import itertools

import numpy as np
import pytest
from mesh_map.geometry.mesh_geometry import MeshGeometry
from mesh_map.geometry.walk_start import walk_start
from mesh_map.spatial.hits import SurfacePoint
from meshes import small, terrain
from walk_oracle import faces_at

UP = np.array([0.0, 0.0, 1.0])


def point_in(geometry, face, weights):
    weights = np.asarray(weights, np.float64) / np.sum(weights)
    corners = geometry.vertices[geometry.faces[face]].astype(np.float64)
    return SurfacePoint(int(face), weights @ corners, weights, 0.25)


def floor_and_wall(flipped):
    """A square floor and a wall upright at x = 1, the wall's faces first."""
    vertices = [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [1, 0, 1], [1, 1, 1]]
    faces = np.array([[1, 2, 5], [1, 5, 4], [0, 1, 2], [0, 2, 3]])
    faces[list(flipped)] = faces[list(flipped)][:, ::-1]
    return MeshGeometry(np.array(vertices, np.float32), faces)


@pytest.mark.parametrize("flipped", itertools.product((0, 1), repeat=4))
@pytest.mark.parametrize("here", [(1,), (2,), (1, 2)])
def test_beside_a_wall_it_is_the_floor(flipped, here):
    geometry = floor_and_wall(np.flatnonzero(flipped))
    for face, angle in itertools.product(range(4), np.arange(8) * np.pi / 4 + 0.1):
        corners = geometry.faces[face].tolist()
        if set(here) <= set(corners):
            given = point_in(geometry, face, [float(vertex in here) for vertex in corners])
            way = (np.cos(angle), np.sin(angle), 0.0)
            found = walk_start(geometry, given, way, UP)
            assert found.face in (2, 3)
            spot = found.barycentric @ geometry.vertices[geometry.faces[found.face]]
            np.testing.assert_allclose(spot, given.position, atol=1e-12)
            assert found.position is given.position and found.distance == 0.25
            assert walk_start(geometry, found, way, -5 * UP).face == found.face


@small
def test_it_is_a_face_that_contains_the_direction_and_faces_up(mesh):
    """Against lines over the faces around: a short step from the point is over the face."""
    geometry = MeshGeometry(mesh.vertices, mesh.faces)
    flatness = np.abs(geometry.face_normals @ UP)
    random = np.random.default_rng(0)
    for face in random.permutation(np.flatnonzero(~geometry.faces_without_area))[:40]:
        corners = geometry.faces[face].tolist()
        for here in ([0], [1], [0, 2]):
            weights = np.isin(np.arange(3), here).astype(np.float64)
            point = point_in(geometry, face, weights)
            angle = random.uniform(0, 2 * np.pi)
            way = np.array([np.cos(angle), np.sin(angle), 0])
            found = walk_start(geometry, point, way, UP)
            names = [corners[k] for k in here]
            around = [f for f in faces_at(mesh)[names[0]] if set(names) <= set(mesh.faces[f])]
            around = [f for f in around if not geometry.faces_without_area[f]]
            assert found.face in around
            spot = found.barycentric @ mesh.vertices[mesh.faces[found.face]].astype(np.float64)
            np.testing.assert_allclose(spot, point.position, rtol=1e-9, atol=1e-9)
            over = {f: is_over(mesh, f, point.position, way) for f in around}
            if None in over.values():
                continue
            good = [f for f in around if over[f] and flatness[f] >= 0.5] or around
            assert flatness[found.face] > max(flatness[good]) - 1e-5


def is_over(mesh, face, position, way):
    """Whether a step along a way is over a face as seen from above; None where that is close."""
    a, b, c = mesh.vertices[mesh.faces[face]].astype(np.float64)[:, :2]
    size = max(np.linalg.norm(b - a), np.linalg.norm(c - a))
    basis = np.stack([b - a, c - a], 1)
    if abs(np.linalg.det(basis)) < 1e-3 * size**2:
        return None
    along = np.linalg.solve(basis, way[:2])
    at = np.linalg.solve(basis, position[:2] - a)
    rates = [along[0], along[1], -along.sum()]
    weights = [at[0], at[1], 1 - at.sum()]
    leaving = [rate for rate, weight in zip(rates, weights) if weight < 1e-6]
    if min(np.abs(leaving)) * size < 1e-6:
        return None
    return min(leaving) > 0


def test_within_a_face_it_stays():
    mesh = terrain(10)
    geometry = MeshGeometry(mesh.vertices, mesh.faces)
    for face in range(20):
        point = point_in(geometry, face, (1, 1e-6, 1))
        assert walk_start(geometry, point, (1, 0, 0), UP) is point


def test_only_faces_of_the_mask_are_chosen():
    geometry = floor_and_wall(())
    point = point_in(geometry, 0, (1, 0, 0))  # vertex 1, at which the faces 0, 1 and 2 are
    for allowed, expected in (((0, 1, 2, 3), 2), ((1, 3), 1), ((3,), 0)):
        mask = np.isin(np.arange(4), allowed)
        assert walk_start(geometry, point, (-1, 0.5, 0), UP, mask=mask).face == expected
