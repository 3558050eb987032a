#!/usr/bin/python3
"""A Move Base Flex server that only pretends: its answers are written by tests.

As a program: a server whose goals never end.
"""

import sys
import threading
import time

import rospy
from geometry_msgs.msg import PoseStamped
from mbf_msgs.msg import (
    ExePathAction,
    ExePathResult,
    GetPathAction,
    GetPathResult,
    MoveBaseAction,
    MoveBaseFeedback,
    MoveBaseResult,
    RecoveryAction,
    RecoveryResult,
)
from mesh_navigation.server.ros.action_server_node import ActionServer
from nav_msgs.msg import Path

KINDS = {
    "get_path": (GetPathAction, GetPathResult),
    "exe_path": (ExePathAction, ExePathResult),
    "recovery": (RecoveryAction, RecoveryResult),
    "move_base": (MoveBaseAction, MoveBaseResult),
}


def path_along(*points, frame="map"):
    """A path through (x, y) points."""
    path = Path()
    path.header.frame_id = frame
    for x, y in points:
        pose = PoseStamped()
        pose.pose.position.x, pose.pose.position.y = x, y
        path.poses.append(pose)
    return path


class FakeServer:
    """All four actions below a name. Goals are kept in ``goals``, by action.

    ``answers`` has functions by action, called with each goal's handle in a thread of its own;
    without one the goal succeeds at once. A goal whose function does not answer stays active until
    it is canceled.
    """

    def __init__(self, name):
        self.goals = {action: [] for action in KINDS}
        self.answers = {}
        self.canceled = []
        self._lock = threading.Lock()
        self._servers = []
        for action, (kind, result) in KINDS.items():
            server = ActionServer(  # no answer is lost to commands that are just connecting
                f"{name}/{action}", kind, self._on_goal(action, result), self._on_cancel, False
            )
            self._servers.append(server)
            server.start()

    def _on_goal(self, action, result):
        def on_goal(handle):
            handle.set_accepted()
            self.goals[action].append(handle)
            answer = self.answers.get(action)
            if answer is None:
                handle.set_succeeded(result(message="well done"))
            else:
                threading.Thread(target=answer, args=(handle,), daemon=True).start()

        return on_goal

    def _on_cancel(self, handle):
        with self._lock:
            self.canceled.append(handle.get_goal_id().id)
        if handle in self.goals["move_base"]:
            handle.set_canceled(MoveBaseResult(outcome=MoveBaseResult.CANCELED, message="stopped"))
        else:
            handle.set_canceled(GetPathResult(outcome=GetPathResult.CANCELED, message="stopped"))


def never(handle):
    """An answer: none; but feedback."""
    handle.publish_feedback(MoveBaseFeedback(dist_to_goal=7.5))


def never_and_lively(handle):
    """The same again and again: the first may come before the client is connected."""
    while True:
        never(handle)
        time.sleep(0.05)


if __name__ == "__main__":
    rospy.init_node("fake", anonymous=True)
    fake = FakeServer(rospy.myargv()[1])
    fake.answers = {"move_base": never_and_lively}
    sys.stdout.write("ready\n")
    sys.stdout.flush()
    rospy.spin()
