"""A robot found in a building of which it knows nothing but one scan."""

import math
from dataclasses import replace

import numpy as np
import pytest
from mesh_map.base.cancel import CancelFlag
from mesh_map.base.errors import Canceled
from mesh_map.geometry.mesh_geometry import MeshGeometry
from mesh_map.registration.rigid import inverse, numbers_of
from mesh_map.scans.lidar import Lidar, LidarModel
from mesh_msgs.world.building import HEIGHT, building, walls
from mesh_msgs.world.solids import box, flipped, floor, joined

from mesh_localization.relocalization.global_search import (
    GlobalSearch,
    SearchOptions,
    SearchState,
)
from mesh_localization.relocalization.pose_sampling import SearchRegion
from mesh_localization.tracking.localizer import BaseScan

SENSOR = 0.6  # m above the ground
LIDAR = LidarModel(columns=120, noise=0.015)
LASER = LidarModel(rings=1, columns=720, lowest=0.0, highest=0.0, noise=0.015)
FEWER = SearchOptions(kept=(300, 900), candidates=30)
PLACES = [(3.0, 4.5, 0.0, 0.4), (30.0, 19.0, 0.0, -2.0), (5.0, 8.0, HEIGHT, 2.8)]


@pytest.fixture(scope="module")
def mesh():
    parts = [building()]
    for level, rectangles in zip((0.0, HEIGHT), walls()):
        for x0, y0, x1, y1 in rectangles:
            parts.append(box((x0, y0, level), (x1, y1, level + 2.8)))
    return MeshGeometry(*joined(*parts))


def pose_at(x, y, z, heading):
    pose = np.eye(4)
    sine, cosine = math.sin(heading), math.cos(heading)
    pose[:2, :2] = [[cosine, -sine], [sine, cosine]]
    pose[:3, 3] = x, y, z
    return pose


def scan_at(mesh, pose, model=LIDAR, base_height=0.0, half_view=math.pi):
    """By a lidar above a base whose frame is so high above the ground."""
    sensor = pose.copy()
    sensor[2, 3] += SENSOR
    points = Lidar(mesh, model).measure(sensor).points.astype(np.float64)
    points = points[abs(np.arctan2(points[:, 1], points[:, 0])) < half_view]
    up = np.array([0, 0, SENSOR - base_height])
    return BaseScan(points + up, up, 0.0)


def off(pose, truth):
    numbers = numbers_of(inverse(truth) @ pose)
    return np.linalg.norm(numbers[:3]), np.linalg.norm(numbers[3:])


@pytest.mark.parametrize("place", PLACES)
def test_a_robot_is_found_on_either_storey(mesh, place):
    truth, base_height = pose_at(*place), 0.2
    scan = scan_at(mesh, truth, base_height=base_height)
    shares = []
    search = GlobalSearch(mesh, replace(FEWER, base_height=base_height))
    result = search.search(scan, progress=shares.append)
    truth[2, 3] += base_height
    assert result.state == SearchState.FOUND, result.reason
    distance, angle = off(result.best.pose, truth)
    assert distance < 0.02 and angle < 0.005
    assert result.best.share > 0.95 and "explains" in result.reason
    assert 0 < np.linalg.eigvalsh(result.best.covariance)[0]
    assert distance < 5 * math.sqrt(np.trace(result.best.covariance[:3, :3]))
    assert result.second is not None and off(result.second.pose, result.best.pose)[0] > 0.2
    assert shares == sorted(shares) and shares[-1] == 1.0


def test_a_laser_scan_of_half_the_way_round_is_enough(mesh):
    truth = pose_at(*PLACES[1])
    scan = scan_at(mesh, truth, LASER, half_view=math.radians(135))
    result = GlobalSearch(mesh, FEWER).search(scan)
    distance, angle = off(result.best.pose, truth)
    assert np.linalg.norm((inverse(truth) @ result.best.pose)[:2, 3]) < 0.05, result.reason
    assert distance < 0.3 and angle < 0.1


def test_obstacles_hide_a_third_of_the_view(mesh):
    truth = pose_at(*PLACES[2])
    scan = scan_at(mesh, truth)
    around = np.arctan2(scan.points[:, 1], scan.points[:, 0])
    points, up = scan.points.copy(), scan.origins
    hidden = (abs(around) < 0.6) | (abs(around - 2.2) < 0.4)
    ways = points[hidden] - up
    ranges = np.linalg.norm(ways, axis=1)
    points[hidden] = up + ways * np.minimum(1.0, 1.2 / ranges)[:, None]
    result = GlobalSearch(mesh).search(BaseScan(points, up, 0.0))
    assert result.state == SearchState.FOUND, result.reason
    assert off(result.best.pose, truth)[0] < 0.03


def test_a_region_is_looked_at_alone(mesh):
    truth = pose_at(*PLACES[0])
    scan = scan_at(mesh, truth)
    search = GlobalSearch(mesh, FEWER)
    near = search.search(scan, region=SearchRegion(truth[:3, 3] + [1.0, 0.5, 0.1], 2.5))
    assert near.state == SearchState.FOUND, near.reason
    assert off(near.best.pose, truth)[0] < 0.02
    elsewhere = search.search(scan, region=SearchRegion(np.array([30.0, 19.0, 0.0]), 2.0))
    assert elsewhere.state == SearchState.NOT_FOUND and "fits nowhere" in elsewhere.reason
    nowhere = search.search(scan, region=SearchRegion(np.array([300.0, 0.0, 0.0]), 2.0))
    assert nowhere.state == SearchState.NOT_FOUND and nowhere.best is None
    assert "within 2 m of 300.0, 0.0, 0.0" in nowhere.reason


def test_the_same_scan_has_the_same_result(mesh):
    scan = scan_at(mesh, pose_at(*PLACES[0]))
    region = SearchRegion(np.array([3.0, 4.5, 0.0]), 3.0)
    one, other = (GlobalSearch(mesh, FEWER).search(scan, region=region) for _ in range(2))
    np.testing.assert_array_equal(one.best.pose, other.best.pose)
    assert one.reason == other.reason


def test_a_room_that_is_the_same_turned_is_ambiguous():
    room = MeshGeometry(
        *joined(
            floor((0, 0), (8, 5), 1.0),
            flipped(box((0, 0, -0.1), (8, 5, 3))),
            box((1, 1, 0), (2, 1.5, 2)),
            box((6, 3.5, 0), (7, 4, 2)),
        )
    )
    truth = pose_at(5.0, 2.0, 0.0, 0.7)
    result = GlobalSearch(room, FEWER).search(scan_at(room, truth))
    assert result.state == SearchState.AMBIGUOUS
    assert "two places" in result.reason and "180 degrees" in result.reason
    turned = pose_at(3.0, 3.0, 0.0, 0.7 + math.pi)
    found = sorted(off(fit.pose, truth)[0] for fit in (result.best, result.second))
    assert found[0] < 0.02 and np.isclose(found[1], math.hypot(2, 1), atol=0.02)
    assert min(off(fit.pose, turned)[0] for fit in (result.best, result.second)) < 0.02


def test_a_scan_of_another_map_is_not_believed(mesh):
    other = MeshGeometry(
        *joined(
            floor((0, 0), (9, 7), 1.0),
            flipped(box((0, 0, -0.1), (9, 7, 3))),
            *(box((x, y, 0), (x + 0.4, y + 0.9, 2)) for x, y in ((2, 1), (6, 2), (5, 5), (2.5, 4))),
        )
    )
    result = GlobalSearch(mesh, FEWER).search(scan_at(other, pose_at(4.0, 3.0, 0.0, 0.3)))
    assert result.state != SearchState.FOUND
    assert result.best.explained < 0.6 and result.reason


def test_few_points_and_bare_ground_say_nothing(mesh):
    result = GlobalSearch(mesh, FEWER).search(BaseScan(np.ones((10, 3)), np.zeros(3), 0.0))
    assert result.state == SearchState.NOT_FOUND and "10 of the scan's 10 points" in result.reason
    plain = MeshGeometry(*floor((0, 0), (40, 30), 10.0))
    result = GlobalSearch(plain).search(scan_at(plain, pose_at(15.0, 15.0, 0.0, 0.0)))
    assert result.state == SearchState.NOT_FOUND and "0 of the scan's" in result.reason


def test_a_large_map_is_looked_at_in_larger_steps():
    blocks = np.random.default_rng(0).uniform([0, 0, 2, 2], [90, 70, 12, 12], (16, 4))
    boxes = [box((x, y, -0.1), (x + dx, y + dy, 3)) for x, y, dx, dy in blocks]
    city = MeshGeometry(*joined(floor((0, 0), (100, 80), 10.0), *boxes))
    truth = pose_at(47.3, 42.6, 0.0, 1.0)
    scan = scan_at(city, truth)
    result = GlobalSearch(city, replace(FEWER, most_rays=500_000)).search(scan)
    assert result.state == SearchState.FOUND, result.reason
    assert off(result.best.pose, truth)[0] < 0.03


def test_a_search_can_be_ended(mesh):
    flag = CancelFlag()
    flag.set()
    with pytest.raises(Canceled):
        GlobalSearch(mesh, FEWER).search(scan_at(mesh, pose_at(*PLACES[0])), cancel=flag)
