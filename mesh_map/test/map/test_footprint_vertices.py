"""Vertices under footprints, against cutting each face in NumPy."""

import numpy as np
import pytest
from mesh_map.base.cancel import CancelFlag
from mesh_map.base.errors import Canceled
from mesh_map.geometry.mesh_geometry import MeshGeometry
from mesh_map.map.footprint import Footprint
from mesh_map.map.queries import SurfaceQueries
from meshes import soup, terrain
from oracles import clipped
from test_footprint import SQUARE, planes_of, random_pose


def queries_of(mesh):
    return SurfaceQueries(MeshGeometry(mesh.vertices, mesh.faces))


def bisectors(to, than):
    """The planes (F, 4) between points (F, 3): >= 0 for what is nearer to the first."""
    away = than - to
    return np.concatenate([-away, np.sum(away * (to + than) / 2, 1, keepdims=True)], 1)


def vertices_of(mesh, planes, shift):
    """Those with a part of their faces, where they are the nearest corner, in front of planes."""
    found = set()
    corners = mesh.vertices.astype(np.float64)[mesh.faces]
    for k in range(3):
        others = [bisectors(corners[:, k], corners[:, i]) for i in range(3) if i != k]
        same = np.broadcast_to(planes, (len(corners), *planes.shape))
        all_planes = np.concatenate([same, np.stack(others, 1)], 1)
        all_planes[:, :, 3] += shift * np.linalg.norm(all_planes[:, :, :3], axis=2)
        _, counts = clipped(corners, all_planes)
        found.update(mesh.faces[counts > 0, k].tolist())
    return found


@pytest.mark.parametrize("mesh", [terrain(7), soup(6, 60, 120)], ids=lambda mesh: mesh.name)
def test_vertices_equal_those_of_the_faces_cut_in_numpy(mesh):
    random = np.random.default_rng(0)
    queries = queries_of(mesh)
    places = mesh.vertices[random.choice(len(mesh.vertices), 5)].astype(np.float64)
    poses = [random_pose(random, place - 0.05, place + 0.05) for place in places]
    touched = 0
    for footprint in (Footprint(SQUARE), Footprint.circle(0.05, 40, below=0.1, above=0.5)):
        found = queries.vertices_under(footprint, np.array(poses))
        for index, pose in enumerate(poses):
            planes = planes_of(footprint, pose)
            vertices = found.of(index).tolist()
            assert vertices == sorted(set(vertices))
            assert vertices_of(mesh, planes, -1e-6) <= set(vertices)
            assert set(vertices) <= vertices_of(mesh, planes, 1e-6)
            touched += len(vertices) > 0
    assert touched == 10


def test_a_tiny_footprint_has_the_nearest_corner_of_its_face():
    mesh = terrain(20)
    queries = queries_of(mesh)
    random = np.random.default_rng(3)
    for _ in range(50):
        pose = np.eye(4)
        pose[:3, 3] = *random.uniform(0.1, 1.7, 2), 0.0
        hit = queries.geometry.spatial_index.cast(
            origin=pose[:3, 3] + (0, 0, 5), direction=(0, 0, -1)
        )
        corners = mesh.faces[hit.face]
        nearest = corners[np.argmin(np.linalg.norm(mesh.vertices[corners] - hit.position, axis=1))]
        footprint = Footprint.circle(1e-9, 4, below=5.0, above=5.0)
        assert nearest in queries.vertices_under(footprint, pose[None]).of(0)


def test_wrong_poses_and_cancel():
    queries = queries_of(terrain(5))
    with pytest.raises(ValueError, match="pose 0 does more than turn and shift"):
        queries.vertices_under(Footprint(SQUARE), np.diag([2.0, 1, 1, 1])[None])
    assert len(queries.vertices_under(Footprint(SQUARE), np.full((3, 4, 4), np.nan)).vertices) == 0
    flag = CancelFlag()
    flag.set()
    with pytest.raises(Canceled):
        poses = np.broadcast_to(np.eye(4), (1000, 4, 4))
        queries.vertices_under(Footprint(SQUARE), poses, cancel=flag)
