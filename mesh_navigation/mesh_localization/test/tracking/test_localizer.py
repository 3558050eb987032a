"""A robot that drives over generated ground, followed by its scans."""

import math

import numpy as np
import pytest
from mesh_map.geometry.mesh_geometry import MeshGeometry
from mesh_map.registration.point_to_plane import PlaneTarget
from mesh_map.registration.rigid import inverse, motion, numbers_of
from mesh_map.scans.lidar import Lidar, LidarModel
from mesh_map.scans.odometry_drift import OdometryDrift
from mesh_map.scans.recording import record_scans
from mesh_map.scans.tour import tour
from mesh_msgs.outdoor_world import outdoor_world
from mesh_msgs.world.solids import box

from mesh_localization.tracking.localizer import (
    BaseScan,
    Localizer,
    TrackingOptions,
    TrackingState,
)
from mesh_localization.tracking.ray_fates import RayFate

LIDAR = LidarModel(
    columns=180, lowest=-math.radians(35), highest=math.radians(15), max_range=20.0, noise=0.015
)
DRIFT = OdometryDrift(slip=0.01, yaw=math.radians(0.5))
SURE = np.diag([1e-4] * 6)
PERIOD = 0.1  # s


@pytest.fixture(scope="module")
def mesh():
    world = outdoor_world(60_000, size=24.0, trees=False)
    return MeshGeometry(world.vertices, world.faces)


@pytest.fixture(scope="module")
def drive(mesh):
    return tour(mesh, count=4).above(1.0)


@pytest.fixture(scope="module")
def corridor():
    """80 x 3 x 2.5 m, of which a lidar in the middle does not see the ends."""
    vertices, faces = box([-40, -1.5, 0], [40, 1.5, 2.5])
    return MeshGeometry(np.float32(vertices), faces)


def localizer(mesh):
    return Localizer(PlaneTarget(mesh.spatial_index, mesh.face_normals))


class Robot:
    """One whose odometry stands still unless it is told otherwise; with its own localizer."""

    def __init__(self, mesh, pose, covariance=SURE, seed=0, height=0.0):
        self.above = np.array([0, 0, height])  # of the lidar over the base
        self.lidar, self.localizer = Lidar(mesh, LIDAR, seed=seed), localizer(mesh)
        self.truth, self.odometry, self.time = pose, np.eye(4), 0.0
        self.localizer.put(pose, covariance, self.odometry, self.time)

    def scan(self, times=1, hidden=None):
        """Its estimates after so many scans."""
        found = []
        for _ in range(times):
            self.time += PERIOD
            self.localizer.move(self.odometry)
            sensor = self.truth @ motion(np.r_[self.above, 0, 0, 0])
            points = self.lidar.measure(sensor, hidden=hidden).points + self.above
            found.append(self.localizer.add(BaseScan(points, self.above, self.time)))
        return found

    def blind(self, times):
        """Its estimates without scans."""
        found = []
        for _ in range(times):
            self.time += PERIOD
            self.localizer.move(self.odometry)
            found.append(self.localizer.estimate(self.time))
        return found


def off(pose, truth):
    numbers = numbers_of(inverse(truth) @ pose)
    return np.linalg.norm(numbers[:3]), np.linalg.norm(numbers[3:])


def states(estimates):
    return [estimate.state for estimate in estimates]


def test_a_robot_is_followed_although_its_odometry_drifts(mesh, drive):
    robot, count = localizer(mesh), 0
    for number, (scan, truth, _) in enumerate(
        record_scans(mesh, drive, lidar=LIDAR, odometry=DRIFT.of(drive), rate=2.0)
    ):
        if number == 0:
            robot.put(truth, SURE, scan.pose, scan.time)
        else:
            robot.move(scan.pose)
        points = scan.points.astype(np.float64)
        estimate = robot.add(BaseScan(points, np.zeros(3), scan.time))
        distance, angle = off(estimate.pose, truth)
        assert distance < 0.03 and angle < 0.005
        assert distance < 5 * estimate.deviations[0]
        if number < 2 or estimate.deviations[0] > 0.1:
            assert estimate.state == TrackingState.UNCERTAIN and estimate.reason
        else:
            assert estimate.state == TrackingState.OK, estimate.reason
            count += 1
    assert count > 0.9 * number
    assert off(scan.pose, truth)[0] > 0.2, "the odometry should have been off"
    assert off(estimate.correction @ scan.pose, truth)[0] < 0.03


def test_starts_that_are_half_a_meter_and_five_degrees_off(mesh, drive):
    random = np.random.default_rng(3)
    about = np.diag(np.square([0.3] * 3 + [0.06] * 3))
    wrong = 0
    for seed, truth in enumerate(drive.poses(random.uniform(*drive.times[[0, -1]], 20))):
        a, b = random.standard_normal((2, 3))
        begin = np.r_[0.5 * a / np.linalg.norm(a), math.radians(5) * b / np.linalg.norm(b)]
        robot = Robot(mesh, truth @ motion(begin), about, seed)
        robot.truth = truth
        last = robot.scan(4)[-1]
        if off(last.pose, truth)[0] > 0.05:
            wrong += 1
            assert last.state != TrackingState.OK
    assert wrong <= 2


def test_along_a_corridor_only_odometry_counts_and_the_covariance_says_so(corridor):
    begin = motion([-4.0, 0.3, 1.0, 0, 0, 0])
    robot = Robot(corridor, begin)
    assert states(robot.scan(3))[-1] == TrackingState.OK
    for step in range(1, 41):
        robot.truth = begin @ motion([0.2 * step, 0, 0, 0, 0, 0])
        robot.odometry = motion([0.2 * step * 1.01, 0.02 * step, 0, 0, 0, 0])  # it slips sideways
        (estimate,) = robot.scan()
        away = inverse(robot.truth) @ estimate.pose
        assert np.abs(away[1:3, 3]).max() < 0.02 and estimate.told == 5
        # Neither better nor worse than what odometry says.
        assert away[0, 3] == pytest.approx(0.002 * step, abs=0.01)
        deviation = math.sqrt(estimate.covariance[0, 0])
        assert away[0, 3] < deviation and math.sqrt(estimate.covariance[1, 1]) < 0.02
    assert deviation > 0.3 and estimate.state == TrackingState.UNCERTAIN
    assert "sure to 0.4" in estimate.reason


def test_obstacles_around_are_told_and_move_nothing(mesh, drive):
    def hidden(origins, directions):
        angle = np.degrees(np.arctan2(directions[:, 1], directions[:, 0]))
        return np.where((angle // 20) % 3 == 0, 1.0, np.inf)  # m

    robot = Robot(mesh, drive.poses([drive.times[0] + 5])[0])
    last = robot.scan(5, hidden)[-1]
    assert last.state == TrackingState.OK and off(last.pose, robot.truth)[0] < 0.02
    before = last.fates.count(RayFate.BEFORE) / len(last.fates.fates)
    assert 0.2 < before < 0.6 and last.fates.share > 0.98


def test_who_is_carried_elsewhere_is_lost_and_found_again_when_told(mesh, drive):
    here, there = drive.poses(drive.times[0] + np.array([1.0, 20.0]))
    robot = Robot(mesh, here)
    before = robot.scan(3)[-1]
    assert before.state == TrackingState.OK
    robot.truth = there @ motion([0, 0, 0, 0, 0, 1.0])
    estimates = robot.scan(22)
    assert estimates[-1].state == TrackingState.LOST and estimates[-1].reason
    assert TrackingState.OK not in states(estimates[1:])
    assert np.allclose(estimates[-1].pose, before.pose, atol=0.02), "it must not have jumped"
    about = np.diag(np.square([0.3] * 3 + [0.1] * 3))
    robot.localizer.put(
        robot.truth @ motion([0.2, -0.2, 0, 0, 0, 0.05]), about, np.eye(4), robot.time
    )
    last = robot.scan(3)[-1]
    assert last.state == TrackingState.OK and off(last.pose, robot.truth)[0] < 0.02


def test_a_sensor_that_is_off_while_the_wheels_slip(mesh, drive):
    robot = Robot(mesh, drive.poses([drive.times[0] + 8])[0])
    assert robot.scan(3)[-1].state == TrackingState.OK
    blind = []
    for step in range(50):
        robot.odometry = motion([0.5 * (step + 1) / 50, 0, 0, 0, 0, 0])  # but it stands
        blind += robot.blind(1)
    found = states(blind)
    assert found[3] == TrackingState.OK and found[6] == TrackingState.UNCERTAIN
    assert found[21:] == [TrackingState.LOST] * 29 and "no scan" in blind[-1].reason
    again = robot.scan(5)
    assert states(again)[:2] == [TrackingState.UNCERTAIN] * 2 or TrackingState.LOST in states(again)
    assert again[-1].state == TrackingState.OK and off(again[-1].pose, robot.truth)[0] < 0.02


def test_odometry_that_jumps_is_not_followed(mesh, drive):
    robot = Robot(mesh, drive.poses([drive.times[0] + 8])[0])
    robot.scan(3)
    robot.odometry = motion([0.4, 0.3, 0, 0, 0, 0.1])
    estimates = robot.scan(8)
    assert off(estimates[-1].pose, robot.truth)[0] < 0.02
    assert states(estimates)[0] == TrackingState.UNCERTAIN
    assert estimates[-1].state == TrackingState.OK
    pose = estimates[0].pose
    for before, after in zip(estimates, estimates[1:]):
        step = numbers_of(inverse(pose) @ after.pose)
        allowed = before.covariance + after.covariance
        assert step @ np.linalg.solve(allowed, step) < 25, "it jumped beyond its covariance"
        pose = after.pose


def wall_around(share, distance=0.8):
    """What hides a share of the view, as (m)."""

    def hidden(origins, directions):
        around = np.arctan2(directions[:, 1], directions[:, 0]) / np.pi
        return np.where(around < 2 * share - 1, distance, np.inf)

    return hidden


def test_a_view_that_is_hidden_more_and_more_is_no_other_place(mesh, drive):
    robot = Robot(mesh, drive.poses([drive.times[0] + 8])[0])
    robot.scan(3)
    for share in (0.3, 0.6, 0.7):
        robot.scan(1, wall_around(share))
    estimates = robot.scan(8, wall_around(0.95))
    assert set(states(estimates)) == {TrackingState.UNCERTAIN}
    assert "hidden" in estimates[-1].reason
    assert off(estimates[-1].pose, robot.truth)[0] < 0.02
    assert robot.scan(3)[-1].state == TrackingState.OK


def test_a_view_that_is_hidden_at_once_may_be_another_place(mesh, drive):
    robot = Robot(mesh, drive.poses([drive.times[0] + 8])[0])
    robot.scan(3)
    estimates = robot.scan(8, wall_around(1.0))
    assert states(estimates) == [TrackingState.UNCERTAIN] * 5 + [TrackingState.LOST] * 3
    assert off(estimates[-1].pose, robot.truth)[0] < 0.02
    assert robot.scan(3)[-1].state == TrackingState.OK


def test_another_map_is_said(mesh, corridor, drive):
    robot = Robot(mesh, motion([0.0, 0.3, 1.0, 0, 0, 0]))
    robot.localizer = localizer(corridor)
    robot.truth = drive.poses([drive.times[0] + 8])[0]
    robot.localizer.put(motion([0.0, 0.3, 1.0, 0, 0, 0]), SURE, np.eye(4), 0.0)
    estimates = robot.scan(25)
    assert TrackingState.OK not in states(estimates)
    assert estimates[-1].state == TrackingState.LOST and estimates[-1].reason


def test_who_was_never_told_says_so(mesh):
    robot = localizer(mesh)
    robot.move(np.eye(4))
    assert robot.add(BaseScan(np.zeros((0, 3)), np.zeros(3), 0.0)) is None
    assert robot.estimate(1.0) is None and robot.state == TrackingState.LOST


@pytest.mark.parametrize("count", [0, 1, 29])
def test_scans_of_next_to_no_points_are_not_believed(mesh, drive, count):
    robot = Robot(mesh, drive.poses([drive.times[0] + 8])[0])
    robot.scan(3)
    points = robot.lidar.measure(robot.truth).points[:count].astype(np.float64)
    estimate = robot.localizer.add(BaseScan(points, np.zeros(3), robot.time + 1.0))
    assert estimate.state == TrackingState.UNCERTAIN
    assert np.isfinite(estimate.pose).all() and np.isfinite(estimate.covariance).all()


def planar(odometry):
    """What wheels alone tell of poses: where in a plane, and how far turned."""
    poses = [np.eye(4)]
    for before, after in zip(odometry, odometry[1:]):
        step = inverse(before) @ after
        turn = math.atan2(step[1, 0], step[0, 0])
        length = np.linalg.norm(step[:3, 3]) * np.sign(step[0, 3])
        poses.append(poses[-1] @ motion([length, 0, 0, 0, 0, turn]))
    return poses


def test_odometry_that_knows_no_slopes(mesh, drive):
    """Of wheels alone, on hills."""
    ground = drive.above(-1.0)
    truths = ground.poses(np.arange(ground.times[0], ground.times[0] + 30, PERIOD))
    assert np.ptp(truths[:, 2, 3]) > 0.5 and truths[:, 2, 2].min() < 0.97
    robot = Robot(mesh, truths[0], height=1.0)
    for truth, odometry in zip(truths, planar(truths)):
        robot.truth, robot.odometry = truth, odometry
        (estimate,) = robot.scan()
        assert off(estimate.pose, truth)[0] < max(0.02, 2 * estimate.deviations[0])
        assert estimate.state != TrackingState.LOST
    assert estimate.state == TrackingState.OK


def test_one_ring_on_a_robot_that_stands_on_the_ground(drive):
    """A level LaserScan among walls says nothing of height and tilt: the ground does."""
    walls = [box(low, high) for low, high in (([-6, -5, -1], [6, 7, 3]), ([1, 2, 0], [2, 3, 3]))]
    vertices = np.concatenate([part[0] for part in walls])
    room, pillar = walls[0][1][:, ::-1], walls[1][1] + len(walls[0][0])  # seen from inside
    faces = np.concatenate([room, pillar])
    ramp = vertices.copy()
    ramp[:, 2] += 0.1 * ramp[:, 0]  # all of it rises by a tenth along x
    mesh = MeshGeometry(np.float32(ramp), faces, orient=False)
    tilt = -math.atan(0.1)
    begin = motion([-4, 0, -1 - 0.4 + 0.3, 0, 0, 0]) @ motion([0, 0, 0, 0, tilt, 0])
    options = TrackingOptions(base_height=0.3)
    robot = Robot(mesh, begin)
    robot.lidar = Lidar(mesh, LidarModel(rings=1, columns=720, lowest=0.0, highest=0.0, noise=0.01))
    robot.localizer = Localizer(PlaneTarget(mesh.spatial_index, mesh.face_normals), options)
    robot.localizer.put(begin, SURE, np.eye(4), 0.0)
    for step in range(1, 60):
        robot.truth = begin @ motion([0.1 * step, 0, 0, 0, 0, 0])
        robot.odometry = motion([0.1 * step * 1.02, 0, 0, 0, 0, 0.001 * step])
        (estimate,) = robot.scan()
        distance, angle = off(estimate.pose, robot.truth)
        assert distance < 0.05 and angle < 0.03, (step, distance, angle, estimate.told)
    assert estimate.state == TrackingState.OK and estimate.told < 6


def test_a_sensor_that_sits_higher_than_it_is_said(mesh, drive):
    truths = drive.above(-1.0).poses(np.arange(drive.times[0], drive.times[0] + 7, PERIOD))
    robot = Robot(mesh, truths[0], height=1.0)
    options = TrackingOptions(base_height=0.0)
    robot.localizer = Localizer(robot.localizer.target, options)
    robot.localizer.put(truths[0], SURE, truths[0], 0.0)
    said = robot.above.copy()
    for truth in truths:
        robot.truth = robot.odometry = truth
        sensor = truth @ motion([0, 0, 1.0, 0, 0, 0])
        points = robot.lidar.measure(sensor).points + said - [0, 0, 0.15]
        robot.time += PERIOD
        robot.localizer.move(robot.odometry)
        estimate = robot.localizer.add(BaseScan(points, said - [0, 0, 0.15], robot.time, "mast"))
    assert estimate.state == TrackingState.OK
    assert "mast" in robot.localizer.mounting_fault and "0.1" in robot.localizer.mounting_fault
    assert "above" in robot.localizer.mounting_fault


def test_odometry_that_scatters_from_step_to_step_is_believed(mesh, drive):
    """Wheels on gravel: 5 cm after 1 m, with another error in each step."""
    noisy = OdometryDrift(noise=0.05).of(drive, seed=4)
    robot = Robot(mesh, drive.poses(drive.times[:1])[0])
    moments = drive.times[0] + np.arange(0, 12, PERIOD)
    estimates = []
    begin = inverse(robot.truth)
    for truth, odometry in zip(drive.poses(moments), noisy.poses(moments)):
        robot.truth, robot.odometry = truth, begin @ odometry
        estimates += robot.scan()
        assert off(estimates[-1].pose, truth)[0] < max(0.03, 3 * estimates[-1].deviations[0])
    assert np.mean(np.array(states(estimates)) == TrackingState.OK) > 0.9
