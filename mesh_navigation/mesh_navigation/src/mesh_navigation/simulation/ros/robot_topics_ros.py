"""All that a simulated robot publishes."""

from typing import Any, Mapping

import rospy
import tf2_ros
from geometry_msgs.msg import PoseStamped
from nav_msgs.msg import Odometry
from sensor_msgs.msg import PointCloud2
from visualization_msgs.msg import MarkerArray

from mesh_map.scans.cloud_message import cloud_message
from mesh_map.scans.lidar import LidarScan

from mesh_navigation.base.messages import pose_message
from mesh_navigation.base.pose import Pose, transformed
from mesh_navigation.simulation.obstacle_messages import ObstacleMarkers
from mesh_navigation.simulation.robot_messages import (
    above,
    odometry,
    odometry_origin,
    transform,
)
from mesh_navigation.simulation.surface_robot import SurfaceRobot


class RobotTopics:
    """TF, odometry, the true pose, clouds and markers."""

    def __init__(self, values: Mapping[str, Any]) -> None:
        """
        Args:
            values: parameters of the node.
        """
        self._values = values
        self._tf = tf2_ros.TransformBroadcaster()
        self._static_tf = tf2_ros.StaticTransformBroadcaster()
        self._odometry = rospy.Publisher("odom", Odometry, queue_size=10)
        self._pose = rospy.Publisher("~pose", PoseStamped, queue_size=10)
        self._cloud = rospy.Publisher("cloud", PointCloud2, queue_size=2)
        self._markers = rospy.Publisher("~markers", MarkerArray, queue_size=2, latch=True)
        self._last_stamp = rospy.Time()

    @property
    def cloud_is_wanted(self) -> bool:
        """Whether somebody listens to clouds."""
        return self._cloud.get_num_connections() > 0

    def tell_frames(self) -> None:
        """What of the robot does not move."""
        values, now = self._values, rospy.Time.now()
        chain = ("footprint_frame", "base_frame", "base_height")
        sensor = ("base_frame", "sensor_frame", "sensor_height")
        self._static_tf.sendTransform(
            [
                transform(values[parent], values[child], above(values[height]), now)
                for parent, child, height in (chain, sensor)
                if values[parent] != values[child]
            ]
        )

    def tell(self, robot: SurfaceRobot, stamp: rospy.Time) -> None:
        """Where the robot is; once for each moment."""
        if stamp == self._last_stamp:
            return
        self._last_stamp = stamp
        frame = robot.geometry.frame_id
        odom, footprint = self._values["odom_frame"], self._values["footprint_frame"]
        truth, counted = robot.pose, robot.odometry
        transforms = [transform(odom, footprint, counted, stamp)]
        if self._values["localization"]:
            origin = odometry_origin(truth, counted)
            transforms.append(transform(frame, odom, origin, stamp))
        self._tf.sendTransform(transforms)
        self._odometry.publish(odometry(odom, footprint, counted, robot.velocity, stamp))
        self._pose.publish(pose_message(truth, frame, stamp))

    def sensor_pose(self, pose: Pose) -> Pose:
        """That of the sensor in the map, of a robot with this pose."""
        height = self._values["base_height"] + self._values["sensor_height"]
        return transformed(above(height), pose)

    def tell_cloud(self, scan: LidarScan, stamp: rospy.Time) -> None:
        """A revolution that began then."""
        self._cloud.publish(cloud_message(scan, self._values["sensor_frame"], stamp))

    def tell_markers(self, markers: ObstacleMarkers, frame_id: str) -> None:
        """What is on the map."""
        self._markers.publish(markers.message(frame_id, self._values["base_frame"]))
