#!/usr/bin/python3
"""The launch file with its default configuration."""

import unittest

import actionlib
import numpy as np
import rospy
import rostest
from mbf_msgs.msg import GetPathAction, GetPathGoal, GetPathResult
from mesh_msgs.arrays import MeshVertexCostsStamped
from mesh_msgs.testing import wait_until
from server_process import TIMEOUT, stamped


class LaunchTest(unittest.TestCase):
    def test_a_plan_on_the_floor(self):
        client = actionlib.SimpleActionClient("/move_base_flex/get_path", GetPathAction)
        self.assertTrue(client.wait_for_server(TIMEOUT))
        lengths = []
        for planner in ("dijkstra_mesh_planner", "wave_front_planner", "mmp_planner", ""):
            goal = GetPathGoal(use_start_pose=True, planner=planner)
            goal.start_pose, goal.target_pose = stamped((0.6, 0.6, 0)), stamped((1.4, 1.3, 0))
            client.send_goal_and_wait(goal, TIMEOUT)
            result = client.get_result()
            self.assertEqual(result.outcome, GetPathResult.SUCCESS, result.message)
            self.assertAlmostEqual(result.path.poses[-1].pose.position.x, 1.4, places=6)
            lengths.append(result.cost)
        self.assertAlmostEqual(lengths[2], np.hypot(0.8, 0.7), places=5)
        self.assertEqual(lengths[1], lengths[3])  # the default
        self.assertGreater(lengths[0], 1.01 * lengths[2])

    def test_a_file_with_one_mesh_needs_no_name_of_it(self):
        self.assertEqual(rospy.get_param("/move_base_flex/mesh_map/mesh_part"), "")

    def test_the_layers_of_the_configuration(self):
        types = set()
        rospy.Subscriber(
            "/move_base_flex/mesh_map/vertex_costs",
            MeshVertexCostsStamped,
            lambda message: types.add(message.type),
        )
        wait_until(lambda: {"height_diff", "Combined Costs"} <= types, "costs")


if __name__ == "__main__":
    rospy.init_node("launch_test")
    rostest.rosrun("mesh_navigation", "launch", LaunchTest)
