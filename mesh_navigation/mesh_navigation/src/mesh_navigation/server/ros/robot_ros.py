"""The robot over TF, odometry and velocity commands."""

import itertools
import threading
from contextlib import contextmanager
from typing import Callable, Dict, Iterator, Optional, Tuple

import rospy
from nav_msgs.msg import Odometry

from mesh_navigation.base.cancellation import Cancellation
from mesh_navigation.base.messages import velocity_of
from mesh_navigation.base.robot import STOP, Robot, RobotLost, RobotState, Trail, Velocity
from mesh_navigation.server.ros.localization_ros import Localization
from mesh_navigation.server.ros.transforms_ros import Transforms
from mesh_navigation.server.ros.velocity_commands_ros import VelocityCommands

# Odometry that is older (s, of ROS time) says nothing about the velocity of now.
ODOMETRY_AGE = 1.0
PERIOD = 0.05  # s, between two commands of who does not say it


class RobotRos(Robot):
    """Poses from TF, velocities from odometry where there is some; who drives, asks `driven`."""

    def __init__(
        self,
        commands: VelocityCommands,
        transforms: Transforms,
        localization: Localization,
        robot_frame: str,
        lost_timeout: float,
        odom_topic: str = "",
    ) -> None:
        """
        Args:
            commands: where velocities go.
            transforms: to ask for the pose.
            localization: without which the robot stands, whatever is commanded.
            robot_frame: the robot's frame in TF.
            lost_timeout: how long to wait for its pose while it drives (s).
            odom_topic: nav_msgs/Odometry, whose twist is in the robot's frame; empty: none.
        """
        self.trail, self.lost_timeout = Trail(), lost_timeout
        self.frame = ""
        """The map's frame; empty as long as there is no map."""
        self._transforms, self._robot_frame = transforms, robot_frame
        self._lock = threading.Lock()
        self._commanded = STOP
        self._odometry: Optional[Tuple[float, Velocity]] = None
        self._commands, self._numbers = commands, itertools.count(1)
        self._moving: Dict[int, float] = {}  # drives that move it now, with their periods
        self._localization = localization
        localization.on_lost(self._halt)
        if odom_topic:
            rospy.Subscriber(odom_topic, Odometry, self._on_odometry, queue_size=1)

    def state(self) -> RobotState:
        if not self.frame:
            raise RobotLost("the robot's pose is not known: there is no map yet")
        pose, stamp = self._transforms.newest(self.frame)
        fault = pose.fault()
        if fault:
            what = f"the robot's pose ('{self._robot_frame}' in '{self.frame}')"
            raise RobotLost(f"{what} is none: {fault}")
        return RobotState(stamp, pose.normalized(), self._velocity(rospy.get_time()))

    @contextmanager
    def driven(
        self, cancellation: Cancellation, period: Callable[[], float] = lambda: PERIOD
    ) -> Iterator[Robot]:
        """The robot for one drive, whose commands count as long as no newer drive moves it.

        Waits until the robot can be driven; the drive is over with the context.

        Args:
            cancellation: ends the waiting.
            period: in which commands come, asked for each (s); a robot that gets none for three of
                them is stopped.
        Raises:
            NotReady: NOT_INITIALIZED, it cannot be driven; or CANCELED.
        """
        self._commands.wait(cancellation)
        number = next(self._numbers)
        try:
            yield _DrivenRobot(self, number, period)
        finally:
            self._moving.pop(number, None)
            self._commands.end(number)

    def drive(self, velocity: Velocity) -> None:
        self.command(0, velocity, PERIOD)

    def command(self, drive: int, velocity: Velocity, period: float) -> None:
        """A command of a drive, by its number; see `VelocityCommands.send`."""
        # During a shutdown nobody drives any more, however late it is.
        if rospy.core.is_shutdown_requested() or not velocity.is_finite:
            velocity = STOP
        # Under the lock: commands leave in the order in which they are noted, and none that moves
        # the robot after the halt.
        with self._lock:
            if velocity != STOP and self._localization.look().lost:
                velocity = STOP
            self._moving.pop(drive, None)
            if velocity != STOP:
                self._moving[drive] = period
            self._commanded = self._commands.send(drive, velocity, period)

    def _halt(self) -> None:
        """Stop it at once: the next cycle of who drives may be far."""
        self.trail.clear()  # of a robot that was not where it was believed to be
        for drive, period in list(self._moving.items()):
            self.command(drive, STOP, period)

    def _velocity(self, now: float) -> Velocity:
        odometry = self._odometry
        if odometry is not None and abs(now - odometry[0]) <= ODOMETRY_AGE:
            return odometry[1]
        return self._commanded

    def _on_odometry(self, message: Odometry) -> None:
        velocity = velocity_of(message.twist.twist)
        if velocity.is_finite:
            self._odometry = rospy.get_time(), velocity


class _DrivenRobot(Robot):
    """The robot of one drive."""

    def __init__(self, robot: RobotRos, number: int, period: Callable[[], float]) -> None:
        self.trail, self.lost_timeout = robot.trail, robot.lost_timeout
        self._robot, self._number, self._period = robot, number, period

    def state(self) -> RobotState:
        return self._robot.state()

    def drive(self, velocity: Velocity) -> None:
        self._robot.command(self._number, velocity, self._period())
