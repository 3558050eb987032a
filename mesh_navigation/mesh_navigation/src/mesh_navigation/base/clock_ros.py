"""The time of ROS: of the computer, or of a simulation."""

import rospy
from rospy.rostime import get_rostime_cond

from mesh_navigation.base.cancellation import Cancellation
from mesh_navigation.base.clock import Clock

# Between two looks at the computer's clock (s), which may be set meanwhile.
LOOK = 0.5


class RosClock(Clock):
    """With /use_sim_time, time is what /clock says: waiting wakes with it."""

    def __init__(self) -> None:
        self._simulated = rospy.rostime.is_wallclock() is False

    def now(self) -> float:
        return rospy.get_time()

    def wait_until(self, moment: float, cancellation: Cancellation) -> None:
        begin = self.now()
        if self._simulated:
            self._wait_for_clock(begin, moment, cancellation)
            return
        now = begin
        while begin <= now < moment and not cancellation.wait(min(moment - now, LOOK)):
            now = self.now()

    def _wait_for_clock(self, begin: float, moment: float, cancellation: Cancellation) -> None:
        tick = get_rostime_cond()

        def wake() -> None:
            with tick:
                tick.notify_all()

        with cancellation.calling(wake), tick:
            tick.wait_for(lambda: cancellation.canceled or not begin <= rospy.get_time() < moment)
