"""A robot that drives over generated ground, followed by its scans."""

import math

import numpy as np
import pytest
from mesh_map.geometry.mesh_geometry import MeshGeometry
from mesh_map.registration.point_to_plane import PlaneTarget
from mesh_map.registration.rigid import inverse, numbers_of
from mesh_map.scans.lidar import LidarModel
from mesh_map.scans.odometry_drift import OdometryDrift
from mesh_map.scans.recording import record_scans
from mesh_map.scans.tour import tour
from mesh_msgs.outdoor_world import outdoor_world

from mesh_localization.tracking.localizer import BaseScan, Localizer, TrackingState

LIDAR = LidarModel(lowest=-math.radians(35), highest=math.radians(15), noise=0.015)
DRIFT = OdometryDrift(slip=0.01, yaw=math.radians(0.5))


@pytest.fixture(scope="module")
def mesh():
    world = outdoor_world(40_000, size=20.0, trees=False)
    return MeshGeometry(world.vertices, world.faces)


@pytest.fixture(scope="module")
def drive(mesh):
    return tour(mesh, count=4).above(1.0)


def localizer(mesh):
    return Localizer(PlaneTarget(mesh.spatial_index, mesh.face_normals))


def base_scan(scan):
    return BaseScan(scan.points.astype(np.float64), np.zeros(3), scan.time)


def off(pose, truth):
    numbers = numbers_of(inverse(truth) @ pose)
    return np.linalg.norm(numbers[:3]), np.linalg.norm(numbers[3:])


def test_a_robot_is_followed_although_its_odometry_drifts(mesh, drive):
    robot = localizer(mesh)
    sure = np.diag([1e-4] * 6)
    for number, (scan, truth, _) in enumerate(
        record_scans(mesh, drive, lidar=LIDAR, odometry=DRIFT.of(drive), rate=2.0)
    ):
        if number == 0:
            robot.put(truth, sure, scan.pose, scan.time)
        else:
            robot.move(scan.pose)
        estimate = robot.add(base_scan(scan))
        distance, angle = off(estimate.pose, truth)
        assert distance < 0.02 and angle < 0.005
        assert distance < 5 * estimate.deviations[0]
        assert estimate.state == (TrackingState.OK if number > 1 else TrackingState.UNCERTAIN)
    assert off(scan.pose, truth)[0] > 0.2, "the odometry should have been off"
    assert off(estimate.correction @ scan.pose, truth)[0] < 0.02
