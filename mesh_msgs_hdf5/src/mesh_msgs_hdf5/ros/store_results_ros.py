"""Says on a topic what became of messages that were sent to be stored."""
import threading
import time
from typing import Any, Optional, Tuple

import rospy
from mesh_msgs.msg import StoreResult

from mesh_msgs.text import one_line

# queue_size of a subscriber whose messages are stored: with a number, rospy drops the oldest of
# what it reads at once, without a word; with None it keeps all, and TCP holds the publisher back
EVERY_MESSAGE = None

_QUEUE = 20000  # one save may store so many layers, attributes and textures
_LASTS = 60.0  # seconds for which a refusal is told on /diagnostics


class StoreResults:
    """The topic store/result of a server. Safe for threads.

    Attributes: refusals (how many there were).
    """

    def __init__(self, topic: str) -> None:
        self._publisher = rospy.Publisher(topic, StoreResult, queue_size=_QUEUE)
        self._lock = threading.Lock()
        self._last: Optional[Tuple[float, str]] = None
        self.refusals = 0

    def stored(self, uuid: str, topic: str, name: str, stamp: rospy.Time) -> None:
        """It is on the disk; stamp: of the message."""
        self._publish(StoreResult.STORED, uuid, topic, name, stamp, "")

    def waiting(self, uuid: str, topic: str, name: str, stamp: rospy.Time, why: str) -> None:
        """It is kept, but cannot be saved now."""
        self._publish(StoreResult.WAITING, uuid, topic, name, stamp, one_line(why))

    def refused(self, uuid: str, topic: str, name: str, stamp: rospy.Time, why: str) -> None:
        """Nothing of it is kept."""
        why = one_line(why)
        with self._lock:
            self.refusals += 1
            self._last = time.monotonic(), "%s refused: %s" % (topic, why)
        self._publish(StoreResult.REFUSED, uuid, topic, name, stamp, why)

    @property
    def last_refusal(self) -> str:
        """The newest one, in words, while it is news; else ""."""
        with self._lock:
            if self._last is None or time.monotonic() > self._last[0] + _LASTS:
                return ""
            return self._last[1]

    def _publish(self, result: int, uuid: str, topic: str, name: str, stamp: Any, text: str):
        message = StoreResult(uuid=uuid, topic=topic, name=name, message_stamp=stamp)
        message.header.stamp, message.result, message.text = rospy.Time.now(), result, text
        try:
            self._publisher.publish(message)
        except rospy.ROSException:  # the node is ending, and its topics are closed already
            pass
