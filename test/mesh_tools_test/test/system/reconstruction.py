#!/usr/bin/python3
"""From scans to a robot that drives: a world is driven through and scanned in simulation, its scans
are reconstructed by the command, and the server drives on that map, while the robot itself, and
what its sensor sees, are in the true world.
"""
import subprocess
import tempfile
import unittest
from contextlib import ExitStack
from pathlib import Path

import numpy as np
import rospy
import rostest
from geometry_msgs.msg import PoseStamped
from mesh_map.geometry.mesh_geometry import MeshGeometry
from mesh_msgs.outdoor_world import outdoor_world
from mesh_msgs.testing import wait_until
from mesh_msgs_hdf5.map_file import MapFile
from mesh_msgs_hdf5.model.mesh import Mesh
from mesh_navigation import MeshNavigator
from mesh_navigation.base.messages import pose_from_message
from mesh_navigation.base.pose import Pose
from mesh_tools_test.demo.processes import process
from mesh_tools_test.driving import shipped
from mesh_tools_test.driving.oracle import on_the_map
from mesh_tools_test.driving.trips import point
from mesh_tools_test.driving.worlds import DrivingWorld

SERVER, ROBOT = "/move_base_flex", "/surface_robot"
SIZE, FACES, GOALS, VOXEL = 24.0, 40_000, 10, 0.1  # m, of the world; m, of the reconstruction
# Places of the world, and parts of its side, which together see all that can be driven on.
TOUR = ("start", (-0.43, 0.0), "bridge_deck", (0.34, -0.05), (0.44, 0.05), "goal", (0.42, 0.1))
TOUR += ("bridge_deck", "start", "under_bridge")
LIDAR = ("--scans", "100", "--rings", "32", "--columns", "512", "--noise", "0.01")
SLACK = 0.02  # m, that the robot moves until it has stopped
PATIENCE = 240.0  # s of the computer's time, for all drives


class Reconstruction(unittest.TestCase):
    """Ten drives on one map."""

    @classmethod
    def setUpClass(cls):
        cls.stack = ExitStack()
        folder = Path(cls.stack.enter_context(tempfile.TemporaryDirectory()))
        cls.logs, cls.truth, cls.map = folder / "logs", folder / "truth.h5", folder / "map.h5"
        world = outdoor_world(FACES, size=SIZE, trees=False)
        mesh = Mesh(vertices=world.vertices, faces=world.faces, vertex_colors=world.colors)
        MapFile.write(str(cls.truth), mesh)
        cls.start = Pose.at(world.places["start"])
        bag = folder / "drive.bag"
        tour = [",".join("%.3f" % value for value in place) for place in waypoints(world)]
        mesh_tool("record-scans", cls.truth, bag, "--waypoints", *tour, *LIDAR)
        mesh_tool("reconstruct", bag, cls.map, "--voxel_size", VOXEL)

    @classmethod
    def tearDownClass(cls):
        cls.stack.close()

    def start_nodes(self):
        """The server on the reconstruction, the robot in the true world."""
        server = {**shipped.configuration("planners"), **shipped.configuration("controllers")}
        layers = shipped.configuration("simulation_map")
        # Simulated time runs as fast as it can: on a busy machine clouds are late by it.
        layers["obstacles"] = {**layers["obstacles"], "expected_update_rate": 0.0}
        rospy.set_param(SERVER, {**server, "mesh_map": {**layers, "mesh_file": str(self.map)}})
        robot = {"mesh_file": str(self.truth), "publish_clock": True, "real_time_factor": 0.0}
        robot.update(initial_pose=[*map(float, self.start.position), 0.0])
        robot.update(rate=25.0, scan_rate=1.0, scan_columns=180)  # few: time is fast
        rospy.set_param(ROBOT, robot)
        for node, name in (("surface_robot", ROBOT[1:]), ("mbf_mesh_nav", SERVER[1:])):
            command = ["rosrun", "mesh_navigation", node, "__name:=" + name]
            self.stack.enter_context(process(name, command, self.logs))
        rospy.init_node("reconstruction")

    def printed(self):
        """The last lines of the nodes."""
        return "\n".join(log.read_text()[-3000:] for log in sorted(self.logs.glob("*.log")))

    def test_what_the_true_world_reaches_is_reached_on_the_reconstruction(self):
        truth = shipped.shipped_map_of(self.truth)
        goals = reached_goals(truth, self.start)
        self.start_nodes()
        track = []
        rospy.Subscriber(
            ROBOT + "/pose",
            PoseStamped,
            lambda message: track.append(np.concatenate(pose_from_message(message.pose))),
            queue_size=10_000,
        )
        navigator = MeshNavigator(SERVER)
        navigator.wait_until_ready(timeout=PATIENCE)
        wait_until(lambda: track, "the robot's pose")
        tolerance, missed = shipped.server()["dist_tolerance"], []
        for goal in goals:
            yaw = 2.0 * float(np.arctan2(goal.orientation[2], goal.orientation[3]))
            place = [float(value) for value in goal.position]
            result = navigator.go_to(*place, yaw=yaw, timeout=PATIENCE)
            count = len(track)
            wait_until(lambda: len(track) > count + 5, "the robot's pose at the end")
            away = np.linalg.norm(track[-1][:3] - goal.position)
            if not result.succeeded or away > tolerance + SLACK:
                missed.append("%s at %.3f m: %s" % (np.round(place, 2), away, result))
        self.assertEqual(missed, [], self.printed())
        found = on_the_map(np.array(track), truth, truth.planning_costs().costs)
        self.assertLess(found.off_surface, 1e-3)  # it drove in the true world
        self.assertEqual(len(found.blocked), 0)
        self.assertGreater(found.lethal_distance, shipped.radius() - VOXEL)
        places = [self.start.position, *(goal.position for goal in goals)]
        straight = np.linalg.norm(np.diff(places, axis=0), axis=1).sum()
        self.assertGreater(found.length, straight - 2 * GOALS * (tolerance + SLACK))


def mesh_tool(*arguments):
    """As a user calls it; its errors are those of the test."""
    command = ["rosrun", "mesh_msgs_hdf5", "mesh_tool", *map(str, arguments)]
    subprocess.run(command, check=True, timeout=PATIENCE)


def waypoints(world):
    """(x, y, z) m of the tour."""
    index = MeshGeometry(world.vertices, world.faces).spatial_index
    for place in TOUR:
        if isinstance(place, str):
            yield world.places[place]
        else:
            above = [place[0] * SIZE, place[1] * SIZE, 100.0]
            yield index.cast(origin=above, direction=[0.0, 0.0, -1.0]).position


def reached_goals(truth, start):
    """Poses at random to which the shipped planner finds paths in the true world, in an order that
    begins near the start. What surrounds them is a voxel wider than the robot: so much finer than
    voxels no reconstruction knows what is lethal.
    """
    random = np.random.default_rng(0)
    world = DrivingWorld("truth", truth, radius=shipped.radius() + VOXEL)
    planner = shipped.planner(truth, shipped.body(truth))
    goals, ordered = [], []
    while len(goals) < GOALS:
        yaw = float(random.uniform(-np.pi, np.pi))
        goal = Pose.at(point(world, world.faces, random), yaw)
        if planner.make_plan(start, goal).succeeded:
            goals.append(goal)
    here = start
    while goals:
        away = [np.linalg.norm(goal.position - here.position) for goal in goals]
        here = goals.pop(int(np.argmin(away)))
        ordered.append(here)
    return ordered


if __name__ == "__main__":
    rostest.rosrun("mesh_tools_test", "reconstruction", Reconstruction)
