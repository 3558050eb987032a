#!/usr/bin/python3
"""The launch file: a server that loads both by name, and a robot that they drive."""

import math
import os
import shutil
import signal
import subprocess
import tempfile
import unittest

import rospy
import rostest
from mbf_msgs.msg import GetPathResult
from mesh_msgs import zoo
from mesh_msgs_hdf5.map_file import MapFile
from mesh_msgs_hdf5.model.mesh import Mesh
from mesh_navigation import MeshNavigator

WAIT = 120.0  # seconds; far more than anything takes
PLANNER, CONTROLLER = "straight_planner", "pure_pursuit_controller"


class ExampleNavigationTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        folder = tempfile.mkdtemp()
        cls.addClassCleanup(shutil.rmtree, folder)
        path = os.path.join(folder, "map.h5")
        mesh = zoo.hole(cells=18, size=9.0)
        MapFile.write(path, Mesh(mesh.vertices, mesh.faces))
        launch = ["roslaunch", "example_mesh_navigation", "example_navigation.launch"]
        launch += ["map_file:=" + path, "initial_pose:=[1.5, 1.5, 0.0, 1.5]", "real_time_factor:=5"]
        process = subprocess.Popen(launch)
        cls.addClassCleanup(process.wait, WAIT)
        cls.addClassCleanup(process.send_signal, signal.SIGINT)
        cls.navigator = MeshNavigator()
        cls.navigator.wait_until_ready(timeout=WAIT)

    def test_a_goal_is_reached(self):
        result = self.navigator.go_to(
            7.0, 1.5, 0.0, yaw=1.5, planner=PLANNER, controller=CONTROLLER, timeout=WAIT
        )
        self.assertTrue(result.succeeded, result)
        place = result.details.final_pose.pose.position
        self.assertLess(math.hypot(place.x - 7.0, place.y - 1.5), 0.25)

    def test_plans(self):
        there = self.navigator.get_path(7.0, 2.0, 0.0, planner=PLANNER)
        self.assertTrue(there.succeeded and there.message.startswith("straight path of"), there)
        behind = self.navigator.get_path(
            7.5, 4.5, 0.0, planner=PLANNER, start=(1.5, 4.5, 0.0), timeout=WAIT
        )
        self.assertEqual(behind.outcome, GetPathResult.NO_PATH_FOUND, behind)
        self.assertIn("is blocked after", behind.message)
        self.assertRegex(behind.message, "the ground there is lethal in layers? border")

    def test_they_are_those_of_this_package(self):
        for kind, name in (("planners", PLANNER), ("controllers", CONTROLLER)):
            (found,) = [
                each["type"]
                for each in rospy.get_param("/move_base_flex/" + kind)
                if each["name"] == name
            ]
            self.assertTrue(found.startswith("example_mesh_navigation/"))


if __name__ == "__main__":
    rospy.init_node("example_navigation_check")
    rostest.rosrun("example_mesh_navigation", "example_navigation", ExampleNavigationTest)
