#!/usr/bin/python3
"""simulation.launch rviz:=true: what becomes of clicked goals, and of a server, is seen in RViz."""
import os
import re
import signal
import subprocess
import tempfile
import unittest
from contextlib import ExitStack
from pathlib import Path
from xmlrpc.client import ServerProxy

import numpy as np
import rostest
from mesh_msgs import zoo
from mesh_msgs_hdf5.map_file import MapFile
from mesh_msgs_hdf5.model.mesh import Mesh
from osmesa_harness.back_ends import BackEnd, environment_of
from PIL import ImageGrab

from mesh_tools_test.demo.processes import environment_with_home, free_port, process, wait_until

GOOD, BUSY, BAD = (32, 112, 32), (16, 80, 176), (176, 0, 0)  # texts of the panel
LETHAL = (255, 20, 147)
COMPLAINT = re.compile(r"RViz is left out|rviz.*(WARN|ERROR)|PluginlibFactory|failed to load", re.I)
OUTCOME = re.compile(r"goal \(([-\d., ]+)\) in 'map': (\w+) \(\d+\)")


class RvizSimulation(unittest.TestCase):
    def start(self, *arguments):
        stack = ExitStack()
        self.addCleanup(stack.close)
        folder = Path(stack.enter_context(tempfile.TemporaryDirectory()))
        path = self.write_map(folder / "map.h5")
        port = free_port()
        environment = environment_with_home(
            folder, ROS_MASTER_URI=f"http://127.0.0.1:{port}", ROS_IP="127.0.0.1"
        )
        self.master = ServerProxy(environment["ROS_MASTER_URI"])
        self.environment = stack.enter_context(environment_of(BackEnd.XVFB, environment))
        launch = ["roslaunch", "-p", str(port), "mesh_navigation", "simulation.launch"]
        launch += [f"map_file:={path}", "rviz:=true", "initial_pose:=[-1, 0, 0, 0]", *arguments]
        self.child = stack.enter_context(process("simulation", launch, folder, self.environment))

    @staticmethod
    def write_map(path):
        """Flat ground of 10 m around the origin, with a wall that lethal ground surrounds."""
        mesh = zoo.grid(cells=80, size=10.0)
        vertices = mesh.vertices - np.float32([5, 5, 0])
        wall = (np.abs(vertices[:, 0] - 3.0) < 0.3) & (np.abs(vertices[:, 1]) < 3.0)
        vertices[wall, 2] = 1.5
        return MapFile.write(str(path), Mesh(vertices.astype(np.float32), mesh.faces)).path

    def tearDown(self):
        os.environ.pop("DISPLAY", None)

    def picture(self):
        os.environ["DISPLAY"] = self.environment["DISPLAY"]
        return np.asarray(ImageGrab.grab(xdisplay=None).convert("RGB")).astype(int)

    def count(self, color, panel=True):
        """Pixels of this color, or a tenth off, in the docks at the left or the 3D view."""
        picture = self.picture()
        part = picture[60:, :340] if panel else picture[60:860, 370:]
        return int(np.sum(self.have_color(part, color)))

    @staticmethod
    def have_color(part, color):
        """Also in less light."""
        share = np.clip(part.max(axis=2, keepdims=True) / max(color), 0.6, 1.0)
        return np.all(np.abs(part - share * np.array(color)) < 25, axis=2)

    def wait(self, condition, what, seconds=60):
        wait_until(condition, seconds, what, [self.child])

    def do(self, *arguments):
        command = ["xdotool", *map(str, arguments)]
        subprocess.run(command, env=self.environment, check=True, stdout=subprocess.DEVNULL)

    def pid(self, node):
        """Asked for over XML-RPC, as rosnode does."""
        code, _, uri = self.master.lookupNode("/rviz_simulation", node)
        self.assertEqual(code, 1, node)
        return ServerProxy(uri).getPid("/rviz_simulation")[2]

    def log(self):
        return self.child[2].read_text(encoding="utf-8", errors="replace")

    def click(self, column, row):
        """With the goal tool, by its key; the pose looks to the right."""
        self.do("mousemove", column, row, "sleep", 0.3, "key", "m", "sleep", 0.3)
        self.do("mousedown", 1, "sleep", 0.2, "mousemove", column + 40, row - 4, "sleep", 0.2)
        self.do("mouseup", 1)

    def outcome_of_next(self, column, row):
        before = len(OUTCOME.findall(self.log()))
        self.click(column, row)
        self.wait(lambda: len(OUTCOME.findall(self.log())) > before, "an outcome")
        return OUTCOME.findall(self.log())[-1][1]

    def wait_until_ready(self):
        self.wait(lambda: self.count(LETHAL, panel=False) > 500, "the map with its lethal ground")
        self.wait(lambda: self.count(GOOD) > 30, "a server that is ready")

    def complaints(self):
        return [line for line in self.log().splitlines() if COMPLAINT.search(line)]

    def test_a_goal_from_click_to_outcome_and_a_server_that_hangs_and_dies(self):
        self.start()
        self.wait_until_ready()
        # Beside the middle, where the robot is, the ground is free.
        self.assertEqual(self.outcome_of_next(800, 400), "SUCCESS")
        self.wait(lambda: self.count(GOOD) > 200, "the outcome on the panel")
        blocked = np.argwhere(self.have_color(self.picture()[60:800, 400:1150], LETHAL))
        row, column = blocked[len(blocked) // 2] + (60, 400)
        self.assertLess(self.count(BAD), 30)
        self.assertEqual(self.outcome_of_next(column, row), "INVALID_GOAL")
        self.wait(lambda: self.count(BAD) > 30, "the outcome on the panel")

        server = self.pid("/move_base_flex")
        before = self.count(BAD)
        os.kill(server, signal.SIGSTOP)
        self.wait(lambda: self.count(BAD) > before + 30, "that it does not answer")
        os.kill(server, signal.SIGCONT)
        self.wait(lambda: self.count(BAD) <= before, "that it answers again")
        os.kill(server, signal.SIGKILL)
        self.wait(lambda: self.count(BAD) > before + 30, "that it is gone")
        rviz = self.pid("/mesh_rviz")
        os.kill(rviz, 0)
        self.assertEqual(self.complaints(), [])

    def test_a_server_of_another_name_is_seen_and_gets_the_goals(self):
        self.start("node_name:=robot_2")
        self.wait_until_ready()
        self.assertEqual(self.outcome_of_next(800, 400), "SUCCESS")
        self.wait(lambda: self.count(GOOD) > 200, "the outcome on the panel")
        self.pid("/robot_2")
        self.assertEqual(self.complaints(), [])


if __name__ == "__main__":
    rostest.rosrun("mesh_tools_test", "rviz_simulation", RvizSimulation)
