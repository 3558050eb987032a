"""An action server whose results are not lost to clients that are just connecting."""

import time
from collections import deque
from typing import Any, Callable, Deque, Dict, List, Tuple

import actionlib
import rospy
from mesh_msgs.init_node import until_shutdown

from mesh_navigation.move_base.sub_goals import SubGoal

KEPT = 5.0  # s, as long as actionlib keeps the status of a goal that has ended
KEPT_RESULTS = 50  # as many as actionlib queues


class ActionServer(actionlib.ActionServer):
    """Sends the results of the last seconds to subscribers that were not connected in time.

    The wait_for_server() of rospy's clients, and of those of roscpp to a server of rospy, returns
    before the server can send them results: the answer to a goal that is answered at once, such as
    a rejected one, would never arrive, and the client wait forever. Who has got a result does not
    get it twice; who knows nothing of the goal ignores it, as clients of actions do.
    """

    def __init__(self, *args: Any, **fields: Any) -> None:
        self.local: Dict[str, SubGoal] = {}
        """Goals of this process that wait for their result, by id."""
        super().__init__(*args, **fields)

    def initialize(self) -> None:
        self._recent: Deque[Tuple[float, Any, List[Any]]] = deque(maxlen=KEPT_RESULTS)
        super().initialize()
        if self.status_timer is not None:
            # That of actionlib ends when a simulated time jumps back.
            self.status_timer.shutdown()
            period = rospy.Duration(1.0 / self.status_frequency)
            self.status_timer = rospy.Timer(period, self.publish_status_async, reset=True)
        # The listener runs in the thread that accepts the connection, after that is in the list of
        # connections: under the lock, a result has either been sent to it, or is sent here.
        self.result_pub.impl.add_subscriber_listener(_Listener(self._catch_up))

    def publish_result(self, status: Any, result: Any) -> None:
        with self.lock:
            message = self.ActionResult(status=status, result=result)
            message.header.stamp = rospy.Time.now()
            waiting = self.local.pop(status.goal_id.id, None)
            if waiting is not None:
                waiting.finish(status.status, result)
            if rospy.is_shutdown():
                return
            self._recent.append((time.monotonic(), message, self._connected()))
            with until_shutdown():
                self.result_pub.publish(message)
            self.publish_status()

    def publish_status(self) -> None:
        with self.lock:
            while self._recent and time.monotonic() - self._recent[0][0] >= KEPT:
                self._recent.popleft()  # Paths are large.
        with until_shutdown():
            super().publish_status()

    def _connected(self) -> List[Any]:
        return list(self.result_pub.impl.connections)

    def _catch_up(self, publish: Callable[[Any], Any]) -> None:
        with self.lock:
            connected = self._connected()
            for _, message, recipients in self._recent:
                if set(connected) - set(recipients):
                    with self.result_pub.impl.publock:
                        publish(message)
                    recipients.extend(connected)


class _Listener(rospy.SubscribeListener):
    def __init__(self, catch_up: Callable[[Callable[[Any], Any]], None]) -> None:
        super().__init__()
        self._catch_up = catch_up

    def peer_subscribe(self, _topic: str, _publish_to_all: Any, publish: Any) -> None:
        self._catch_up(publish)
