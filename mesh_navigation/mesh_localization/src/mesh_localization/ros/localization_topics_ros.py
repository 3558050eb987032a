"""All that the node publishes about where the robot is."""

import time
from typing import Any, Tuple

import numpy as np
import rospy
import tf2_ros
from geometry_msgs.msg import PoseWithCovarianceStamped
from mesh_map.registration.rigid import inverse, moved
from mesh_msgs.msg import LocalizationState
from sensor_msgs.msg import PointCloud2

from mesh_localization.node.messages import (
    cloud_message,
    matched_cloud,
    pose_message,
    state_message,
    transform_message,
)
from mesh_localization.node.session import Report
from mesh_localization.node.through_counts import ThroughCounts
from mesh_localization.sensing.placed_scan import PlacedScan
from mesh_localization.tracking.ray_fates import RayFate

_STATE_PERIOD = 0.5  # s between two messages of the state, by the time of ROS and by the computer's
_THROUGH_PERIOD = 2.0  # s
_BUFFER = 2  # messages that wait for slow subscribers


class LocalizationTopics:
    """TF, the pose, the state and clouds. For one thread."""

    def __init__(self, odom_frame: str) -> None:
        """
        Args:
            odom_frame: of the odometry.
        """
        self._odom = odom_frame.lstrip("/")
        self._tf = tf2_ros.TransformBroadcaster()
        self._state = rospy.Publisher("~state", LocalizationState, queue_size=_BUFFER, latch=True)
        self._pose = rospy.Publisher("~pose", PoseWithCovarianceStamped, queue_size=_BUFFER)
        self._matched = rospy.Publisher("~scan_matched", PointCloud2, queue_size=_BUFFER)
        self._unexplained = rospy.Publisher("~unexplained", PointCloud2, queue_size=_BUFFER)
        self._through = rospy.Publisher("~through", PointCloud2, queue_size=_BUFFER, latch=True)
        self._stamp = rospy.Time()  # of the last transform
        self._told: Tuple[Any, ...] = ()
        self._told_at = self._told_wall = self._through_at = -np.inf
        self._through_changes = 0

    def begin_anew(self) -> None:
        """Time has jumped back."""
        self._stamp = rospy.Time()
        self._told, self._told_at, self._through_at = (), -np.inf, -np.inf

    def tell_correction(self, report: Report, map_frame: str, stamp: rospy.Time) -> None:
        """Where the odometry's frame is in the map, of a stamp; once for each."""
        if report.estimate is not None and stamp > self._stamp:
            self._stamp = stamp
            correction = report.estimate.correction
            self._tf.sendTransform(transform_message(map_frame, self._odom, correction, stamp))

    def tell_state(self, report: Report, map_frame: str, now: rospy.Time) -> None:
        """The state: at once where it is another one, and repeated."""
        told, seconds, wall = (report.state, report.reason), now.to_sec(), time.monotonic()
        changed = self._told != told
        if (
            changed
            or seconds >= self._told_at + _STATE_PERIOD
            or wall >= self._told_wall + _STATE_PERIOD
        ):
            self._told, self._told_at, self._told_wall = told, seconds, wall
            stamp = now if report.estimate is None else rospy.Time.from_sec(report.estimate.time)
            self._state.publish(state_message(report, map_frame, stamp))

    def tell_scan(self, report: Report, scan: PlacedScan, map_frame: str) -> None:
        """The pose at the time of a scan, and what became of its rays."""
        estimate = report.estimate
        if estimate is None or estimate.fates is None:
            return
        stamp = scan.stamp
        if report.is_known:
            self._pose.publish(pose_message(estimate, map_frame, stamp))
            if self._unexplained.get_num_connections():
                before = estimate.fates.fates == RayFate.BEFORE
                points = moved(inverse(scan.sensor), scan.scan.points[before])
                self._unexplained.publish(cloud_message(points, {}, scan.frame, stamp))
        if self._matched.get_num_connections():
            cloud = matched_cloud(scan.scan.points, estimate, map_frame, stamp)
            self._matched.publish(cloud)

    def tell_through(self, counts: ThroughCounts, map_frame: str, now: rospy.Time) -> None:
        """Where rays went through the map, if that has changed; seldom."""
        seconds = now.to_sec()
        if counts.changes != self._through_changes and (
            seconds >= self._through_at + _THROUGH_PERIOD
        ):
            self._through_changes, self._through_at = counts.changes, seconds
            places, numbers = counts.cells()
            more = {"count": np.minimum(numbers, 2**32 - 1).astype("<u4")}
            self._through.publish(cloud_message(places, more, map_frame, now))
