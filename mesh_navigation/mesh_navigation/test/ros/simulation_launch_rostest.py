#!/usr/bin/python3
"""The launch file of the simulation: a click in RViz drives the robot."""

import math
import unittest

import rospy
import rostest
from geometry_msgs.msg import PoseStamped
from mbf_msgs.msg import MoveBaseActionResult, MoveBaseResult
from mesh_msgs.testing import wait_until
from rosgraph_msgs.msg import Clock
from server_process import stamped

GOAL = (1.4, 1.3, 0.0)


class SimulationLaunchTest(unittest.TestCase):
    def test_a_goal_that_is_clicked(self):
        results, poses = [], []
        rospy.Subscriber("/move_base_flex/move_base/result", MoveBaseActionResult, results.append)
        rospy.Subscriber("/surface_robot/pose", PoseStamped, poses.append)
        click = rospy.Publisher("/goal", PoseStamped, queue_size=1)
        wait_until(click.get_num_connections, "the bridge")
        wait_until(lambda: poses, "the robot")
        goal = stamped(GOAL)
        goal.pose.orientation.z = goal.pose.orientation.w = math.sqrt(0.5)

        def arrived():
            if not results:
                click.publish(goal)  # dropped as long as the bridge has no server
                rospy.rostime.wallsleep(0.5)
            return results and results[-1].result.outcome == MoveBaseResult.SUCCESS

        # Each click replaces the goal before.
        wait_until(arrived, "the arrival")
        end = poses[-1].pose
        self.assertLess(math.hypot(end.position.x - GOAL[0], end.position.y - GOAL[1]), 0.25)
        yaw = 2 * math.atan2(end.orientation.z, end.orientation.w)
        self.assertLess(abs(yaw - math.pi / 2), 0.25)

    def test_time_is_simulated(self):
        self.assertTrue(rospy.get_param("/use_sim_time"))
        first = rospy.wait_for_message("/clock", Clock, 30).clock
        wait_until(lambda: rospy.Time.now() > first, "time")


if __name__ == "__main__":
    rospy.init_node("simulation_launch_test")
    rostest.rosrun("mesh_navigation", "simulation_launch", SimulationLaunchTest)
