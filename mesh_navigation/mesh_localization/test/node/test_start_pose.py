"""Poses put onto the ground."""

import math

import numpy as np
import pytest
from mesh_map.geometry.mesh_geometry import MeshGeometry
from mesh_map.registration.rigid import motion

from mesh_localization.node.start_pose import on_ground, start_covariance, turned_covariance

VARIANCES = {0: 0.25, 1: 0.25, 5: 0.07}


def slope(steepness=0.2, extra=()):
    """A plane that rises along x; facing up."""
    corners = [[x, y, steepness * x] for x, y in ((-5, -5), (5, -5), (5, 5), (-5, 5))]
    faces = [[0, 1, 2], [0, 2, 3]]
    for height, up in extra:
        count = len(corners)
        corners += [[x, y, height] for x, y in ((-5, -5), (5, -5), (5, 5), (-5, 5))]
        for face in ([0, 1, 2], [0, 2, 3]):
            faces.append([count + corner for corner in (face if up else face[::-1])])
    return MeshGeometry(np.array(corners, np.float32), np.array(faces, np.uint32))


def placed(mesh, pose, base_height=0.0):
    return on_ground(mesh.spatial_index, mesh.face_normals, pose, base_height)


def at(x, y, z, heading):
    pose = motion(np.array([0, 0, 0, 0, 0, heading]))
    pose[:3, 3] = x, y, z
    return pose


@pytest.mark.parametrize("heading", [0.0, 1.0, math.pi / 2, -3.0])
def test_it_takes_the_tilt_of_the_ground_and_keeps_its_heading(heading):
    pose = placed(slope(), at(1.0, 2.0, 0.0, heading), base_height=0.5)
    up = np.array([-0.2, 0.0, 1.0]) / math.hypot(0.2, 1.0)
    np.testing.assert_allclose(pose[:3, 3], [1.0, 2.0, 0.2] + 0.5 * up, atol=1e-6)
    np.testing.assert_allclose(pose[:3, 2], up, atol=1e-6)
    assert abs(math.atan2(pose[1, 0], pose[0, 0]) - heading) < 1e-9
    np.testing.assert_allclose(pose[:3, :3] @ pose[:3, :3].T, np.eye(3), atol=1e-9)
    assert np.linalg.det(pose[:3, :3]) > 0


def test_the_nearest_storey_counts_and_ceilings_do_not():
    mesh = slope(0.0, [(3.0, True), (2.8, False)])
    for height, ground in ((0.0, 0.0), (1.4, 0.0), (2.7, 3.0), (9.0, 3.0), (-4.0, 0.0)):
        pose = placed(mesh, at(0.5, 0.5, height, 0.0))
        np.testing.assert_allclose(pose[:3, 3], [0.5, 0.5, ground], atol=1e-6)


def test_there_may_be_no_ground():
    assert placed(slope(), at(50.0, 0.0, 0.0, 0.0)) is None
    ceiling = slope(0.0)
    turned = MeshGeometry(ceiling.vertices, ceiling.faces[:, ::-1])
    assert placed(turned, at(0.0, 0.0, 0.0, 0.0)) is None


def test_the_tilt_is_that_of_the_ground_around():
    rows = np.arange(-20, 21) * 0.1
    x, y = np.meshgrid(rows, rows, indexing="ij")
    heights = 0.1 * x + 0.03 * (np.indices(x.shape).sum(axis=0) % 2)  # a slope with furrows
    vertices = np.stack([x, y, heights], axis=-1).reshape(-1, 3).astype(np.float32)
    corner = (np.arange(40)[:, None] * 41 + np.arange(40)).reshape(-1)
    first = np.stack([corner, corner + 41, corner + 42], axis=1)
    faces = np.concatenate([first, np.stack([corner, corner + 42, corner + 1], axis=1)])
    pose = placed(MeshGeometry(vertices, faces.astype(np.uint32)), at(0.03, 0.05, 0.0, 0.3))
    slopes = pose[:2, 2] / pose[2, 2]
    np.testing.assert_allclose(slopes, [-0.1, 0.0], atol=0.05)


def test_a_covariance_that_is_not_told_is_filled_in():
    covariance = start_covariance(np.zeros((6, 6)), VARIANCES)
    np.testing.assert_allclose(np.diag(covariance), [0.25, 0.25, 0.01, 0.01, 0.01, 0.07])
    assert np.count_nonzero(covariance) == 6


def test_a_covariance_that_is_told_counts():
    given = np.diag([1.0, 2.0, 9.0, 9.0, 9.0, 0.0])
    given[0, 1] = given[1, 0] = 0.5
    covariance = start_covariance(given, VARIANCES)
    np.testing.assert_allclose(covariance[:2, :2], [[1.0, 0.5], [0.5, 2.0]])
    np.testing.assert_allclose(np.diag(covariance)[2:], [0.01, 0.01, 0.01, 0.07])


@pytest.mark.parametrize("wrong", [np.nan, -1.0, 5.0])
def test_a_covariance_that_is_none_is_made_one(wrong):
    given = np.diag([1.0, 1.0, 1.0, 1.0, 1.0, 1.0])
    given[0, 1] = given[1, 0] = wrong
    given[0, 0] = wrong if wrong < 0 else 1.0
    covariance = start_covariance(given, VARIANCES)
    assert np.linalg.eigvalsh(covariance)[0] > 0


def test_covariances_turn_with_their_frame():
    covariance = np.diag([1.0, 2.0, 3.0, 4.0, 5.0, 6.0])
    quarter = at(7.0, 8.0, 9.0, math.pi / 2)
    found = turned_covariance(covariance, quarter)
    np.testing.assert_allclose(np.diag(found), [2.0, 1.0, 3.0, 5.0, 4.0, 6.0], atol=1e-12)
