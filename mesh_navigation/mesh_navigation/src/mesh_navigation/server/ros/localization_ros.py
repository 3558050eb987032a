"""What localizers say on a topic, and what the server makes of it."""

import math
import threading
from typing import Callable, List, Optional

import rospy
from mesh_msgs.msg import LocalizationState

from mesh_navigation.base.robot import NotLocalized, RobotLost
from mesh_navigation.server.localization_watch import Localized, LocalizationWatch

# Between two looks (s, of the computer's time), where nothing comes.
LOOK = 0.05


class Localization:
    """Whether the robot's pose can be believed. All methods may be called from any thread."""

    def __init__(self, topic: str, timeout: float, patience: float) -> None:
        """
        Args:
            topic: of LocalizationState; empty: nobody says anything, poses are believed.
            timeout: who is silent for longer does not know where the robot is (s of ROS time).
            patience: how long drives wait for one that knows again (s), 0: without end.
        """
        self._patience = patience or math.inf
        self._watch: Optional[LocalizationWatch] = None
        self._on_lost: List[Callable[[], None]] = []
        if topic:
            name = rospy.resolve_name(topic)
            self._watch = LocalizationWatch(name, timeout)
            self._heard = threading.Event()
            rospy.Subscriber(name, LocalizationState, self._hear, queue_size=100, tcp_nodelay=True)
            threading.Thread(target=self._look_on, name="localization", daemon=True).start()

    def on_lost(self, callback: Callable[[], None]) -> None:
        """Call it, in a thread of its own, as soon as the robot is not localized any more."""
        self._on_lost.append(callback)

    def look(self) -> Localized:
        """How well the robot is localized now."""
        if self._watch is None:
            return Localized("", "", True, 0)
        return self._watch.look(rospy.get_time())

    def times(self) -> Optional[int]:
        """How often it was localized again after it was not; None while it is not."""
        found = self.look()
        return None if found.lost else found.times

    def check(self) -> None:
        """Returns where the robot is localized.

        Raises:
            NotLocalized: it is not any more.
            RobotLost: it has never been, since nobody has ever said anything.
        """
        found = self.look()
        if found.lost:
            raise NotLocalized(found.lost, self._patience) if found.has_spoken else RobotLost(
                found.lost
            )

    def _hear(self, message: LocalizationState) -> None:
        assert self._watch is not None
        speaker = message._connection_header["callerid"]
        stamp, now = message.header.stamp.to_sec(), rospy.get_time()
        self._watch.hear(speaker, message.state, message.reason, stamp, now)
        self._heard.set()

    def _look_on(self) -> None:
        localized = 0  # how often it was when that was told
        told = 0  # how often it was localized when its loss was told; at first that is no news
        while not rospy.core.is_shutdown_requested():
            self._heard.wait(LOOK)
            self._heard.clear()
            found = self.look()
            if found.lost and found.times > told:
                told = found.times  # also where it was localized for a moment between two looks
                for callback in self._on_lost:
                    callback()
                rospy.logwarn("%s; the robot stands until it is", found.lost)
            elif not found.lost and found.times > localized:
                localized = found.times
                rospy.loginfo("the robot is localized")
