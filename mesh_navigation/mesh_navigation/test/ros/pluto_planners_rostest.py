#!/usr/bin/python3
"""Configurations of release 1.x load as they are; their clients get plans, and the robot drives."""

import unittest
from pathlib import Path

import actionlib
import numpy as np
import rospy
import rostest
import yaml
from dynamic_reconfigure.client import Client
from geometry_msgs.msg import PoseStamped, PoseWithCovarianceStamped
from mbf_msgs.msg import (
    ExePathAction,
    ExePathGoal,
    ExePathResult,
    GetPathAction,
    GetPathGoal,
    GetPathResult,
)
from nav_msgs.msg import Path as PathMessage
from navigation_process import NodeProcess
from server_process import TIMEOUT, ServerProcess, positions, stamped, write_map

from mesh_msgs import zoo
from mesh_msgs.testing import wait_until

CONFIGURATIONS = yaml.safe_load(
    Path(__file__).with_name("pluto_planners.yaml").read_text(encoding="utf-8")
)
GRID = zoo.grid(cells=20)
START, GOAL, NEAR = (2.1, 2.2, 0.0), (8.1, 7.3, 0.0), (2.8, 2.5, 0.0)
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
        cls.robot = NodeProcess(
            "robot", "surface_robot", mesh_file=cls.file, initial_pose=[*START, 0.0], scan_rate=0.0
        )
        cls.put = rospy.Publisher("/initialpose", PoseWithCovarianceStamped, queue_size=1)
        wait_until(cls.put.get_num_connections, "the robot")

    @classmethod
    def tearDownClass(cls):
        cls.robot.kill()

    def put_robot(self):
        """Back to the start."""
        message = PoseWithCovarianceStamped()
        pose = stamped(START)
        message.header, message.pose.pose = pose.header, pose.pose
        self.put.publish(message)

        def there():
            found = rospy.wait_for_message("/robot/pose", PoseStamped, 30).pose.position
            return np.hypot(found.x - START[0], found.y - START[1]) < 1e-3

        wait_until(there, "the robot at the start")

    def check(self, dataset):
        """Start the server, plan with each planner, and as the state machine of pluto_robot."""
        if rospy.has_param("/move_base_flex"):
            rospy.delete_param("/move_base_flex")
        given = dict(CONFIGURATIONS[dataset], planner_patience=LAUNCH_PATIENCE)
        layers = [{"name": "height_diff", "type": "mesh_layers/HeightDiffLayer"}]
        mesh_map = {"mesh_file": self.file, "mesh_part": "mesh", "layers": layers}
        server = ServerProcess("move_base_flex", "mbf_mesh_nav", mesh_map=mesh_map, **given)
        self.addCleanup(server.kill)
        drive = self.begin_drive()
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
        names = ("controller_patience", "controller_max_retries")
        values = {name: given[name] for name in names}
        values.update(planner_max_retries=2, planner_patience=LAUNCH_PATIENCE)
        self.check_values("", values)
        self.check_values("mesh_controller", given["mesh_controller"])
        self.check_drive(drive, given)
        state, result = server.ask(START, GOAL, planner="dijkstra_planner")
        self.assertEqual((state, result.outcome), ("REJECTED", GetPathResult.INVALID_PLUGIN))
        self.assertEqual(server.stop(), 0)
        # A busy computer may make commands late, and the world is coarse: these are no complaints
        # about parameters.
        expected = (
            "is in faces with edges longer",
            "dijkstra_planner'",
            "control cycles ended late",
            "is stopped: ",
            "velocity_guard: ",
        )
        lines = [
            line
            for line in server.output().splitlines()
            if not any(words in line for words in expected)
        ]
        for word in ("WARN", "ERROR", "Traceback", "skipped"):
            self.assertEqual([line for line in lines if word in line], [])

    def check_values(self, name, given):
        """What dynamic_reconfigure says of a planner, or of the node itself."""
        client = Client(f"/move_base_flex/{name}".rstrip("/"), timeout=30)
        values = client.get_configuration(30)
        client.close()
        for parameter, value in given.items():
            self.assertEqual(values[parameter], value, (name, parameter))

    def begin_drive(self):
        """As navigation_sm.py does it: a plan from where the robot is, then the drive.

        Returns the client that waits for its end, while others plan.
        """
        self.put_robot()
        client = actionlib.SimpleActionClient("move_base_flex/get_path", GetPathAction)
        self.assertTrue(client.wait_for_server(TIMEOUT))
        goal = GetPathGoal(tolerance=0.2, planner="wave_front_planner", use_start_pose=False)
        goal.target_pose = stamped(GOAL)
        wait_until(lambda: client.send_goal_and_wait(goal, TIMEOUT) == 3, "the robot's pose")
        result = client.get_result()
        self.assertEqual(result.outcome, GetPathResult.SUCCESS, result.message)
        np.testing.assert_allclose(positions(result.path)[0], START, atol=1e-3)
        self.assertAlmostEqual(result.cost, STRAIGHT, places=2)
        goal.target_pose = stamped(NEAR)
        client.send_goal_and_wait(goal, TIMEOUT)
        driver = actionlib.SimpleActionClient("move_base_flex/exe_path", ExePathAction)
        self.assertTrue(driver.wait_for_server(TIMEOUT))
        drive = ExePathGoal(path=client.get_result().path, controller="mesh_controller")
        driver.send_goal(drive)
        return driver

    def check_drive(self, driver, given):
        """The robot arrives within the tolerances given."""
        self.assertTrue(driver.wait_for_result(TIMEOUT))
        self.assertEqual(driver.get_state(), 3, driver.get_result())
        result = driver.get_result()
        self.assertEqual(result.outcome, ExePathResult.SUCCESS, result.message)
        end = result.final_pose.pose.position
        away = np.hypot(end.x - NEAR[0], end.y - NEAR[1])
        # It rolls a little while the answer is made.
        self.assertLess(away, given["dist_tolerance"] + 0.05)
        self.assertAlmostEqual(result.dist_to_goal, away, places=5)
        self.assertLess(result.angle_to_goal, given["angle_tolerance"] + 0.05)


def _test(dataset):
    return lambda self: self.check(dataset)


for _dataset in CONFIGURATIONS:
    setattr(PlutoPlannersTest, f"test_{_dataset}", _test(_dataset))


if __name__ == "__main__":
    rospy.init_node("pluto_planners_test")
    rostest.rosrun("mesh_navigation", "pluto_planners", PlutoPlannersTest)
