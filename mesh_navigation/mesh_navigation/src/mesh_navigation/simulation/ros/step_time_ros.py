"""When the next step of a simulation is due: by the time of ROS, or by one of its own."""

import abc
import time
from typing import Tuple

import rospy
from rosgraph_msgs.msg import Clock as ClockMessage
from std_msgs.msg import Time as TimeMessage

from mesh_navigation.base.cancellation import Cancellation
from mesh_navigation.base.clock_limit_ros import CLOCK_LIMIT
from mesh_navigation.base.clock_ros import RosClock
from mesh_navigation.simulation.time_limits import PATIENCE, TimeLimits

LONGEST = 1.0  # s in one step; a node that stood still does not leap
# s that time may be ahead of a limit, and of steps: who is in time is not waited for, and a
# velocity_guard does not call the server silent.
AHEAD, STEPS_AHEAD = 0.1, 2


class StepTime(abc.ABC):
    """Steps of a simulation."""

    @abc.abstractmethod
    def wait(self, cancellation: Cancellation) -> Tuple[float, rospy.Time]:
        """Sleep until the next step is due: how many seconds it has, and the time at its end."""

    def tell(self) -> None:
        """All about this step was published."""


class RosStepTime(StepTime):
    """Follows the time of ROS, simulated by others or not."""

    def __init__(self, rate: float) -> None:
        self._clock, self._period = RosClock(), 1 / rate
        self._last = rospy.get_time()
        if not self._last:
            rospy.loginfo("%s: waiting for /clock (use_sim_time is set)", rospy.get_name())

    def wait(self, cancellation: Cancellation) -> Tuple[float, rospy.Time]:
        self._clock.wait_until(self._last + self._period, cancellation)
        now = rospy.get_time()
        # Time that begins, or jumps back, makes no step.
        seconds = now - self._last if self._last else 0.0
        self._last = now
        return max(0.0, min(seconds, LONGEST)), rospy.Time.from_sec(now)


class Pacing:
    """Says how long to sleep. A simulation that fell behind is not rushed to catch up."""

    MAX_DELAY = 0.1  # s that may be caught up

    def __init__(self, factor: float, wall: float) -> None:
        """
        Args:
            factor: simulated s in each s; 0: as many as possible.
            wall: the computer's time (s).
        """
        if not factor >= 0:
            raise ValueError(f"the real time factor is {factor}, but has to be >= 0")
        self._factor = factor
        self._due = wall

    def pause(self, step: float, wall: float) -> float:
        """How long to sleep (s) after a step of the simulation (s) that ended at this time."""
        if self._factor == 0:
            return 0.0
        self._due = max(self._due + step / self._factor, wall - self.MAX_DELAY)
        return max(0.0, self._due - wall)


class OwnStepTime(StepTime):
    """Makes the time and publishes it on /clock. It begins with that of the computer.

    It waits for those who tell on /clock_limit how far it may go on.
    """

    def __init__(self, rate: float, real_time_factor: float) -> None:
        self._step = 1 / rate
        self._pacing = Pacing(real_time_factor, time.monotonic())
        self._begin, self._count = rospy.Time.from_sec(time.time()), 0
        self._publisher = rospy.Publisher("/clock", ClockMessage, queue_size=10)
        self._ahead, self._limits = max(AHEAD, STEPS_AHEAD * self._step), TimeLimits()
        rospy.Subscriber(CLOCK_LIMIT, TimeMessage, self._on_limit, tcp_nodelay=True)
        self.tell()

    def wait(self, cancellation: Cancellation) -> Tuple[float, rospy.Time]:
        cancellation.wait(self._pacing.pause(self._step, time.monotonic()))
        self._count += 1
        now = self._now()
        for name in self._limits.wait(now.to_sec() - self._ahead, cancellation):
            text = "%s: time goes on without %s, which did not keep up for %.0f s"
            rospy.logwarn(text, rospy.get_name(), name, PATIENCE)
        return self._step, now

    def tell(self) -> None:
        # After all else, so that who wakes with the clock sees the robot as it is then.
        self._publisher.publish(ClockMessage(self._now()))

    def _on_limit(self, message: TimeMessage) -> None:
        self._limits.tell(message._connection_header["callerid"], message.data.to_sec())

    def _now(self) -> rospy.Time:
        return self._begin + rospy.Duration.from_sec(self._count * self._step)


def step_time(rate: float, publish_clock: bool, real_time_factor: float) -> StepTime:
    """The time that the parameters ask for; warns where they do not fit together."""
    if publish_clock:
        if not rospy.get_param("/use_sim_time", False):
            rospy.logwarn(
                "%s: publish_clock is set, but use_sim_time is not: other nodes do not follow "
                "/clock; rosparam set use_sim_time true before they start",
                rospy.get_name(),
            )
        return OwnStepTime(rate, real_time_factor)
    if real_time_factor != 1.0:
        rospy.logwarn(
            "%s: real_time_factor %g has no effect without publish_clock",
            rospy.get_name(),
            real_time_factor,
        )
    return RosStepTime(rate)
