"""Poses through TF that no cancel has to wait for."""

import time
from typing import Any, Tuple

import rospy
import tf2_ros
from geometry_msgs.msg import Pose as PoseMessage
from geometry_msgs.msg import PoseStamped

from mesh_navigation.base.cancellation import Cancellation
from mesh_navigation.base.messages import pose_from_message
from mesh_navigation.base.outcomes import NotReady
from mesh_navigation.base.pose import Pose, transformed
from mesh_navigation.base.robot import RobotLost

# Between two looks at TF (s).
POLL = 0.02


class Transforms:
    """A listener to TF. All methods may be called from several threads at once."""

    def __init__(self, cache_time: float, timeout: float) -> None:
        """
        Args:
            cache_time: how far TF is remembered (s).
            timeout: how long to wait for a transform, and how old the robot's may be (s).
        """
        self._buffer = tf2_ros.Buffer(rospy.Duration.from_sec(cache_time))
        self._listener = tf2_ros.TransformListener(self._buffer)
        self._timeout = timeout

    def pose_in(
        self, frame: str, message: PoseStamped, what: str, cancellation: Cancellation
    ) -> Pose:
        """A pose in another frame.

        Args:
            frame: the frame wanted.
            message: the pose; its stamp says when, 0 is the latest transform.
            what: "start" or "goal", for messages.
            cancellation: ends the waiting.

        Raises:
            NotReady: TF_ERROR or CANCELED.
        """
        pose = pose_from_message(message.pose)
        source = message.header.frame_id.lstrip("/")
        if not source:
            raise NotReady("TF_ERROR", f"the {what} pose has no frame_id; the map's is '{frame}'")
        if source == frame:
            return pose
        stamp = message.header.stamp
        found = self._lookup(frame, source, stamp, f"the {what} pose", cancellation)
        return transformed(pose, _pose(found))

    def robot_pose(self, frame: str, robot_frame: str, cancellation: Cancellation) -> Pose:
        """Where the robot is, in the given frame.

        Raises:
            NotReady: TF_ERROR, also if its newest transform is older than the timeout; CANCELED.
        """
        found = self._lookup(frame, robot_frame, rospy.Time(), "the robot's pose", cancellation)
        stamp = found.header.stamp
        age = (rospy.Time.now() - stamp).to_sec()
        # A chain of static transforms has the stamp 0 and is always up to date.
        if stamp != rospy.Time() and age > self._timeout:
            raise NotReady(
                "TF_ERROR",
                f"the robot's pose ('{robot_frame}' in '{frame}') is {age:.1f} s old, "
                f"allowed are {self._timeout:.1f} s (tf_timeout)",
            )
        return _pose(found)

    def newest(self, frame: str, source: str) -> Tuple[Pose, float]:
        """The newest pose of a frame in another one, and its time (s, 0: for ever); never waits.

        Raises:
            RobotLost: there is none.
        """
        try:
            found = self._buffer.lookup_transform(frame, source, rospy.Time())
        except tf2_ros.TransformException as error:
            reason = " ".join(str(error).split()).rstrip(". ")
            raise RobotLost(f"no transform from '{source}' to '{frame}': {reason}") from error
        return _pose(found), found.header.stamp.to_sec()

    def _lookup(
        self, frame: str, source: str, stamp: rospy.Time, what: str, cancellation: Cancellation
    ) -> Any:
        deadline = time.monotonic() + self._timeout
        while True:
            try:
                return self._buffer.lookup_transform(frame, source, stamp)
            except tf2_ros.TransformException as error:
                reason = " ".join(str(error).split()).rstrip(". ")
            if time.monotonic() >= deadline:
                raise NotReady(
                    "TF_ERROR",
                    f"no transform for {what} from '{source}' to '{frame}' within "
                    f"{self._timeout:.1f} s (tf_timeout): {reason}",
                )
            cancellation.wait(POLL)
            if cancellation.canceled:
                raise NotReady("CANCELED", f"planning stopped: {cancellation.reason}")


def _pose(found: Any) -> Pose:
    """Of the child in the parent, of a TransformStamped."""
    transform = found.transform
    return pose_from_message(PoseMessage(transform.translation, transform.rotation))
