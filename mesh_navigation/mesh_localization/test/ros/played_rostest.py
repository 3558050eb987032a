#!/usr/bin/python3
"""The node mesh_localization with two sensors, as a bag plays them, which begins again."""

import math
import unittest

import numpy as np
import rospy
import rostest
import tf2_ros
from geometry_msgs.msg import PoseWithCovarianceStamped
from localization_machine import Node, write_map
from mesh_map.geometry.mesh_geometry import MeshGeometry
from mesh_map.registration.rigid import inverse, motion, numbers_of
from mesh_map.scans.cloud_message import cloud_message
from mesh_map.scans.lidar import Lidar, LidarModel
from mesh_map.scans.odometry_drift import OdometryDrift
from mesh_map.scans.tour import tour
from mesh_map.scans.trajectory import Trajectory
from mesh_msgs.msg import LocalizationState
from mesh_msgs.outdoor_world import outdoor_world
from mesh_msgs.point_cloud import cloud_rows
from mesh_msgs.testing import wait_until
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import LaserScan, PointCloud2

from mesh_localization.node.messages import pose_matrix, transform_message

OK = LocalizationState.OK
BEGIN = 1000.0  # s
STEP, LATE = 0.02, 0.04  # s, of transforms, and that they come after scans
MOUNTS = {
    "laser": motion(np.array([0.2, 0.0, 0.9, 0.0, 0.0, 0.0])),
    "front": motion(np.array([0.4, 0.1, 0.5, math.pi, 0.0, 0.3])),  # hanging, turned
}
ROBOT = LidarModel(rings=16, columns=360, noise=0.015, duration=0.1)
FRONT = LidarModel(rings=1, columns=360, lowest=0.0, highest=0.0, noise=0.01)
BOX = 2.5  # m to what is not on the map


def hidden(_origins, directions):
    """(N,) m: something stands in the east, in the way of level rays."""
    is_east = (directions[:, 0] > 0.97) & (np.abs(directions[:, 2]) < 0.15)
    return np.where(is_east, BOX, np.inf)


class PlayedDrive:
    """A drive over a world, and what sensors and odometry tell of it."""

    def __init__(self, geometry):
        poses = tour(geometry, count=2)
        self.truth = Trajectory(poses.times + BEGIN, poses.positions, poses.orientations)
        self.odometry = OdometryDrift(slip=0.01, yaw=math.radians(0.5)).of(self.truth)
        self.lidar, self.front = Lidar(geometry, ROBOT), Lidar(geometry, FRONT)
        self._clock = rospy.Publisher("/clock", Clock, queue_size=10)
        self._cloud = rospy.Publisher("/lidar/points", PointCloud2, queue_size=10)
        self._scan = rospy.Publisher("/front/scan", LaserScan, queue_size=10)
        self._tf = tf2_ros.TransformBroadcaster()
        self._static = tf2_ros.StaticTransformBroadcaster()
        self.time = BEGIN

    def is_heard(self):
        return self._cloud.get_num_connections() and self._scan.get_num_connections()

    def begin(self):
        self.time = BEGIN
        frames = [
            transform_message("base_link", frame, mount, rospy.Time())
            for frame, mount in MOUNTS.items()
        ]
        self._static.sendTransform(frames)

    def go_on(self, seconds):
        """Tell time and transforms."""
        for _ in range(round(seconds / STEP)):
            self.time += STEP
            stamp = rospy.Time.from_sec(self.time - LATE)
            pose = self.odometry.poses([stamp.to_sec()])[0]
            self._clock.publish(Clock(rospy.Time.from_sec(self.time)))
            self._tf.sendTransform(transform_message("odom", "base_link", pose, stamp))

    def tell_cloud(self):
        """The revolution that ends now; returns its stamp."""
        begin = self.time - ROBOT.duration
        times = np.linspace(begin, self.time, 11)
        sensor = Trajectory.of_matrices(self.truth.poses(times) @ MOUNTS["laser"], times)
        stamp = rospy.Time.from_sec(begin)
        self._cloud.publish(
            cloud_message(self.lidar.measure(sensor, begin, hidden), "laser", stamp)
        )
        return stamp

    def tell_scan(self):
        """What the sensor in front sees now; returns the stamp."""
        stamp = rospy.Time.from_sec(self.time)
        pose = self.truth.poses([self.time])[0] @ MOUNTS["front"]
        message = LaserScan(range_min=0.1, range_max=30.0, angle_min=-math.pi)
        message.header.frame_id, message.header.stamp = "front", stamp
        message.angle_increment = 2 * math.pi / FRONT.columns
        points = self.front.measure(pose, self.time).points
        columns = np.arctan2(points[:, 1], points[:, 0]) - message.angle_min
        columns = np.rint(columns / message.angle_increment).astype(int) % FRONT.columns
        ranges = np.full(FRONT.columns, np.inf)
        ranges[columns] = np.linalg.norm(points, axis=1)
        message.ranges = ranges.tolist()
        self._scan.publish(message)
        return stamp


class PlayedTest(unittest.TestCase):
    def setUp(self):
        world = outdoor_world(20_000, size=30.0, trees=False)
        self.drive = PlayedDrive(MeshGeometry(world.vertices, world.faces))
        self.states, self.poses, self.unexplained = [], {}, []
        start = self.drive.truth.poses([BEGIN])[0]
        self.node = Node(
            "mesh_localization",
            "mesh_localization",
            mesh_file=write_map(world),
            observation_sources="lidar front",
            lidar={"topic": "/lidar/points"},
            front={"topic": "/front/scan", "data_type": "LaserScan"},
            initial_pose_x=float(start[0, 3]) + 0.2,
            initial_pose_y=float(start[1, 3]) - 0.2,
            initial_pose_z=float(start[2, 3]),
            initial_pose_a=math.atan2(start[1, 0], start[0, 0]) + 0.05,
            lost_timeout=30.0,
            tf_timeout=10.0,
        )
        self.addCleanup(self.node.stop)
        name = "/mesh_localization/"
        rospy.Subscriber(name + "state", LocalizationState, self.states.append)
        rospy.Subscriber(name + "pose", PoseWithCovarianceStamped, self.on_pose)
        rospy.Subscriber(name + "unexplained", PointCloud2, self.unexplained.append)
        wait_until(self.drive.is_heard, "the node")

    def on_pose(self, message):
        self.poses[message.header.stamp.to_nsec()] = message

    def test_two_sensors_and_a_bag_that_begins_again(self):
        self.drive.begin()
        wait_until(lambda: self.drive.go_on(STEP) or self.states, "a state")
        wait_until(lambda: self.drive.go_on(STEP) or self.is_ready(), "the map")
        self.is_followed()
        self.sees_what_is_not_on_the_map()
        self.poses.clear()
        self.drive.begin()
        self.drive.go_on(1.0)
        wait_until(lambda: "time has jumped back" in self.node.output(), "a jump")
        self.is_followed()
        self.assertEqual(self.node.stop(), 0)

    def is_ready(self):
        return "no scan has confirmed the pose" in self.states[-1].reason

    def is_followed(self):
        """Each scan has a pose near the truth, and the robot becomes sure of it."""
        wait_until(self.is_placed, "a pose")
        for number in range(20):
            self.drive.go_on(0.1)
            for tell in (self.drive.tell_cloud, self.drive.tell_scan):
                stamp = tell()
                self.drive.go_on(3 * STEP)  # transforms of the end of the scan
                wait_until(lambda: stamp.to_nsec() in self.poses, "a pose")
                found = pose_matrix(self.poses[stamp.to_nsec()].pose.pose)
                truth = self.drive.truth.poses([stamp.to_sec()])[0]
                off = numbers_of(inverse(truth) @ found)
                if number > 2:
                    self.assertLess(np.linalg.norm(off[:3]), 0.05)
                    self.assertLess(np.linalg.norm(off[3:]), math.radians(1.0))
        wait_until(lambda: self.states[-1].state == OK, "the state OK")

    def is_placed(self):
        """Whether scans are used; transforms of before may be forgotten late."""
        self.drive.go_on(0.1)
        self.drive.tell_cloud()
        self.drive.go_on(3 * STEP)
        return wait_until(lambda: self.poses, seconds=0.2)

    def sees_what_is_not_on_the_map(self):
        clouds = [one for one in self.unexplained if one.header.frame_id == "laser"]
        rows = cloud_rows(clouds[-1])
        ranges = np.sqrt(rows["x"] ** 2 + rows["y"] ** 2 + rows["z"] ** 2)
        self.assertGreater(np.count_nonzero(np.abs(ranges - BOX) < 0.1), 10)


if __name__ == "__main__":
    rospy.init_node("played_test")
    rostest.rosrun("mesh_localization", "played", PlayedTest)
