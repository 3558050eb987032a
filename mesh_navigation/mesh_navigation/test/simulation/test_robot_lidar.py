"""The lidar on a simulated robot: what hides the mesh, and from where it measured."""

import math

import numpy as np
import pytest

from mesh_map.base.parameter import read_parameters
from mesh_map.map.mesh_map import MeshMap
from mesh_map.scans.lidar import Lidar, LidarModel
from mesh_map.scans.trajectory import Trajectory
from mesh_map.spatial.hits import NO_FACE
from mesh_msgs import zoo
from mesh_navigation.base.pose import Pose, rotate
from mesh_navigation.simulation.obstacles import Obstacle
from mesh_navigation.simulation.parameters import PARAMETERS
from mesh_navigation.simulation.robot_lidar import RobotLidar, lidar_model, pose_matrix

GRID = zoo.grid()
FLOOR = MeshMap(GRID.vertices, GRID.faces)


def test_obstacles_hide_what_is_behind_them():
    lidar = RobotLidar(FLOOR, LidarModel(rings=31, columns=180))
    box = Obstacle.checked("box", Pose.at((7, 5, 0.5)), (1, 1, 1))
    pose = Pose.at((5, 5, 0.8), 0.5)
    lidar.follow(1.0, pose)
    bare, seen = lidar.scan(), lidar.scan([box])
    assert (
        bare.points.tolist()
        == Lidar(FLOOR, LidarModel(rings=31, columns=180))
        .measure(pose_matrix(pose))
        .points.tolist()
    )
    rays = LidarModel(rings=31, columns=180).directions()
    turned = np.array([rotate(pose.orientation, ray) for ray in rays])
    alone = box.ray_distances(pose.position, turned)
    ranges = Lidar(FLOOR, LidarModel(rings=31, columns=180)).ranges(pose_matrix(pose))
    expected = np.minimum(alone, ranges)
    assert np.linalg.norm(seen.points, axis=1) == pytest.approx(expected[np.isfinite(expected)])
    assert (alone < ranges).sum() > 100
    cloud = np.array([rotate(pose.orientation, point) for point in seen.points]) + pose.position
    on_ground = abs(cloud[:, 2]) < 1e-5
    hull = abs(abs((cloud - box.pose.position) / 0.5).max(axis=1) - 1) < 1e-5
    assert (on_ground | hull).all() and hull.sum() > 100


def test_a_revolution_is_measured_from_where_the_robot_was():
    model = LidarModel(duration=0.1, noise=0.01)
    lidar = RobotLidar(FLOOR, model, seed=4)
    assert lidar.scan() is None
    poses = {10 + 0.02 * k: Pose.at((4 + 0.1 * k, 5 + 0.01 * k * k, 1), 0.2 * k) for k in range(12)}
    for time, pose in poses.items():
        lidar.follow(time, pose)
        if time < 10.1 - 1e-9:
            assert lidar.scan() is None
    times = list(poses)
    positions = np.array([pose.position for pose in poses.values()])
    turns = np.array([pose.orientation for pose in poses.values()])
    expected = Lidar(FLOOR, model, seed=4).measure(
        Trajectory(times, positions, turns), times[-1] - 0.1
    )
    scan = lidar.scan()
    assert scan.time == expected.time and scan.points.tolist() == expected.points.tolist()
    assert scan.times.max() == pytest.approx(0.1 * 359 / 360)
    # Obstacles hide the mesh from where the sensor was, too.
    post = Obstacle.checked("cylinder", Pose.at((7, 5.5, 1)), (0.5, 0.5, 2))
    hidden = RobotLidar(FLOOR, LidarModel(duration=0.1), seed=4)
    for time, pose in poses.items():
        hidden.follow(time, pose)
    scan = hidden.scan([post])
    met = scan.faces == NO_FACE
    seen, rotations = Trajectory(times, positions, turns).at(
        scan.time + np.float64(scan.times[met])
    )
    places = seen + np.einsum("nij,nj->ni", rotations, scan.points[met]) - post.pose.position
    assert met.sum() > 20 and (np.hypot(*places[:, :2].T) < 0.25 + 1e-5).all()
    lidar.begin_anew()
    lidar.follow(20.0, Pose.at((1, 1, 1)))
    assert lidar.scan() is None
    lidar.follow(3.0, Pose.at((1, 1, 1)))  # time jumped back
    lidar.follow(3.05, Pose.at((1, 1, 1)))
    assert lidar.scan() is None


def test_parameters_make_a_lidar():
    defaults, _ = read_parameters(PARAMETERS, {})
    assert lidar_model(defaults) == LidarModel(lowest=-0.6, highest=0.26)
    given = {"scan_rings": 64, "scan_lowest": 0.3, "scan_highest": -0.4, "scan_max_range": 0.5}
    given.update(scan_dropout=0.1, scan_reflect_range=50.0, scan_duration=2.0, scan_rate=10.0)
    values, complaints = read_parameters(PARAMETERS, given)
    assert complaints == []
    model = lidar_model(values)
    assert (model.rings, model.lowest, model.highest) == (64, -0.4, 0.3)
    assert (model.min_range, model.max_range, model.dropout) == (0.25, 0.5, 0.1)
    assert (model.reflect_range, model.duration) == (50.0, 0.1)
    assert lidar_model({**values, "scan_rate": 0.0}).duration == 2.0
    assert math.isinf(lidar_model({**values, "scan_reflect_range": 0.0}).reflect_range)
