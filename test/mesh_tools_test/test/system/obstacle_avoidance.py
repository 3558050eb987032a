#!/usr/bin/python3
"""The whole loop: a simulated robot with a sensor, the server, and a column put in its way.

What stands there is in no map: the robot sees it, the obstacle layer marks it, the server plans
around it while the robot drives.
"""
import tempfile
import threading
import unittest
from contextlib import ExitStack
from pathlib import Path

import actionlib
import numpy as np
import rospy
import rostest
from geometry_msgs.msg import PoseStamped
from mbf_msgs.msg import MoveBaseAction, MoveBaseGoal, MoveBaseResult
from mesh_msgs.testing import wait_until
from mesh_msgs_hdf5.map_file import MapFile
from mesh_msgs_hdf5.model.mesh import Mesh
from mesh_tools_test.demo.processes import process
from mesh_tools_test.driving.obstacles import column, distance, hall_layers, hall_mesh
from nav_msgs.msg import Odometry, Path as PathMessage
from visualization_msgs.msg import Marker, MarkerArray

SERVER = "/move_base_flex"
START, GOAL = (2.0, 6.0, 0.0), (10.0, 6.0, 0.0)
DROP_AT, PLACE = 3.5, (6.5, 6.1)  # m: where the robot then is, and where the column is put
PATIENCE = 120.0  # s of the computer's time


def marker_of(obstacle):
    """An obstacle as what the simulated robot listens to."""
    marker = Marker(type=Marker.CYLINDER, action=Marker.ADD, ns="test", id=1)
    marker.header.frame_id = "map"
    position = marker.pose.position
    position.x, position.y, position.z = obstacle.pose.position
    marker.pose.orientation.w = 1.0
    marker.scale.x, marker.scale.y, marker.scale.z = obstacle.size
    return marker


class ObstacleAvoidance(unittest.TestCase):
    """One drive through a hall."""

    @classmethod
    def setUpClass(cls):
        cls.stack = ExitStack()
        folder = Path(cls.stack.enter_context(tempfile.TemporaryDirectory()))
        mesh, cls.file = hall_mesh(), folder / "hall.h5"
        MapFile.write(str(cls.file), Mesh(vertices=mesh.vertices, faces=mesh.faces))
        cls.logs = folder / "logs"
        layers = hall_layers()
        layers[0]["params"]["topic"] = "/cloud"
        configuration = {entry["name"]: entry["params"] for entry in layers}
        configuration["layers"] = [
            {key: entry[key] for key in ("name", "type")} for entry in layers
        ]
        configuration["mesh_file"] = str(cls.file)
        rospy.set_param(SERVER, {"mesh_map": configuration, "planner_frequency": 1.0})
        robot = {"initial_pose": list(START) + [0.0], "publish_clock": True}
        rospy.set_param("/surface_robot", robot)
        for package, node, name in (
            ("mesh_navigation", "surface_robot", "surface_robot"),
            ("mesh_navigation", "mbf_mesh_nav", SERVER[1:]),
        ):
            command = ["rosrun", package, node, "__name:=" + name]
            cls.stack.enter_context(process(name, command, cls.logs))
        rospy.init_node("obstacle_avoidance")

    @classmethod
    def tearDownClass(cls):
        cls.stack.close()

    def wait_for(self, condition, what):
        """Poll; fail with what the nodes have printed."""
        if not wait_until(condition, seconds=PATIENCE):
            self.fail(what + " not within %g s\n" % PATIENCE + self.printed())

    def printed(self):
        """The last lines of the nodes."""
        return "\n".join(log.read_text()[-3000:] for log in sorted(self.logs.glob("*.log")))

    def test_a_column_on_the_way_is_driven_around(self):
        obstacle, track, paths = column(*PLACE), [], []
        drop = rospy.Publisher("/surface_robot/obstacles", MarkerArray, queue_size=1)
        dropped = threading.Event()

        def follow(message):
            position = message.pose.position
            track.append((position.x, position.y, position.z))
            if position.x > DROP_AT and not dropped.is_set():
                dropped.set()
                drop.publish(MarkerArray(markers=[marker_of(obstacle)]))

        subscribers = [
            rospy.Subscriber("/surface_robot/pose", PoseStamped, follow, queue_size=1000),
            rospy.Subscriber("/move_base_flex/wave_front_planner/path", PathMessage, paths.append),
        ]
        odometry = []
        subscribers.append(rospy.Subscriber("/odom", Odometry, odometry.append, queue_size=10))
        client = actionlib.SimpleActionClient(SERVER + "/move_base", MoveBaseAction)
        self.wait_for(lambda: client.wait_for_server(rospy.Duration(0.01)), "a server")
        self.wait_for(lambda: track and drop.get_num_connections(), "the robot")
        np.testing.assert_allclose(track[0], START, atol=1e-3)

        goal = MoveBaseGoal(planner="wave_front_planner")
        goal.target_pose.header.frame_id = "map"
        position = goal.target_pose.pose.position
        position.x, position.y, position.z = GOAL
        goal.target_pose.pose.orientation.w = 1.0
        ended = []
        client.send_goal(goal, done_cb=lambda state, result: ended.append((state, result)))
        self.wait_for(lambda: ended, "the end of the drive")

        state, result = ended[0]
        self.assertEqual(state, actionlib.GoalStatus.SUCCEEDED, result.message + self.printed())
        self.assertEqual(result.outcome, MoveBaseResult.SUCCESS)
        self.assertTrue(dropped.is_set())
        points = np.array(track)
        self.assertLess(np.linalg.norm(points[-1] - GOAL), 0.12)
        self.assertLess(result.dist_to_goal, 0.12)
        # Never within the column, and aside of it, though the first plan went through it.
        nearest = min(distance(obstacle, point) for point in points)
        self.assertGreater(nearest, 0.0)
        passing = points[np.argmin(np.abs(points[:, 0] - PLACE[0]))]
        self.assertGreater(abs(passing[1] - PLACE[1]), 0.3)
        first = np.array([(p.pose.position.x, p.pose.position.y) for p in paths[0].poses])
        self.assertLess(np.abs(first[:, 1] - 6.0).max(), 0.05)
        self.assertGreater(len(paths), 3)
        # It stands when all is over.
        count = len(odometry)
        self.wait_for(lambda: len(odometry) > count + 30, "odometry")
        self.assertAlmostEqual(odometry[-1].twist.twist.linear.x, 0.0)
        self.assertAlmostEqual(odometry[-1].twist.twist.angular.z, 0.0)
        del subscribers


if __name__ == "__main__":
    rostest.rosrun("mesh_tools_test", "obstacle_avoidance", ObstacleAvoidance)
