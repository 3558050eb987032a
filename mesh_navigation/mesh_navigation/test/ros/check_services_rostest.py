#!/usr/bin/python3
"""The services that tell what the map says, asked as clients do."""

import subprocess
import tempfile
import unittest
from pathlib import Path

import numpy as np
import rospy
import rostest
import tf2_ros
from geometry_msgs.msg import PointStamped, PoseStamped, TransformStamped
from mbf_msgs.srv import CheckPath, CheckPathRequest, CheckPoint, CheckPointRequest
from mbf_msgs.srv import CheckPose, CheckPoseRequest
from navigation_process import NodeProcess
from nav_msgs.msg import Path as PathMessage
from sensor_msgs.msg import PointCloud2, PointField
from server_process import stamped, write_map
from std_srvs.srv import Empty

from mesh_msgs import zoo
from mesh_navigation import MeshNavigator
from mesh_msgs.testing import wait_until

FREE, INSCRIBED, LETHAL, UNKNOWN, OUTSIDE = range(5)
NODE = "checking"
SERVICES = {
    "check_point_cost": CheckPoint,
    "check_pose_cost": CheckPose,
    "check_path_cost": CheckPath,
    "clear_mesh": Empty,
}
LAYERS = {
    "mesh_file": write_map(zoo.grid(cells=40, size=10.0)),
    "layers": [{"name": "obstacles", "type": "mesh_layers/ObstacleLayer"}],
    "obstacles": {
        "topic": "/cloud",
        "decay": 0,
        "sensor_frame": "map",
        "clearing": False,
        "expected_update_rate": 0,
    },
}


def transform(child, x, y, yaw=0.0):
    message = TransformStamped()
    message.header.frame_id, message.child_frame_id = "map", child
    translation, rotation = message.transform.translation, message.transform.rotation
    translation.x, translation.y = x, y
    rotation.z, rotation.w = np.sin(yaw / 2), np.cos(yaw / 2)
    return message


def cloud(*points):
    message = PointCloud2(height=1, width=len(points), point_step=12, row_step=12 * len(points))
    message.header.frame_id = "map"
    message.fields = [
        PointField(name, 4 * i, PointField.FLOAT32, 1) for i, name in enumerate("xyz")
    ]
    message.data = np.array(points, np.float32).tobytes()
    return message


def path(*places, frame="map"):
    message = PathMessage()
    message.header.frame_id = frame
    message.poses = [stamped(place, "") for place in places]
    return message


class CheckServicesTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.node = NodeProcess(
            NODE,
            "mbf_mesh_nav",
            mesh_map=LAYERS,
            tf_timeout=0.3,
            footprint=[[0.3, 0.2], [-0.3, 0.2], [-0.3, -0.2], [0.3, -0.2]],
        )
        cls.services = {}
        for name, kind in SERVICES.items():
            rospy.wait_for_service(f"/{NODE}/{name}", 60)
            cls.services[name] = rospy.ServiceProxy(f"/{NODE}/{name}", kind)
        cls.broadcaster = tf2_ros.StaticTransformBroadcaster()
        cls.broadcaster.sendTransform(
            [transform("base_link", 5.3, 5.0), transform("moved", 10.0, 10.0, np.pi)]
        )
        cls.clouds = rospy.Publisher("/cloud", PointCloud2, queue_size=1, latch=True)

        def map_is_there():
            try:
                return cls.services["check_point_cost"](point=cls.point(1, 1)).state == FREE
            except rospy.ServiceException:
                return False

        wait_until(map_is_there, "the map")

    @classmethod
    def tearDownClass(cls):
        try:
            status, _ = cls.node.end()
        finally:
            cls.node.kill()
        assert status == 0, cls.node.output()

    @staticmethod
    def point(x, y, z=0.0, frame="map"):
        message = PointStamped()
        message.header.frame_id = frame
        message.point.x, message.point.y, message.point.z = x, y, z
        return message

    def setUp(self):
        """An obstacle at (5, 5): three vertices are lethal."""
        self.clouds.publish(cloud((4.95, 4.9, 0.3)))
        wait_until(lambda: self.ask_point(5, 5) == (LETHAL, 254), "the obstacle")

    def ask_point(self, *place, **fields):
        answer = self.services["check_point_cost"](point=self.point(*place, **fields))
        return answer.state, answer.cost

    def ask_pose(self, pose=None, **fields):
        request = CheckPoseRequest(pose=pose or PoseStamped(), **fields)
        answer = self.services["check_pose_cost"](request)
        return answer.state, answer.cost

    def ask_path(self, message, **fields):
        answer = self.services["check_path_cost"](CheckPathRequest(path=message, **fields))
        return answer.last_checked, answer.state, answer.cost

    def fails(self, words, ask, *args, **fields):
        with self.assertRaises(rospy.ServiceException) as caught:
            ask(*args, **fields)
        self.assertIn(words, str(caught.exception).replace("\\", ""))

    def test_points(self):
        self.assertEqual(self.ask_point(1, 1), (FREE, 0))
        self.assertEqual(self.ask_point(5, 5, 0.5), (OUTSIDE, 0))
        self.assertEqual(self.ask_point(5, 5, frame="moved"), (LETHAL, 254))
        self.assertEqual(self.ask_point(5, 5, frame="/map"), (LETHAL, 254))
        self.assertEqual(self.ask_point(1, 1, frame="moved"), (FREE, 0))

    def test_poses(self):
        state, cost = self.ask_pose(stamped((5.3, 5.0, 0.0)))
        self.assertEqual((state, cost % 254), (LETHAL, 0))
        self.assertGreater(cost, 0)
        self.assertEqual(self.ask_pose(current_pose=True), (state, cost))
        self.assertEqual(self.ask_pose(current_pose=True, lethal_cost_mult=2), (state, 2 * cost))
        self.assertEqual(self.ask_pose(stamped((5.7, 5.0, 0.0))), (FREE, 0))
        self.assertEqual(self.ask_pose(stamped((5.7, 5.0, 0.0)), safety_dist=0.5)[0], LETHAL)
        self.assertEqual(self.ask_pose(stamped((4.3, 5.0, 0.0), "moved"))[0], FREE)
        self.assertEqual(self.ask_pose(stamped((4.7, 5.0, 0.0), "moved"))[0], LETHAL)
        self.assertEqual(self.ask_pose(stamped((9.9, 5.0, 0.0)))[0], OUTSIDE)

    def test_paths(self):
        places = [(x, 5.0, 0.0) for x in (3.0, 4.0, 5.0, 6.0, 11.0)]
        last, state, cost = self.ask_path(path(*places))
        self.assertEqual((last, state, cost), (4, OUTSIDE, 3 * 254))
        self.assertEqual(self.ask_path(path(*places), return_on=LETHAL), (2, LETHAL, 3 * 254))
        self.assertEqual(self.ask_path(path(*places[:4]), skip_poses=2), (3, FREE, 0))
        found = self.ask_path(path(*places[:4]), path_cells_only=True)
        self.assertEqual(found[:2], (3, LETHAL))
        moved = path(*[(10 - x, 10 - y, z) for x, y, z in places], frame="moved")
        self.assertEqual(self.ask_path(moved), (4, OUTSIDE, 3 * 254))
        in_poses = path(*places, frame="")
        for pose in in_poses.poses:
            pose.header.frame_id = "map"
        self.assertEqual(self.ask_path(in_poses), (4, OUTSIDE, 3 * 254))

    def test_what_cannot_be_answered_says_why(self):
        nan = float("nan")
        self.fails("is not finite", self.ask_point, nan, 5)
        self.fails("'nowhere' to 'map' within 0.3 s", self.ask_point, 5, 5, frame="nowhere")
        self.fails("has no frame_id", self.ask_point, 5, 5, frame="")
        self.fails(
            "1 of 1 poses are without an orientation",
            self.ask_pose,
            PoseStamped(header=stamped((0, 0, 0)).header),
        )
        self.fails(
            "the distance to keep is -1.0 m", self.ask_pose, stamped((5, 5, 0)), safety_dist=-1
        )
        self.fails(
            "the factor for unknown costs is nan",
            self.ask_pose,
            stamped((5, 5, 0)),
            unknown_cost_mult=nan,
        )
        self.fails("the path has no poses", self.ask_path, path())
        self.fails(
            "1 of 2 poses are not finite, first 1", self.ask_path, path((1, 1, 0), (1, nan, 0))
        )
        mixed = path((1, 1, 0), (2, 2, 0))
        mixed.poses[1].header.frame_id = "moved"
        self.fails("in 2 frames, but one is needed: ['map', 'moved']", self.ask_path, mixed)

    def test_plans_keep_the_body_off(self):
        navigator = MeshNavigator(NODE)
        start, free, near = [stamped((x, 5.0, 0.0)) for x in (8.0, 5.35, 5.15)]
        self.assertTrue(navigator.get_path(free, start=start, timeout=60).succeeded)
        refused = navigator.get_path(near, start=start, timeout=60)
        self.assertEqual(refused.name, "INVALID_GOAL", refused.message)
        self.assertIn("the robot's radius is 0.20 m", refused.message)

    def test_clearing(self):
        self.services["clear_mesh"]()
        self.assertEqual(self.ask_point(5, 5), (FREE, 0))
        wait_until(
            lambda: "clear_mesh: cleared 1 in layer obstacles" in self.node.output(), "the log"
        )
        self.services["clear_mesh"]()
        self.assertEqual(self.ask_point(5, 5), (FREE, 0))

    def test_the_command_line(self):
        command = ["rosservice", "call", f"/{NODE}/check_point_cost"]
        request = "{point: {header: {frame_id: map}, point: {x: 5.0, y: 5.0}}, costmap: 2}"
        done = subprocess.run(command + [request], capture_output=True, text=True, timeout=60)
        self.assertEqual(done.stdout.split(), ["state:", "2", "cost:", "254"])
        wrong = request.replace("map}", "mars}")
        done = subprocess.run(command + [wrong], capture_output=True, text=True, timeout=60)
        error = done.stderr.replace("\\", "")
        self.assertIn("no transform for the requested pose from 'mars' to 'map'", error)
        self.assertNotEqual(done.returncode, 0)
        self.assertNotIn("Traceback", self.node.output())


class WithoutMapTest(unittest.TestCase):
    def test_while_the_map_is_loading_and_when_there_is_none(self):
        missing = Path(tempfile.mkdtemp()) / "garden.h5"
        node = NodeProcess(
            "mapless",
            "mbf_mesh_nav",
            mesh_map={"mesh_file": str(missing)},
            cost_limit=50,
        )
        self.addCleanup(node.kill)
        requests = {
            "check_point_cost": CheckPointRequest(),
            "check_pose_cost": CheckPoseRequest(current_pose=True),
            "check_path_cost": CheckPathRequest(),
            "clear_mesh": None,
        }
        for name, request in requests.items():
            rospy.wait_for_service(f"/mapless/{name}", 60)
            call = rospy.ServiceProxy(f"/mapless/{name}", SERVICES[name])

            def why_not():
                with self.assertRaises(rospy.ServiceException) as caught:
                    call() if request is None else call(request)
                self.assertRegex(str(caught.exception), "map is still being loaded|there is no map")
                return str(caught.exception)

            wait_until(lambda: "there is no map: " in why_not(), "the end of loading")
            self.assertIn(str(missing), why_not())
        output = node.output()
        self.assertIn("cost_limit is 50, outside of", output)
        self.assertEqual(node.end()[0], 0)


class Suite(unittest.TestSuite):
    def __init__(self):
        load = unittest.defaultTestLoader.loadTestsFromTestCase
        super().__init__([load(CheckServicesTest), load(WithoutMapTest)])


if __name__ == "__main__":
    rospy.init_node("check_services_test")
    rostest.rosrun("mesh_navigation", "check_services", "check_services_rostest.Suite")
