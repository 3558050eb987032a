"""What makes simulated time wait for a robot that is driven."""

import contextlib
import threading
from typing import Dict

import rospy
from std_msgs.msg import Time

from mesh_navigation.base.robot import STOP, Velocity

CLOCK_LIMIT = "/clock_limit"


class ClockLimit:
    """Tells who makes the time of ROS, if that is simulated, when the next command of a drive is
    due: until it comes, time need not go on. From any thread.

    A drive whose last command was a stop holds nothing up.
    """

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._due: Dict[int, float] = {}
        self._simulated = rospy.rostime.is_wallclock() is False
        if self._simulated:
            self._publisher = rospy.Publisher(CLOCK_LIMIT, Time, queue_size=10, latch=True)
            self._tell()  # Whoever had the name before may have held time up.

    def command(self, drive: int, velocity: Velocity, due: float) -> None:
        """A command of a drive, by its number, and when the next one is due (s)."""
        if velocity == STOP:
            self.end(drive)
        elif self._simulated:
            with self._lock:
                self._due[drive] = due
                self._tell()

    def end(self, drive: int) -> None:
        """No more commands of that drive come."""
        with self._lock:
            if self._due.pop(drive, None) is not None:
                self._tell()

    def end_all(self) -> None:
        """No more commands come."""
        for drive in list(self._due):
            self.end(drive)

    def _tell(self) -> None:
        with contextlib.suppress(rospy.ROSException):  # A shutdown closes topics at any moment.
            due = min(self._due.values(), default=0.0)
            self._publisher.publish(Time(rospy.Time.from_sec(due)))
