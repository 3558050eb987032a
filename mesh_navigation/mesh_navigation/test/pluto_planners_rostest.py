#!/usr/bin/python3
"""Configurations of the planners of release 1.x load as they are, and their clients get plans."""

import unittest
from pathlib import Path

import actionlib
import numpy as np
import rospy
import rostest
import tf2_ros
import yaml
from dynamic_reconfigure.client import Client
from geometry_msgs.msg import TransformStamped
from mbf_msgs.msg import GetPathAction, GetPathGoal, GetPathResult
from nav_msgs.msg import Path as PathMessage
from server_process import TIMEOUT, ServerProcess, positions, stamped, wait_until, write_map

from mesh_msgs import zoo

CONFIGURATIONS = yaml.safe_load(
    Path(__file__).with_name("pluto_planners.yaml").read_text(encoding="utf-8")
)
GRID = zoo.grid(cells=20)
START, GOAL = (2.1, 2.2, 0.0), (8.1, 7.3, 0.0)
STRAIGHT = np.hypot(6.0, 5.1)
LAUNCH_PATIENCE = 10.0


def upside_down(position):
    """Turned by half a turn about x, as poses picked on a surface wound upside down are."""
    pose = stamped(position)
    pose.pose.orientation.x, pose.pose.orientation.w = 1.0, 0.0
    return pose


class PlutoPlannersTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.file = write_map(GRID)
        robot = TransformStamped()
        robot.header.frame_id, robot.child_frame_id = "map", "base_footprint"
        translation = robot.transform.translation
        translation.x, translation.y, translation.z = START
        robot.transform.rotation.w = 1.0
        cls.broadcaster = tf2_ros.StaticTransformBroadcaster()
        cls.broadcaster.sendTransform(robot)

    def check(self, dataset):
        """Start the server, plan with each planner, and as the state machine of pluto_robot."""
        if rospy.has_param("/move_base_flex"):
            rospy.delete_param("/move_base_flex")
        given = dict(CONFIGURATIONS[dataset], planner_patience=LAUNCH_PATIENCE)
        layers = [{"name": "height_diff", "type": "mesh_layers/HeightDiffLayer"}]
        mesh_map = {"mesh_file": self.file, "mesh_part": "mesh", "layers": layers}
        server = ServerProcess("move_base_flex", "mbf_mesh_nav", mesh_map=mesh_map, **given)
        self.addCleanup(server.kill)
        names = [planner["name"] for planner in given["planners"]]
        for name in names:
            for ends in ((START, GOAL), (upside_down(START), upside_down(GOAL))):
                state, result = server.ask(*ends, planner=name)
                self.assertEqual((state, result.outcome), ("SUCCEEDED", 0), result.message)
                points = positions(result.path)
                np.testing.assert_allclose(points[[0, -1]], [START, GOAL], atol=1e-5)
                length = np.linalg.norm(np.diff(points, axis=0), axis=1)
                self.assertLess(length.sum(), STRAIGHT * (1.09 if "dij" in name else 1.0001))
            step = given[name].get("step_width", 0.4)
            if "dijkstra" not in name:
                self.assertLess(length.max(), step + 1e-6)
            self.check_values(name, given[name])
            path = rospy.wait_for_message(f"/move_base_flex/{name}/path", PathMessage, 30)
            self.assertEqual(len(path.poses), len(points))
        self.check_values("", {"planner_max_retries": 2, "planner_patience": LAUNCH_PATIENCE})
        self.check_state_machine()
        state, result = server.ask(START, GOAL, planner="dijkstra_planner")
        self.assertEqual((state, result.outcome), ("REJECTED", GetPathResult.INVALID_PLUGIN))
        self.assertEqual(server.stop(), 0)
        for word in ("WARN", "ERROR", "Traceback", "skipped"):
            lines = [line for line in server.output().splitlines() if word in line]
            self.assertEqual([line for line in lines if "dijkstra_planner'" not in line], [])

    def check_values(self, name, given):
        """What dynamic_reconfigure says of a planner, or of the node itself."""
        client = Client(f"/move_base_flex/{name}".rstrip("/"), timeout=30)
        values = client.get_configuration(30)
        client.close()
        for parameter, value in given.items():
            self.assertEqual(values[parameter], value, (name, parameter))

    def check_state_machine(self):
        client = actionlib.SimpleActionClient("move_base_flex/get_path", GetPathAction)
        self.assertTrue(client.wait_for_server(TIMEOUT))
        goal = GetPathGoal(tolerance=0.2, planner="wave_front_planner", use_start_pose=False)
        goal.target_pose = stamped(GOAL)
        wait_until(lambda: client.send_goal_and_wait(goal, TIMEOUT) == 3, "the robot's pose")
        result = client.get_result()
        self.assertEqual(result.outcome, GetPathResult.SUCCESS, result.message)
        np.testing.assert_allclose(positions(result.path)[0], START, atol=1e-5)
        self.assertAlmostEqual(result.cost, STRAIGHT, places=3)


def _test(dataset):
    return lambda self: self.check(dataset)


for _dataset in CONFIGURATIONS:
    setattr(PlutoPlannersTest, f"test_{_dataset}", _test(_dataset))


if __name__ == "__main__":
    rospy.init_node("pluto_planners_test")
    rostest.rosrun("mesh_navigation", "pluto_planners", PlutoPlannersTest)
