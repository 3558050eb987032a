"""Starts, maps, scans and silence, and the states that follow."""

import numpy as np
import pytest
from genpy import Time
from mesh_map.base.errors import MeshMapError
from mesh_map.geometry.mesh_geometry import MeshGeometry
from mesh_map.registration.point_to_plane import PlaneTarget
from mesh_map.registration.rigid import inverse, motion, moved, numbers_of
from mesh_map.scans.lidar import Lidar, LidarModel
from mesh_msgs.outdoor_world import outdoor_world

from mesh_localization.node.session import LocalizationSession
from mesh_localization.node.start_pose import Start, on_ground
from mesh_localization.sensing.placed_scan import PlacedScan
from mesh_localization.sensing.ray_choice import chosen_rays
from mesh_localization.tracking.localizer import BaseScan, TrackingOptions, TrackingState

MODEL = LidarModel(noise=0.01)
MOUNT = motion(np.array([0.0, 0.0, 0.8, 0.0, 0.0, 0.0]))
VARIANCES = {0: 0.25, 1: 0.25, 5: 0.07}
LOST, UNCERTAIN, OK = TrackingState.LOST, TrackingState.UNCERTAIN, TrackingState.OK


class Robot:
    """One that stands on a world; its odometry began elsewhere."""

    def __init__(self):
        world = outdoor_world(20_000, size=30.0)
        self.mesh = MeshGeometry(world.vertices, world.faces)
        self.target = PlaneTarget(self.mesh.spatial_index, self.mesh.face_normals)
        start = np.eye(4)
        start[:3, 3] = world.places["start"]
        found = on_ground(self.target.index, self.target.normals, start, 0.0)
        assert found is not None
        self.pose = found
        self.odometry_origin = motion(np.array([1.0, 2.0, 0.0, 0.0, 0.0, 0.5]))
        self.lidar = Lidar(self.mesh, MODEL)

    def odometry(self, pose=None):
        return inverse(self.odometry_origin) @ (self.pose if pose is None else pose)

    def scan(self, time, pose=None, hanging=False):
        """What the lidar sees; hanging: although TF says that it stands."""
        pose = self.pose if pose is None else pose
        turn = np.diag([1.0, -1.0, -1.0, 1.0]) if hanging else np.eye(4)
        measured = self.lidar.measure(pose @ MOUNT @ turn, time).points
        points = moved(MOUNT, measured[chosen_rays(len(measured), 1500)])
        scan = BaseScan(points, MOUNT[:3, 3], time)
        return PlacedScan(scan, self.odometry(pose), MOUNT, Time.from_sec(time), "laser")


@pytest.fixture(scope="module")
def robot():
    return Robot()


@pytest.fixture
def session(robot):
    session = LocalizationSession(TrackingOptions(), 0.0, VARIANCES)
    session.take_map(robot.target, 0.0)
    return session


def localized(session, robot):
    """Tell the session where the robot is, and let it see that; returns the time."""
    session.begin_at(Start(robot.pose, np.zeros((6, 6))))
    for number in range(5):
        report = session.add(robot.scan(1.0 + 0.1 * number))
    assert report is not None and report.state == OK and report.reason == ""
    return 1.4


def no_odometry():
    raise MeshMapError("no transform from 'base_link' to 'odom'")


def off(report, pose):
    return np.linalg.norm(numbers_of(inverse(pose) @ report.estimate.pose))


def test_it_says_what_it_waits_for(robot):
    session = LocalizationSession(TrackingOptions(), 0.0, VARIANCES)
    report = session.look(1.0, robot.odometry)
    assert (report.state, report.reason) == (LOST, "there is no map yet")
    session.map_fault = "the map is being read"
    assert session.look(1.0, robot.odometry).reason == "the map is being read"
    session.begin_at(Start(robot.pose, np.zeros((6, 6))))
    assert session.add(robot.scan(1.0)) is None
    session.take_map(robot.target, 1.0)
    report = session.look(1.1, no_odometry)
    assert report.state == LOST and "waits for odometry: no transform from" in report.reason
    assert not report.is_known
    report = session.look(1.2, robot.odometry)
    assert report.state == UNCERTAIN and report.is_known


def test_without_a_start_it_is_lost(session, robot):
    assert session.add(robot.scan(1.0)) is None
    report = session.look(1.1, robot.odometry)
    assert report.state == LOST and "it has not been told where it is" in report.reason


def test_a_start_off_the_map_is_refused(session, robot):
    session.begin_at(Start(motion(np.array([500.0, 0, 0, 0, 0, 0])), np.zeros((6, 6))))
    report = session.look(1.0, robot.odometry)
    assert report.state == LOST
    assert "there is no ground above or below (500.00, 0.00)" in session.start_refusal


def test_the_correction_leads_from_odometry_to_the_map(session, robot):
    time = localized(session, robot)
    report = session.look(time + 0.1, robot.odometry)
    assert report.state == OK and off(report, robot.pose) < 0.01
    np.testing.assert_allclose(report.estimate.correction, robot.odometry_origin, atol=0.01)
    assert report.explained > 0.95 and report.residual < 0.05


def test_silence_is_told_with_what_cannot_be_used(session, robot):
    time = localized(session, robot)
    session.scan_fault = "what comes from /cloud cannot be used: it has no point"
    assert session.look(time + 0.4, robot.odometry).reason == ""
    report = session.look(time + 0.7, robot.odometry)
    assert report.state == UNCERTAIN and report.reason.endswith("it has no point")
    assert np.isnan(report.explained)
    report = session.look(time + 3.0, robot.odometry)
    assert report.state == LOST and not report.is_known


def test_odometry_goes_on_where_no_scans_come(session, robot):
    time = localized(session, robot)
    ahead = robot.pose @ motion(np.array([0.5, 0.0, 0.0, 0.0, 0.0, 0.1]))
    report = session.look(time + 0.5, lambda: robot.odometry(ahead))
    assert off(report, ahead) < 0.01


def test_on_another_map_the_pose_has_to_be_confirmed(session, robot):
    time = localized(session, robot)
    session.take_map(robot.target, time)
    report = session.look(time, robot.odometry)
    assert report.state == UNCERTAIN and off(report, robot.pose) < 0.01
    for number in range(3):
        report = session.add(robot.scan(time + 0.1 + 0.1 * number))
    assert report.state == OK and off(report, robot.pose) < 0.01


def test_who_is_lost_is_lost_on_another_map_too(session, robot):
    time = localized(session, robot)
    assert session.look(time + 3.0, robot.odometry).state == LOST
    session.take_map(robot.target, time + 3.0)
    assert session.look(time + 3.1, robot.odometry).state == LOST


def test_a_sensor_that_hangs_is_told(session, robot):
    session.begin_at(Start(robot.pose, np.zeros((6, 6))))
    for number in range(5):
        report = session.add(robot.scan(10.0 + 0.1 * number, hanging=True))
    assert report.state != OK
    assert "the scan fits upside down: frame laser is the wrong way up in TF" in report.reason


def test_scans_of_a_robot_that_stands_may_be_left_out(session, robot):
    time = localized(session, robot)
    session.least_motion = (0.2, 0.2)
    assert session.add(robot.scan(time + 0.1)) is None
    ahead = robot.pose @ motion(np.array([0.3, 0.0, 0.0, 0.0, 0.0, 0.0]))
    assert session.add(robot.scan(time + 0.2, ahead)) is not None
    assert session.add(robot.scan(time + 0.3, ahead)) is None
    assert session.add(robot.scan(time + 0.5, ahead)) is not None, "silence is near"


def test_it_begins_anew(session, robot):
    localized(session, robot)
    session.begin_anew()
    report = session.look(0.1, robot.odometry)
    assert report.state == LOST and "it has not been told" in report.reason
    localized(session, robot)


def test_a_search_that_took_longer_than_silence_may_last(session, robot):
    """The scan that was looked for is old by then, but nobody is lost for that."""
    assert session.look(1.1, robot.odometry).state == LOST
    session.put(robot.pose, np.diag([1e-4] * 6), robot.scan(1.0), 8.0)
    report = session.look(8.05, robot.odometry)
    assert report.state == UNCERTAIN and report.is_known
    for number in range(3):
        report = session.add(robot.scan(8.1 + 0.1 * number))
    assert report.state == OK and off(report, robot.pose) < 0.02


def test_a_search_that_agrees_changes_nothing_and_another_one_does(session, robot):
    time = localized(session, robot)
    session.put(robot.pose, np.diag([1e-4] * 6), robot.scan(1.0), time + 0.1)
    assert session.look(time + 0.1, robot.odometry).state == OK
    elsewhere = robot.pose @ motion(np.array([1.0, 0, 0, 0, 0, 0]))
    session.put(elsewhere, np.diag([1e-4] * 6), robot.scan(1.0), time + 0.1)
    report = session.look(time + 0.1, robot.odometry)
    assert report.state == UNCERTAIN and off(report, elsewhere) < 0.1
