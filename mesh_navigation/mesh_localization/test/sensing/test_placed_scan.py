"""Scans brought into the frame of the base, also of a robot that moves."""

import numpy as np
from genpy import Time
from mesh_map.registration.rigid import inverse, motion, moved

from mesh_localization.sensing.placed_scan import joined_scan, placed_scan
from mesh_localization.sensing.sensor_scan import SensorScan

MOUNT = motion(np.array([0.3, 0.1, 0.8, 0.0, 0.4, 1.0]))
WORLD = np.random.default_rng(0).uniform(-5, 5, (400, 3))


def base_at(offset):
    """A robot that drives and turns."""
    return motion(np.array([2.0 + 1.5 * offset, 1.0, 0.0, 0.0, 0.0, 0.8 * offset]))


def sensor_at(offset):
    return base_at(offset) @ MOUNT


def test_the_points_of_a_robot_that_stands():
    points = moved(inverse(sensor_at(0.0)), WORLD)
    stamp = Time(5, 123)
    placed = placed_scan(SensorScan("laser", stamp, points, None), sensor_at, base_at)
    np.testing.assert_allclose(moved(placed.odometry, placed.scan.points), WORLD, atol=1e-9)
    np.testing.assert_allclose(placed.sensor, MOUNT, atol=1e-12)
    np.testing.assert_allclose(placed.scan.origins, MOUNT[:3, 3], atol=1e-12)
    assert placed.stamp == stamp and placed.scan.time == stamp.to_sec()


def test_motion_within_a_scan_is_undone():
    offsets = np.linspace(-0.1, 0.0, len(WORLD))
    pairs = zip(offsets, WORLD)
    points = np.array([moved(inverse(sensor_at(offset)), one[None])[0] for offset, one in pairs])
    scan = SensorScan("laser", Time(5, 0), points, offsets)
    placed = placed_scan(scan, sensor_at, base_at)
    np.testing.assert_allclose(placed.odometry, base_at(0.0), atol=1e-12)
    np.testing.assert_allclose(moved(placed.odometry, placed.scan.points), WORLD, atol=1e-4)
    origins = moved(placed.odometry, placed.scan.origins)
    expected = [sensor_at(offset)[:3, 3] for offset in offsets]
    np.testing.assert_allclose(origins, expected, atol=1e-4)


def test_a_scan_after_its_stamp_is_placed_when_it_was_made():
    offsets = np.linspace(0.02, 0.12, len(WORLD))
    scan = SensorScan("laser", Time(5, 0), WORLD, offsets)
    placed = placed_scan(scan, sensor_at, base_at)
    assert abs(placed.scan.time - 5.02) < 1e-6
    np.testing.assert_allclose(placed.odometry, base_at(0.02), atol=1e-12)


def test_scans_of_several_sensors_are_joined():
    times = {0.0: WORLD[:150], 0.1: WORLD[150:]}
    scans = []
    for time, points in times.items():
        stamp = Time.from_sec(5.0 + time)
        points = moved(inverse(sensor_at(time)), points)
        scan = SensorScan("laser", stamp, points, None)
        scans.append(
            placed_scan(scan, lambda _, at=time: sensor_at(at), lambda _, at=time: base_at(at))
        )
    joined = joined_scan(scans)
    assert joined.stamp == scans[1].stamp and joined.scan.time == scans[1].scan.time
    np.testing.assert_allclose(moved(joined.odometry, joined.scan.points), WORLD, atol=1e-9)
    origins = moved(joined.odometry, joined.scan.origins)
    np.testing.assert_allclose(origins[0], sensor_at(0.0)[:3, 3], atol=1e-9)
    np.testing.assert_allclose(origins[-1], sensor_at(0.1)[:3, 3], atol=1e-9)
