#!/usr/bin/python3
"""The server ends when it is told to, whatever a plugin does."""

import signal
import unittest

import rospy
import rostest
from server_process import ServerProcess, pid_of, write_map

from mesh_map.base.end_watch import END_SECONDS
from mesh_map.ros.node_end import SHUTDOWN_TIMEOUT
from mesh_msgs import zoo
from mesh_msgs.testing import process_has_ended, wait_until

SIGNALS = (signal.SIGINT, signal.SIGTERM)
HOURS = 3600.0  # s


class ServerEndTest(unittest.TestCase):
    def start(self, kind, number, shutdown_timeout):
        """A server while its planner, which does not listen, is at work; and its guard."""
        name = f"{kind.lower()}_{number}"
        server = ServerProcess(
            name,
            planners=[{"name": "planner", "type": f"odd/{kind}"}],
            planner={"seconds": HOURS},
            mesh_map={"mesh_file": write_map(zoo.grid())},
            planner_patience=0.0,
            shutdown_timeout=shutdown_timeout,
        )
        self.addCleanup(server.kill)
        guard = wait_until(lambda: pid_of(f"/{name}_velocity_guard"), "the guard")
        server.send((2.0, 2.0, 0.0))
        wait_until(lambda: "the planner is at work" in server.output(), "the plan")
        return server, guard

    def test_a_planner_that_holds_pythons_lock(self):
        for number in SIGNALS:
            server, guard = self.start("Holding", number, shutdown_timeout=None)
            server.terminate(number)
            self.assertEqual(server.wait(), 128 + number, server.output())
            self.assertIn(f"s from its end on signal {number}", server.output())
            wait_until(lambda: process_has_ended(guard), "the guard's end")

    def test_a_planner_that_hangs(self):
        """It keeps nobody, whatever the limit is."""
        for number in SIGNALS:
            server, guard = self.start("Deaf", number, shutdown_timeout=HOURS)
            server.terminate(number)
            self.assertEqual(server.wait(), 0, server.output())
            wait_until(lambda: process_has_ended(guard), "the guard's end")

    def test_how_long_it_has(self):
        """As it is promised; how long it takes, a busy machine decides."""
        self.assertEqual(SHUTDOWN_TIMEOUT.default, END_SECONDS)
        self.assertLess(END_SECONDS, 3.0)


if __name__ == "__main__":
    rospy.init_node("server_end_rostest")
    rostest.rosrun("mesh_navigation", "server_end", ServerEndTest)
