"""Sends goals to an action server and waits for their ends, from any thread.

actionlib's own client loses a goal that is canceled before the server has it (it takes it for
unknown there), and waits forever for a server that has ended.
"""

import itertools
import socket
import threading
import time
import uuid
import xmlrpc.client
from typing import Any, Callable, List, Optional

import rosgraph
import rospy
from actionlib_msgs.msg import GoalID, GoalStatusArray

from mesh_navigation.client.navigation_result import NavigationError

POLL = 0.1  # s
SILENCE = 5.0  # s without a status, then the server is asked whether it is still there
AGAIN = 0.8  # s after which a goal that the server has never known is sent once more
UNKNOWN = 10.0  # s that a server has no such goal before it counts as lost; it keeps them for 5 s
PING = 2.0  # s

OnFeedback = Callable[[Any], None]


class ActionCall:
    """One goal and its end."""

    def __init__(self, caller: "ActionCaller", key: str, on_feedback: Optional[OnFeedback]) -> None:
        self.key = key
        self.state: Optional[int] = None
        """A terminal state of actionlib_msgs/GoalStatus; None before the end."""
        self.result: Any = None
        """The action's result message; None before the end."""
        self.caller = caller
        self._on_feedback = on_feedback
        self._ended = threading.Event()
        self._unknown_since: Optional[float] = None
        self._goal: Any = None  # as long as the server may not have it
        self._sent = 0.0
        self._lost = False

    @property
    def ended(self) -> bool:
        """Whether the result is there."""
        return self._ended.is_set()

    def send(self, goal: Any) -> None:
        """Send the goal. A cancel that came before counts."""
        self._goal, self._sent = goal, time.monotonic()
        self.caller.publish_goal(self.key, goal)

    def cancel(self) -> None:
        """Ask the server to end the goal; its result comes later."""
        if not self.ended:
            self.caller.publish_cancel(self.key)

    def wait(self, timeout: Optional[float] = None) -> bool:
        """Wait for the end; returns False after ``timeout`` seconds (wall time).

        Raises:
            NavigationError: the server has ended, or has lost the goal.
            rospy.ROSInterruptException: this node is shut down.
        """
        end = time.monotonic() + (float("inf") if timeout is None else timeout)
        asked = time.monotonic()
        while not self._ended.wait(max(0.0, min(POLL, end - time.monotonic()))):
            if self.ended:  # while rospy's handler of Ctrl+C interrupted the waiting
                break
            if rospy.is_shutdown():
                raise rospy.ROSInterruptException("this node is shut down")
            now = time.monotonic()
            if now >= end:
                return False
            if self._lost:
                raise NavigationError(
                    f"{self.caller.name}: the server does not know the goal (any more); was it "
                    "started anew?"
                )
            if now - max(self.caller.heard, asked) > SILENCE:
                asked = now
                if not self.caller.server_lives():
                    raise NavigationError(f"{self.caller.name}: the server has ended")
        return True

    def on_status(self, known: List[str]) -> None:
        """Note whether the server knows the goal."""
        now = time.monotonic()
        if self.key in known:
            self._unknown_since = self._goal = None
            return
        if self._unknown_since is None:
            self._unknown_since = now
        elif now - self._unknown_since > UNKNOWN:
            self._lost = True  # found here: without simulated time, statuses stay away, too
        if self._goal is not None and now - self._sent > AGAIN and not self.ended:
            # It went to a server that is no more, before the present one was connected. Servers
            # ignore a goal of an id that they know.
            self.send(self._goal)

    def on_feedback(self, feedback: Any) -> None:
        """Pass feedback on."""
        if self._on_feedback is not None and not self.ended:
            self._on_feedback(feedback)

    def on_result(self, state: int, result: Any) -> None:
        """Note the end; the first one counts."""
        if not self.ended:
            self.state, self.result = state, result
            self._ended.set()


class ActionCaller:
    """A client of one action server."""

    def __init__(self, name: str, action_type: Any) -> None:
        """
        Args:
            name: of the action, such as ``/move_base_flex/get_path``.
            action_type: such as ``mbf_msgs.msg.GetPathAction``.
        """
        self.name = rospy.resolve_name(name)
        self.heard = 0.0
        """When the last status came, by `time.monotonic`."""
        self._server = ""
        self.calls: List[ActionCall] = []
        """Those that somebody waits for."""
        self._lock = threading.Lock()
        self._numbers = itertools.count(1)
        action = action_type()
        self._goal_type = type(action.action_goal)
        result, feedback = type(action.action_result), type(action.action_feedback)
        self.result_type = type(action.action_result.result)
        self._goals = rospy.Publisher(f"{self.name}/goal", self._goal_type, queue_size=10)
        self._cancels = rospy.Publisher(f"{self.name}/cancel", GoalID, queue_size=10)
        topics = (
            ("status", GoalStatusArray, self._on_status),
            ("feedback", feedback, self._on_feedback),
            ("result", result, self._on_result),
        )
        subscribers = [rospy.Subscriber(f"{self.name}/{key}", *rest) for key, *rest in topics]
        self._ends = [self._goals, self._cancels, *subscribers]

    @property
    def has_server(self) -> bool:
        """Whether a server is there, and all its topics are connected."""
        return bool(self.heard) and all(end.get_num_connections() for end in self._ends)

    def call(self, on_feedback: Optional[OnFeedback] = None) -> ActionCall:
        """Get ready for one goal. ``on_feedback`` gets feedback messages, in another thread."""
        key = f"{rospy.get_caller_id()}-{next(self._numbers)}-{uuid.uuid4().hex[:8]}"
        call = ActionCall(self, key, on_feedback)
        with self._lock:
            self.calls = [*self.calls, call]
        return call

    def forget(self, call: ActionCall) -> None:
        """Nobody waits for this goal any longer."""
        with self._lock:
            self.calls = [other for other in self.calls if other is not call]

    def publish_goal(self, key: str, goal: Any) -> None:
        """Send a goal."""
        stamp = rospy.Time.now()
        message = self._goal_type(goal_id=GoalID(stamp=stamp, id=key), goal=goal)
        message.header.stamp = stamp
        self._goals.publish(message)

    def publish_cancel(self, key: str) -> None:
        """Ask the server to end a goal."""
        try:
            self._cancels.publish(GoalID(id=key))
        except rospy.ROSException:  # A shutdown closes topics at any moment.
            if not rospy.core.is_shutdown_requested():
                raise

    def server_lives(self) -> bool:
        """Whether the server's node answers; True also if it takes its time, or is not known."""
        if not self._server:
            return True
        try:
            address = rosgraph.Master(rospy.get_name()).lookupNode(self._server)
        except rosgraph.MasterException:
            return False
        except OSError:  # of roscore
            return True
        try:
            node = xmlrpc.client.ServerProxy(address, transport=_HastyTransport())
            return node.getPid(rospy.get_name())[0] == 1
        except socket.timeout:
            return True
        except (OSError, xmlrpc.client.Error):
            return False

    def _on_status(self, message: GoalStatusArray) -> None:
        self.heard = time.monotonic()
        self._server = message._connection_header["callerid"]
        known = [status.goal_id.id for status in message.status_list]
        for call in self.calls:
            call.on_status(known)

    def _on_feedback(self, message: Any) -> None:
        for call in self.calls:
            if call.key == message.status.goal_id.id:
                call.on_feedback(message.feedback)

    def _on_result(self, message: Any) -> None:
        for call in self.calls:
            if call.key == message.status.goal_id.id:
                call.on_result(message.status.status, message.result)


class _HastyTransport(xmlrpc.client.Transport):
    def make_connection(self, host: Any) -> Any:
        connection = super().make_connection(host)
        connection.timeout = PING
        return connection
