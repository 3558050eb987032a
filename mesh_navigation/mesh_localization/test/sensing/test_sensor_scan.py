"""Messages of sensors, good and odd ones, as points."""

import numpy as np
import pytest
from genpy import Time
from mesh_map.base.errors import MeshMapError
from mesh_map.scans.cloud_message import cloud_message
from mesh_map.scans.lidar import LidarScan
from sensor_msgs.msg import LaserScan, PointCloud2

from mesh_localization.node import messages
from mesh_localization.sensing.ray_choice import chosen_rays
from mesh_localization.sensing.sensor_scan import RangeLimits, cloud_scan, laser_scan

STAMP = Time(100, 7)


def cloud(points, **fields):
    more = {name: np.asarray(values, np.float32) for name, values in fields.items()}
    return messages.cloud_message(np.asarray(points, np.float64), more, "/laser", STAMP)


def spread_points(count):
    numbers = np.arange(1, count + 1)
    return np.stack([0.1 * numbers, np.zeros(count), np.ones(count)], axis=1)


def ring(ranges, **values):
    message = LaserScan(angle_min=0.0, angle_increment=0.1, range_min=0.1, range_max=20.0)
    message.header.frame_id, message.header.stamp = "front", STAMP
    message.ranges = list(ranges)
    for name, value in values.items():
        setattr(message, name, value)
    return message


def test_points_that_say_nothing_are_left_out():
    points = spread_points(6)
    points[1], points[3] = np.nan, 0.0
    scan = cloud_scan(cloud(points), RangeLimits())
    assert (scan.frame, scan.stamp, scan.offsets) == ("laser", STAMP, None)
    np.testing.assert_allclose(scan.points, points[[0, 2, 4, 5]], atol=1e-6)


def test_points_out_of_this_world_are_left_out():
    points = spread_points(30)
    points[3], points[4] = 3e38, [1e6, 0.0, 0.0]
    scan = cloud_scan(cloud(points), RangeLimits())
    np.testing.assert_allclose(scan.points, np.delete(points, [3, 4], axis=0), atol=1e-6)


def test_ranges_are_limited_and_rays_are_chosen():
    points = spread_points(1000)
    limits = RangeLimits(nearest=2.0, farthest=50.0, most=100)
    scan = cloud_scan(cloud(points), limits)
    ranges = np.linalg.norm(scan.points, axis=1)
    assert len(ranges) == 100 and ranges.min() >= 2.0 and ranges.max() < 50.0
    again = cloud_scan(cloud(points), limits)
    np.testing.assert_array_equal(scan.points, again.points)


def test_times_of_points_follow_their_points():
    points = spread_points(500)
    scan = cloud_scan(cloud(points, time=0.0002 * np.arange(500)), RangeLimits(most=50))
    numbers = np.rint(scan.points[:, 0] / 0.1) - 1
    np.testing.assert_allclose(scan.offsets, 0.0002 * numbers, atol=1e-6)


@pytest.mark.parametrize("count, most", [(0, 5), (3, 5), (5, 5), (28_800, 2000), (7, 5)])
def test_rays_are_chosen_all_over_a_scan(count, most):
    chosen = chosen_rays(count, most)
    assert len(chosen) == min(count, most)
    assert (np.diff(chosen) > 0).all()
    assert not len(chosen) or (chosen[0] >= 0 and chosen[-1] < count)
    if len(chosen) > 1:
        assert np.diff(chosen).max() <= 2 * max(1, -(-count // most))


def test_rays_of_all_rings_are_chosen():
    rings = chosen_rays(16 * 1800, 1800) % 16
    assert np.bincount(rings, minlength=16).min() > 60


@pytest.mark.parametrize(
    "message, words",
    [
        (cloud(np.zeros((0, 3))), "it has no point"),
        (cloud(np.full((9, 3), np.nan)), "none of its 9 points is finite"),
        (cloud(np.zeros((9, 3))), "none of its 9 points is finite and away from the sensor"),
        (cloud([[3e38, 3e38, 3e38]] * 9), "it has met nothing"),
        (cloud(100.0 * np.eye(3)), "3 of its 3 points are 100.0 m away: it has met nothing"),
        (cloud([[0.1, 0, 0], [0.2, 0, 0]]), "none of its 2 points is between laser_min_range 1 m"),
        (PointCloud2(height=1, width=2, data=b"12"), "fields x"),
    ],
)
def test_clouds_that_cannot_be_used_say_why(message, words):
    with pytest.raises(MeshMapError) as error:
        cloud_scan(message, RangeLimits(nearest=1.0))
    assert words in str(error.value)


def test_a_cloud_of_the_simulated_lidar():
    points = spread_points(20).astype(np.float32)
    numbers = np.zeros(20)
    measured = LidarScan(
        points=points,
        intensities=numbers,
        rings=numbers.astype(np.uint16),
        times=0.001 * np.arange(20),
        faces=numbers.astype(np.uint32),
    )
    scan = cloud_scan(cloud_message(measured, "laser", STAMP), RangeLimits())
    np.testing.assert_allclose(scan.points, points)
    np.testing.assert_allclose(scan.offsets, 0.001 * np.arange(20), atol=1e-7)


def test_beams_of_a_laser_scan():
    ranges = [1.0, np.inf, 2.0, np.nan, 0.01, 20.0, 3.0]
    scan = laser_scan(ring(ranges, time_increment=0.01), RangeLimits())
    angles = np.array([0.0, 0.2, 0.6])
    expected = np.array([[1.0], [2.0], [3.0]]) * np.stack(
        [np.cos(angles), np.sin(angles), 0 * angles], axis=1
    )
    np.testing.assert_allclose(scan.points, expected, atol=1e-6)
    np.testing.assert_allclose(scan.offsets, [0.0, 0.02, 0.06], atol=1e-9)
    assert scan.frame == "front"


@pytest.mark.parametrize("ranges", [[20.0] * 9, [np.inf] * 9, [np.nan] * 9, []])
def test_scans_that_have_met_nothing_say_so(ranges):
    with pytest.raises(MeshMapError):
        laser_scan(ring(ranges), RangeLimits())
