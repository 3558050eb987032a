#!/usr/bin/python3
"""The status of an action under a simulated clock that jumps back."""

import threading
import time
import unittest

import rospy
import rostest
from actionlib_msgs.msg import GoalStatusArray
from mbf_msgs.msg import ExePathAction
from mesh_msgs.testing import wait_until
from rosgraph_msgs.msg import Clock

from mesh_navigation.server.ros.action_server_node import ActionServer


class StatusTest(unittest.TestCase):
    def setUp(self):
        self.time, self.heard = 100.0, []
        self.clock = rospy.Publisher("/clock", Clock, queue_size=10)
        threading.Thread(target=self.tick, daemon=True).start()
        wait_until(lambda: rospy.get_time() > 100.0, "the simulated time")

    def tick(self):
        while not rospy.is_shutdown():
            self.time += 0.02
            self.clock.publish(Clock(rospy.Time.from_sec(self.time)))
            time.sleep(0.01)

    def test_it_goes_on(self):
        rospy.Subscriber("/action/status", GoalStatusArray, self.heard.append)
        server = ActionServer("/action", ExePathAction, lambda handle: None, auto_start=False)
        server.start()
        wait_until(lambda: len(self.heard) > 3, "status")
        self.time = 10.0
        wait_until(lambda: rospy.get_time() < 50.0, "the time of before")
        self.heard.clear()
        wait_until(lambda: len(self.heard) > 3, "status after the jump", 20)


if __name__ == "__main__":
    rospy.init_node("status_test")
    rostest.rosrun("mesh_navigation", "status", StatusTest)
