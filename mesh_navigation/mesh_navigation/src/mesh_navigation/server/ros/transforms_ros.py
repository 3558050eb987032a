"""Poses through TF that no cancel has to wait for."""

import time
from typing import Any, Callable, Tuple, TypeVar

import rospy
import tf2_ros
from geometry_msgs.msg import Pose as PoseMessage
from geometry_msgs.msg import PoseStamped

from mesh_navigation.base.cancellation import Cancellation
from mesh_navigation.base.messages import pose_from_message
from mesh_navigation.base.outcomes import NotReady
from mesh_navigation.base.pose import Pose, transformed
from mesh_navigation.base.robot import NotLocalized, RobotLost
from mesh_navigation.server.robot_chain import AgeLimits, robot_chain, robot_time
from mesh_navigation.server.ros.localization_ros import Localization

# Between two looks at TF (s).
POLL = 0.02

_T = TypeVar("_T")


class Transforms:
    """A listener to TF. All methods may be called from several threads at once."""

    def __init__(
        self,
        cache_time: float,
        timeout: float,
        limits: AgeLimits,
        robot_frame: str,
        localization: Localization,
    ) -> None:
        """
        Args:
            cache_time: how far TF is remembered (s).
            timeout: how long to wait for a transform (s).
            limits: how old those of the robot may be.
            robot_frame: the robot's frame.
            localization: whether the link to the map can be believed.
        """
        self._buffer = tf2_ros.Buffer(rospy.Duration.from_sec(cache_time))
        self._listener = tf2_ros.TransformListener(self._buffer)
        self._timeout, self._limits = timeout, limits
        self._robot_frame, self._localization = robot_frame, localization

    def pose_in(
        self,
        frame: str,
        message: PoseStamped,
        what: str,
        cancellation: Cancellation,
        patient: bool = True,
    ) -> Pose:
        """A pose in another frame.

        Args:
            frame: the frame wanted.
            message: the pose; its stamp says when, 0 is the latest transform.
            what: "start" or "goal", for messages.
            cancellation: ends the waiting.
            patient: where it depends on where the robot is, wait for localization as long as drives
                do; else as long as for a transform.

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

        def look() -> Any:
            found = self._buffer.lookup_transform(frame, source, stamp)
            chain = robot_chain(self._buffer.all_frames_as_yaml(), source, frame)
            if {self._limits.odom_frame, self._robot_frame}.intersection(chain[:-1]):
                self._localization.check()
            return found

        found = self._awaited(
            look,
            f"no transform for the {what} pose from '{source}' to '{frame}'",
            cancellation,
            patient,
        )
        return transformed(pose, _pose(found))

    def robot_pose(self, frame: str, cancellation: Cancellation, patient: bool = True) -> Pose:
        """Where the robot is, in the given frame; waits for a pose that is not too old, and for
        localization, as `pose_in` does.

        Raises:
            NotReady: TF_ERROR or CANCELED.
        """
        missing = self._no_pose(frame)
        return self._awaited(lambda: self.newest(frame)[0], missing, cancellation, patient)

    def wait_until_localized(self, frame: str, cancellation: Cancellation) -> None:
        """Before anything else is waited for that a robot without localization does not have, as
        what its sensors see.

        Raises:
            NotReady: TF_ERROR or CANCELED.
        """
        self._awaited(self._localization.check, self._no_pose(frame), cancellation, True)

    def _no_pose(self, frame: str) -> str:
        return f"no pose of the robot ('{self._robot_frame}' in '{frame}')"

    def newest(self, frame: str) -> Tuple[Pose, float]:
        """The robot's newest pose in a frame, and its time (s); never waits.

        It is made of the newest transform of each link: a localizer that is slower than odometry
        does not hold it back.

        Raises:
            RobotLost: there is none, or a link of it is older than its limit.
            NotLocalized: the robot is not localized any more.
        """
        self._localization.check()
        frames = robot_chain(self._buffer.all_frames_as_yaml(), self._robot_frame, frame)
        pose, stamps = Pose.at((0.0, 0.0, 0.0)), []
        for child, parent in zip(frames, frames[1:]):
            try:
                found = self._buffer.lookup_transform(parent, child, rospy.Time())
            except tf2_ros.TransformException as error:
                text = f"no transform from '{child}' to '{parent}': {_reason(error)}"
                raise RobotLost(text) from error
            pose = transformed(pose, _pose(found))
            stamps.append(found.header.stamp.to_sec())
        return pose, robot_time(frames, stamps, rospy.get_time(), self._limits)

    def _awaited(
        self, look: Callable[[], _T], missing: str, cancellation: Cancellation, patient: bool
    ) -> _T:
        """What ``look`` finds, as soon as it does."""
        begin = since = time.monotonic()
        told = False
        while True:
            try:
                return look()
            except (tf2_ros.TransformException, RobotLost) as error:
                reason = _reason(error)
                limit, waited = self._timeout, time.monotonic() - since
                text = f"{missing} within {limit:.1f} s (tf_timeout): {reason}"
                if patient and isinstance(error, NotLocalized):
                    limit, waited = error.patience, time.monotonic() - begin
                    text = f"{missing} within {limit:.1f} s (localization_patience): {reason}"
                    since = time.monotonic()
                    if not told:
                        told = True
                        rospy.logwarn("%s yet, which is waited for: %s", missing, reason)
            if waited >= limit:
                raise NotReady("TF_ERROR", text)
            cancellation.wait(POLL)
            if cancellation.canceled:
                raise NotReady("CANCELED", f"planning stopped: {cancellation.reason}")


def _reason(error: Exception) -> str:
    """What it says, as the end of a sentence."""
    return " ".join(str(error).split()).rstrip(". ")


def _pose(found: Any) -> Pose:
    """Of the child in the parent, of a TransformStamped."""
    transform = found.transform
    return pose_from_message(PoseMessage(transform.translation, transform.rotation))
