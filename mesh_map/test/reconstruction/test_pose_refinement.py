"""Poses that drift, made better by the scans."""

import numpy as np
import pytest
from mesh_msgs.outdoor_world import outdoor_world

from mesh_map.geometry.mesh_geometry import MeshGeometry
from mesh_map.reconstruction.pose_refinement import refine_poses
from mesh_map.scans.lidar import LidarModel
from mesh_map.scans.odometry_drift import OdometryDrift
from mesh_map.scans.recording import record_scans
from mesh_map.scans.scan import Scan
from mesh_map.scans.tour import tour


@pytest.fixture(scope="module")
def loop():
    """(mesh, the drive of a lidar once around)."""
    world = outdoor_world(60_000, size=24.0, trees=False)
    mesh = MeshGeometry(world.vertices, world.faces)
    return mesh, tour(mesh, count=4, seed=2).above(1.2)


def recorded(loop, drift):
    mesh, drive = loop
    lidar = LidarModel(rings=32, columns=256, max_range=20.0, noise=0.015)
    length = np.linalg.norm(np.diff(drive.positions, axis=0), axis=1).sum()
    rate = 1.0 / (2.0 * length / len(drive.times) / np.median(np.diff(drive.times)))
    scans = list(
        record_scans(mesh, drive, lidar=lidar, odometry=drift.of(drive), rate=rate, seed=1)
    )
    return [one.scan for one in scans], np.array([one.truth for one in scans])


def rms(poses, truth):
    return np.sqrt(np.mean(np.sum((np.array(poses)[:, :3, 3] - truth[:, :3, 3]) ** 2, axis=1)))


def test_drift_over_a_loop_is_taken_back(loop):
    scans, truth = recorded(loop, OdometryDrift(slip=0.008, yaw=0.001, height=0.002))
    given = [scan.pose for scan in scans]
    refined = refine_poses(scans, voxel_size=0.1)
    before, after = rms(given, truth), rms(refined.poses, truth)
    assert len(refined.poses) == len(scans) and refined.loops > 0
    assert before > 0.4 and after < 0.04
    assert refined.is_better and 0 < refined.errors[1] < 0.9 * refined.errors[0]
    np.testing.assert_allclose(refined.poses[0], given[0], atol=1e-12)
    shifts = np.linalg.norm(np.array(refined.poses)[:, :3, 3] - np.array(given)[:, :3, 3], axis=1)
    assert refined.moved == pytest.approx((np.sqrt(np.mean(shifts**2)), shifts.max()))


def test_poses_that_are_right_stay(loop):
    scans, truth = recorded(loop, OdometryDrift())
    refined = refine_poses(scans[::3], voxel_size=0.1)
    assert np.array_equal(refined.poses, truth[::3]) and not refined.is_better
    assert "poses stay as given" in refined.line() and refined.moved == (0.0, 0.0)


def test_scans_that_have_nothing_in_common_keep_their_poses():
    random = np.random.default_rng(0)
    scans = []
    for k in range(4):
        pose = np.eye(4)
        pose[0, 3] = 200.0 * k
        scans.append(Scan(np.float32(random.uniform(-3, 3, (2000, 3)) * [1, 1, 0.01]), pose))
    scans.append(Scan(np.zeros((0, 3), np.float32), np.eye(4)))
    refined = refine_poses(scans, voxel_size=0.1)
    assert refined.lost == 4 and refined.loops == 0
    for one, scan in zip(refined.poses, scans):
        np.testing.assert_allclose(one, scan.pose, atol=1e-9)
    assert refine_poses([], voxel_size=0.1).poses == []
