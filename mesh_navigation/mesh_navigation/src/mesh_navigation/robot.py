"""The robot as controllers and recovery behaviors see it: poses come in, velocities go out."""

import abc
import math
from typing import NamedTuple

from mesh_navigation.pose import Pose
from mesh_navigation.trail import Trail


class Velocity(NamedTuple):
    """Of the robot, in its own frame."""

    x: float = 0.0
    """Ahead (m/s)."""
    y: float = 0.0
    """To the left (m/s)."""
    yaw: float = 0.0
    """To the left (rad/s)."""

    @property
    def is_finite(self) -> bool:
        """Whether it may be sent."""
        return all(map(math.isfinite, self))


STOP = Velocity()


class RobotState(NamedTuple):
    """The robot at one moment."""

    time: float
    """Of the clock of the execution (s)."""
    pose: Pose
    """In the map's frame, with a unit quaternion; all numbers are finite."""
    velocity: Velocity
    """Measured where there is odometry, else what was commanded last."""


class RobotLost(Exception):
    """The robot's pose is not known; the message says why, with numbers."""


class Robot(abc.ABC):
    """One robot. Methods may be called from any thread and return at once."""

    trail: Trail
    """Where it has been; those that drive it add to it."""

    @abc.abstractmethod
    def state(self) -> RobotState:
        """The newest pose.

        Raises:
            RobotLost: there is none, it is too old, or it is not finite.
        """

    @abc.abstractmethod
    def drive(self, velocity: Velocity) -> None:
        """Command a velocity, which holds until the next one. What is not finite becomes `STOP`."""
