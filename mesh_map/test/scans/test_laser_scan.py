"""Scans as points: what a ray met, and where one ends that met nothing."""

import math

import numpy as np
import pytest
from mesh_map.base.errors import MeshMapError
from mesh_map.scans.laser_scan import scan_points
from sensor_msgs.msg import LaserScan

INF, NAN = math.inf, math.nan


def scan(ranges, **fields):
    """A quarter turn from one ray to the next, beginning ahead."""
    given = {"angle_increment": math.pi / 2, "range_min": 0.1, "range_max": 5.0, **fields}
    return LaserScan(ranges=ranges, **given)


def test_rays_turn_left_from_the_first_angle():
    met, free = scan_points(scan([1.0, 2.0, 3.0, 4.0]))
    np.testing.assert_allclose(met, [[1, 0, 0], [0, 2, 0], [-3, 0, 0], [0, -4, 0]], atol=1e-12)
    assert free.shape == (0, 3)
    met, _ = scan_points(scan([1.0, 2.0], angle_min=math.pi, angle_increment=-math.pi / 2))
    np.testing.assert_allclose(met, [[-1, 0, 0], [0, 2, 0]], atol=1e-12)


def test_ranges_that_say_nothing():
    ranges = [0.1, 5.0, 0.09, 5.1, NAN, -INF, INF, -1.0]
    met, free = scan_points(scan(ranges))
    assert len(met) == 2 and len(free) == 0
    met, free = scan_points(scan(ranges), inf_is_valid=True)
    assert len(met) == 2
    np.testing.assert_allclose(free, [[-5, 0, 0]], atol=1e-12)
    assert scan_points(scan([INF], range_max=INF), inf_is_valid=True)[1].shape == (0, 3)


@pytest.mark.parametrize(
    "ranges", [[], [NAN, NAN], [0.0, 0.0], [-INF, -INF], [0.09, NAN, 0.0, -INF, -1.0]]
)
def test_a_blind_or_covered_scanner(ranges):
    for nearest in (0.1, 0.0) if 0.09 not in ranges else (0.1,):
        with pytest.raises(MeshMapError, match="none of the %d ranges" % len(ranges)):
            scan_points(scan(ranges, range_min=nearest), inf_is_valid=True)


@pytest.mark.parametrize("ranges", [[INF, -INF], [5.1, 0.0], [NAN, 5.0]])
def test_a_scanner_that_sees_nothing_near(ranges):
    scan_points(scan(ranges))


@pytest.mark.parametrize(
    "fields, message",
    [
        ({"angle_min": NAN}, "angles from nan"),
        ({"angle_increment": 0.0}, "0 rad apart"),
        ({"angle_increment": INF}, "inf rad apart"),
        ({"range_min": 5.0}, "ranges from 5 to 5 m"),
        ({"range_max": NAN}, "ranges from 0.1 to nan m"),
        ({"range_min": -1.0}, "ranges from -1 to 5 m"),
    ],
)
def test_what_is_no_scan_is_refused(fields, message):
    with pytest.raises(MeshMapError, match=message):
        scan_points(scan([1.0, 2.0], **fields))
