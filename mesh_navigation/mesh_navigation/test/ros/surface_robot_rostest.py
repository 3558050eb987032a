#!/usr/bin/python3
"""The node surface_robot, as its users meet it."""

import collections
import io
import math
import os
import signal
import subprocess
import tempfile
import unittest

import numpy as np
import rosbag
import rospy
import rostest
import tf2_ros
from dynamic_reconfigure.client import Client
from geometry_msgs.msg import Pose2D, PoseWithCovarianceStamped, Twist
from mesh_msgs.arrays import MeshGeometryStamped, MeshVertexCostsStamped
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import PointCloud2
from robot_process import RobotProcess, position_of
from server_process import write_map
from tf2_msgs.msg import TFMessage
from visualization_msgs.msg import Marker, MarkerArray

from mesh_map.costs.combination import COMBINED_COSTS
from mesh_map.io.map_messages import costs_message, geometry_message
from mesh_map.io.point_cloud import cloud_points
from mesh_map.map.mesh_map import MeshMap
from mesh_msgs import zoo
from mesh_msgs.diagnostics_ros import OK, WARN
from mesh_msgs.testing import wait_until
from mesh_msgs.testing_ros import HeardDiagnostics
from mesh_msgs.transform import rotation_and_translation

GRID = zoo.grid()  # 10 m x 10 m, at the height 0


def transforms_of(messages):
    """Those of messages of a bag, in the class that tf2 wants."""
    for message in messages:
        data = io.BytesIO()
        message.serialize(data)
        yield from TFMessage().deserialize(data.getvalue()).transforms


def cube(x, y, number=0, action=Marker.ADD, frame="map"):
    marker = Marker(type=Marker.CUBE, action=action, ns="test", id=number)
    marker.header.frame_id = frame
    marker.pose.position.x, marker.pose.position.y, marker.pose.position.z = x, y, 0.5
    marker.pose.orientation.w = 1.0
    marker.scale.x = marker.scale.y = marker.scale.z = 1.0
    return marker


class SurfaceRobotTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.map_file = write_map(GRID)
        cls.buffer = tf2_ros.Buffer()
        cls.listener = tf2_ros.TransformListener(cls.buffer)

    def robot(self, name, **parameters):
        robot = RobotProcess(name, **parameters)
        self.addCleanup(robot.stop)
        return robot

    def seen_from(self, frame, child, stamp):
        wait_until(
            lambda: self.buffer.can_transform(frame, child, stamp), f"{child} in {frame} in time"
        )
        found = self.buffer.lookup_transform(frame, child, stamp).transform
        return np.array([found.translation.x, found.translation.y, found.translation.z])

    def test_velocities_drive_it_and_frames_follow(self):
        robot = self.robot(
            "driver",
            mesh_file=self.map_file,
            initial_pose=[2.0, 5.0],
            base_height=0.25,
            odometry_noise=0.2,
            scan_rings=4,
        )
        start = position_of(robot.wait_for_pose().pose)
        np.testing.assert_allclose(start, [2, 5, 0], atol=1e-6)
        self.assertIn("waiting for velocities on /driver/cmd_vel", robot.output())
        robot.drive(0.5, lambda position: position[0] > 3.0)
        # Commands end: it stops by itself.
        wait_until(lambda: robot.heard["odom"][-1].twist.twist.linear.x == 0, "a stop")
        still = position_of(robot.wait_for_pose().pose)
        self.assertLess(still[0], 9)
        self.assertEqual(position_of(robot.wait_for_pose().pose).tolist(), still.tolist())
        message = robot.heard["surface_robot/pose"][-3]
        stamp = message.header.stamp
        truth = position_of(message.pose)
        for child, height in (("footprint", 0.0), ("base", 0.25), ("laser", 1.05)):
            found = self.seen_from("map", f"driver_{child}", stamp)
            np.testing.assert_allclose(found, truth + [0, 0, height], atol=1e-6)
        odometry = robot.heard["odom"][-1]
        self.assertEqual(odometry.header.frame_id, "driver_odom")
        self.assertEqual(odometry.child_frame_id, "driver_footprint")
        # It is as far off as its noise says, and TF makes up for it.
        counted = self.seen_from("driver_odom", "driver_footprint", stamp)
        self.assertGreater(np.linalg.norm(counted - (truth - start)), 1e-3)
        self.assertEqual(robot.stop(), 0)

    def test_poses_put_it_elsewhere(self):
        robot = self.robot("put", mesh_file=self.map_file, localization=False)
        middle = position_of(robot.wait_for_pose().pose)
        np.testing.assert_allclose(middle, [5, 5, 0], atol=1e-6)
        message = PoseWithCovarianceStamped()
        message.header.frame_id = "map"
        pose = message.pose.pose
        pose.position.x, pose.position.y, pose.position.z = 8.0, 1.0, -3.0
        pose.orientation.z = 1.0
        robot.send("initialpose", message)
        there = robot.wait_for_pose(lambda position: position[0] > 7).pose
        np.testing.assert_allclose(position_of(there), [8, 1, 0], atol=1e-6)
        self.assertAlmostEqual(abs(there.orientation.z), 1.0)
        for wrong in ("frame", "number"):
            pose.position.x = 2.0
            message.header.frame_id = "moon" if wrong == "frame" else "map"
            pose.orientation.w = float("nan") if wrong == "number" else 0.0
            robot.send("initialpose", message)
        wait_until(lambda: "is not finite" in robot.output(), "a complaint")
        self.assertIn("initialpose is in the frame 'moon', but 'map' is needed", robot.output())
        still = position_of(robot.wait_for_pose().pose)
        np.testing.assert_allclose(still, [8, 1, 0], atol=1e-6)
        # Somebody else says where odom is in the map.
        self.assertFalse(self.buffer.can_transform("map", "put_odom", rospy.Time()))

    def test_obstacles_are_seen_shown_and_stop_it(self):
        robot = self.robot(
            "bumper",
            mesh_file=self.map_file,
            initial_pose="4 5 0 0",
            scan_noise=0.0,
            scan_rate=20.0,
            obstacles=[{"type": "sphere", "position": [3, 8, 0], "size": [1, 1, 1]}, "nonsense"],
        )
        robot.listen("cloud", PointCloud2)
        robot.wait_for_pose()
        self.assertIn("obstacles[1] is skipped", robot.output())
        robot.send("surface_robot/obstacles", MarkerArray([cube(6, 5), cube(4, 5, 1, frame="x")]))
        clouds = robot.heard["cloud"]

        def ahead():
            points = cloud_points(clouds[-1]) if clouds else np.zeros((0, 3))
            beam = points[(abs(points[:, 1]) < 0.3) & (points[:, 2] > -0.7) & (points[:, 0] > 0)]
            return len(beam) and beam[:, 0].min()

        wait_until(lambda: abs(ahead() - 1.5) < 1e-3, "the cube in the cloud")
        self.assertEqual(clouds[-1].header.frame_id, "bumper_laser")
        shown = robot.heard["surface_robot/markers"][-1].markers
        self.assertEqual(
            [(marker.ns, marker.type) for marker in shown[1:]],
            [
                ("obstacles", Marker.SPHERE),
                ("test", Marker.CUBE),
                ("robot", Marker.CUBE),
                ("robot", Marker.ARROW),
            ],
        )
        self.assertIn("marker 'test' 1 is no obstacle: its frame is 'x'", robot.output())
        robot.drive(1.5, lambda position: position[0] > 5.4)
        wait_until(lambda: "an obstacle is in the way" in robot.output(), "a warning")
        self.assertLess(position_of(robot.wait_for_pose().pose)[0], 5.5)
        robot.send("surface_robot/obstacles", MarkerArray([cube(0, 0, 0, action=Marker.DELETEALL)]))
        robot.drive(1.5, lambda position: position[0] > 6.0)
        wait_until(lambda: not ahead() or ahead() > 3, "an empty cloud")

    def test_a_drive_is_an_ordinary_bag(self):
        robot = self.robot(
            "recorded",
            mesh_file=self.map_file,
            initial_pose=[2.0, 5.0],
            scan_rate=10.0,
            scan_rings=24,
            scan_columns=180,
            scan_duration=0.1,
            scan_dropout=0.2,
            odometry_noise=0.2,
        )
        robot.wait_for_pose()
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        path = os.path.join(folder.name, "drive.bag")
        topics = ["/tf", "/tf_static"]
        topics += [f"/recorded/{name}" for name in ("cloud", "odom", "surface_robot/pose")]
        recorder = subprocess.Popen(
            ["rosbag", "record", "--quiet", "-O", path, *topics, "__name:=recorder"]
        )
        self.addCleanup(recorder.kill)
        robot.listen("cloud", PointCloud2)
        wait_until(lambda: len(robot.heard["cloud"]) > 2, "clouds")
        wait_until(lambda: os.path.exists(path + ".active"), "a recorder")
        command = Twist()
        command.linear.x, command.angular.z = 1.0, 1.0
        first = len(robot.heard["cloud"])

        def long_enough():
            robot.send("cmd_vel", command)
            rospy.rostime.wallsleep(0.02)
            return len(robot.heard["cloud"]) > first + 12

        wait_until(long_enough, "clouds of a drive")
        recorder.send_signal(signal.SIGINT)
        self.assertEqual(recorder.wait(30), 0)
        # What it had started may still close the bag.
        wait_until(lambda: os.path.exists(path), "the closed bag")
        heard = collections.defaultdict(list)
        with rosbag.Bag(path) as bag:
            for topic, message, _ in bag.read_messages():
                heard[topic].append(message)
        self.assertEqual(set(heard), set(topics))
        buffer = tf2_ros.BufferCore(rospy.Duration(1000.0))
        for transform in transforms_of(heard["/tf"]):
            buffer.set_transform(transform, "bag")
        for transform in transforms_of(heard["/tf_static"]):
            buffer.set_transform_static(transform, "bag")
        begin = heard["/recorded/surface_robot/pose"][0].header.stamp
        end = heard["/recorded/surface_robot/pose"][-1].header.stamp
        whole, moved = 0, 0.0
        for cloud in heard["/recorded/cloud"]:
            stamp = cloud.header.stamp
            kinds = [("xyz", "<f4", 3), ("intensity", "<f4"), ("ring", "<u2"), ("time", "<f4")]
            rows = np.frombuffer(cloud.data, kinds)
            self.assertLess(rows["time"].max(), 0.1)
            self.assertLess(rows["ring"].max(), 24)
            if not begin < stamp or not stamp + rospy.Duration(0.1) < end:
                continue
            heights = []
            for row in rows[::40]:
                when = stamp + rospy.Duration.from_sec(float(row["time"]))
                found = buffer.lookup_transform_core("map", "recorded_laser", when)
                rotation, translation = rotation_and_translation(found)
                heights.append((rotation @ row["xyz"] + translation)[2])
            # Each point is on the floor from where the sensor was at its own time.
            np.testing.assert_allclose(heights, 0, atol=1e-4)
            one = [
                buffer.lookup_transform_core("map", "recorded_laser", t).transform.translation
                for t in (stamp, stamp + rospy.Duration(0.09))
            ]
            moved = max(moved, np.hypot(one[1].x - one[0].x, one[1].y - one[0].y))
            whole += 1
        self.assertGreater(whole, 5)
        self.assertGreater(moved, 0.05)

    def test_the_lidar_changes_while_it_runs(self):
        robot = self.robot("changed", mesh_file=self.map_file, scan_rate=20.0, scan_rings=4)
        robot.listen("cloud", PointCloud2)
        clouds = robot.heard["cloud"]
        wait_until(lambda: clouds, "a cloud")
        client = Client("/changed/surface_robot", timeout=30)
        self.addCleanup(client.close)
        found = client.update_configuration({"scan_rings": 9, "scan_dropout": 7.0})
        self.assertEqual((found["scan_rings"], found["scan_dropout"]), (9, 1.0))
        wait_until(lambda: clouds[-1].width == 0, "a cloud without points")
        client.update_configuration({"scan_dropout": 0.0})
        rings = [("xyz", "<f4", 3), ("intensity", "<f4"), ("ring", "<u2"), ("time", "<f4")]
        last = lambda: np.frombuffer(clouds[-1].data, rings)["ring"]  # noqa: E731
        wait_until(lambda: len(last()) and 3 < last().max() < 9, "other rings")
        self.assertIn("scan_dropout is 7.0, outside of", robot.output())

    def test_odometry_slips_drifts_and_jumps(self):
        robot = self.robot("wrong", mesh_file=self.map_file, initial_pose=[1.0, 5.0, 0.0, 0.0])
        robot.wait_for_pose()

        def seen():
            """Where it is along x, and where and in which heading by its odometry."""
            truths = {m.header.stamp: m.pose for m in list(robot.heard["surface_robot/pose"])}
            counted = next(m for m in robot.heard["odom"][::-1] if m.header.stamp in truths)
            turned = counted.pose.pose.orientation
            yaw = 2 * math.atan2(turned.z, turned.w)
            x = truths[counted.header.stamp].position.x
            return np.array([x, *position_of(counted.pose.pose)[:2], yaw])

        def moved():
            """What has become of that after a while of driving, once it stands."""
            before = seen()
            robot.drive(1.0, lambda position: position[0] > before[0] + 0.5)
            wait_until(lambda: robot.heard["odom"][-1].twist.twist.linear.x == 0, "a stop")
            return seen() - before

        way, x, y, yaw = moved()
        np.testing.assert_allclose([x - way, y, yaw], 0.0, atol=1e-6)
        before = seen()
        robot.send("surface_robot/odometry_jump", Pose2D(0.5, -0.2, 0.1))
        wait_until(lambda: seen()[3] != before[3], "a jump")
        np.testing.assert_allclose(seen() - before, [0.0, 0.5, -0.2, 0.1], atol=1e-6)
        client = Client("/wrong/surface_robot", timeout=30)
        self.addCleanup(client.close)
        client.update_configuration({"slip": 0.5})
        way, x, y, yaw = moved()
        np.testing.assert_allclose([np.hypot(x, y), yaw], [2 * way, 0.0], rtol=1e-3, atol=1e-6)
        client.update_configuration({"slip": 0.0, "odometry_yaw_drift": 0.2})
        way, x, y, yaw = moved()
        self.assertAlmostEqual(yaw, 0.2 * way, places=3)
        robot.send("surface_robot/odometry_jump", Pose2D(math.nan, 0.0, 0.0))
        wait_until(lambda: "odometry_jump is left out" in robot.output(), "a complaint")
        self.assertTrue(np.isfinite(seen()).all())

    def test_time_of_its_own(self):
        ticks = []
        subscriber = rospy.Subscriber("/clock", Clock, ticks.append)
        self.addCleanup(subscriber.unregister)
        robot = self.robot(
            "watch",
            mesh_file=self.map_file,
            publish_clock=True,
            real_time_factor=4.0,
            rate=100.0,
            max_acceleration=1000.0,
            initial_pose=[1, 5],
        )
        robot.wait_for_pose()
        wait_until(lambda: "use_sim_time is not" in robot.output(), "a warning")
        robot.drive(1.0, lambda position: position[0] > 3)
        wait_until(lambda: len(ticks) > 100, "ticks")
        times = [tick.clock.to_nsec() for tick in list(ticks)]
        # Under load the odd tick is lost on the way.
        steps = np.diff(times) / 1e7
        np.testing.assert_allclose(steps, np.maximum(np.round(steps), 1), atol=1e-6)
        # A second of simulated time is a meter at 1 m/s, whatever the time of the computer.
        drive = [
            (message.header.stamp.to_sec(), message.pose.position.x)
            for message in robot.heard["surface_robot/pose"]
            if 1.5 < message.pose.position.x < 2.5
        ]
        steps = np.diff(np.array(drive), axis=0)
        moving = steps[:, 1] > 1e-6
        np.testing.assert_allclose(steps[moving, 1], steps[moving, 0], atol=1e-6)

    def test_maps_from_a_topic(self):
        diagnostics = HeardDiagnostics()
        robot = self.robot("listener", mesh_topic="/some/mesh", initial_pose=[7.0, 5.0])
        name = "listener/surface_robot: robot"
        diagnostics.expected(name, WARN, "waits for a map")
        line = "waiting for the map on /some/mesh (or set _mesh_file:=...)"
        wait_until(lambda: line in robot.output(), line)
        publisher = rospy.Publisher("/some/mesh", MeshGeometryStamped, queue_size=2, latch=True)
        broken = geometry_message(MeshMap(GRID.vertices, GRID.faces))
        broken.mesh_geometry.faces = broken.mesh_geometry.faces + np.uint32(1000)
        publisher.publish(broken)
        wait_until(lambda: "the mesh on /some/mesh cannot be used" in robot.output(), "a refusal")
        flat = geometry_message(MeshMap(GRID.vertices * np.float32([1, 0, 0]), GRID.faces))
        publisher.publish(flat)
        wait_until(lambda: "no surface within" in robot.output(), "another refusal")
        publisher.publish(geometry_message(MeshMap(GRID.vertices, GRID.faces)))
        np.testing.assert_allclose(position_of(robot.wait_for_pose().pose), [7, 5, 0], atol=1e-6)
        diagnostics.expected(name, OK, f"on a map of {len(GRID.faces)} faces")
        # Another map: it stays where it is, as far as there is surface.
        raised = GRID.vertices + np.float32([0, 0, 0.5])
        publisher.publish(geometry_message(MeshMap(raised, GRID.faces)))
        pose = robot.wait_for_pose(lambda position: position[2] > 0.4).pose
        np.testing.assert_allclose(position_of(pose), [7, 5, 0.5], atol=1e-6)
        publisher.publish(geometry_message(MeshMap(raised + np.float32([50, 0, 0]), GRID.faces)))
        pose = robot.wait_for_pose(lambda position: position[0] > 10).pose
        np.testing.assert_allclose(position_of(pose), [50, 5, 0.5], atol=1e-6)

    def test_seams_of_textures_do_not_stop_it(self):
        """The mesh of a map as it is published has copies of the vertices there."""
        vertices, faces = GRID.vertices, GRID.faces.astype(np.int64)
        seam = np.flatnonzero(vertices[:, 0] == 3.0)
        right = vertices[faces][:, :, 0].mean(1) > 3.0
        place = len(vertices) + np.searchsorted(seam, faces)
        faces = np.where(right[:, None] & np.isin(faces, seam), place, faces).astype(np.uint32)
        mesh_map = MeshMap(np.concatenate([vertices, vertices[seam]]), faces)
        self.assertEqual(mesh_map.topology.component_count, 2)
        robot = self.robot("seams", mesh_topic="/seams/mesh", initial_pose=[1.0, 5.0])
        publisher = rospy.Publisher("/seams/mesh", MeshGeometryStamped, queue_size=1, latch=True)
        publisher.publish(geometry_message(mesh_map))
        robot.wait_for_pose()
        robot.drive(1.0, lambda position: position[0] > 4.0)
        self.assertNotIn("does not get on", robot.output())

    def test_free_ground_to_begin_on(self):
        """It waits for the costs of its map, and begins beside what they block."""
        topics = {"mesh_topic": "/blocked/mesh", "costs_topic": "/blocked/vertex_costs"}
        robot, diagnostics = self.robot("beginner", **topics), HeardDiagnostics()
        mesh_map = MeshMap(GRID.vertices, GRID.faces)
        other = MeshMap(GRID.vertices[:, [1, 0, 2]], GRID.faces)
        blocked = np.where(GRID.vertices[:, 0] < 6.5, np.inf, 0).astype(np.float32)
        mesh = rospy.Publisher("/blocked/mesh", MeshGeometryStamped, queue_size=1, latch=True)
        costs = rospy.Publisher("/blocked/vertex_costs", MeshVertexCostsStamped, queue_size=3)
        wait_until(costs.get_num_connections, "the robot")
        mesh.publish(geometry_message(mesh_map))
        name = "beginner/surface_robot: robot"
        diagnostics.expected(name, WARN, "waits for the costs of the map")
        costs.publish(costs_message(other, COMBINED_COSTS, 1 - blocked))
        costs.publish(costs_message(mesh_map, "roughness", blocked))
        costs.publish(costs_message(mesh_map, COMBINED_COSTS, blocked))
        x, y, _ = position_of(robot.wait_for_pose().pose)
        self.assertTrue(7 < x < 8 and 4 < y < 6, (x, y))
        wait_until(lambda: costs.get_num_connections() == 0, "its end of listening")

    def test_files_that_are_no_maps_end_it(self):
        robot = self.robot("broken", mesh_file="/nowhere/map.h5")
        self.assertEqual(robot.process.wait(60), 1)
        self.assertIn("/broken/surface_robot: error: ", robot.output())
        self.assertNotIn("Traceback", robot.output())

    def test_coordinates_that_need_an_origin(self):
        mesh = zoo.grid()
        utm = (565000.25, 5934000.125, 12.0)
        lines = ["v %.4f %.4f %.4f" % tuple(vertex + utm) for vertex in mesh.vertices]
        lines += ["f %d %d %d" % tuple(face + 1) for face in mesh.faces]
        file = tempfile.NamedTemporaryFile("w", suffix=".obj")
        self.addCleanup(file.close)
        file.write("\n".join(lines))
        file.flush()
        far = self.robot("far", mesh_file=file.name)
        near = self.robot("near", mesh_file=file.name, origin=list(utm), initial_pose=[7.0, 5.0])
        np.testing.assert_allclose(position_of(near.wait_for_pose().pose), [7, 5, 0], atol=1e-3)
        self.assertEqual(far.process.wait(60), 1)
        self.assertIn("origin", far.output())
        self.assertNotIn("Traceback", far.output())

    def test_frames_that_are_the_same_end_it(self):
        robots = [
            self.robot("looped", mesh_file=self.map_file, base_frame="looped_odom"),
            self.robot("mapped", mesh_file=self.map_file, odom_frame="map"),
        ]
        for robot in robots:
            self.assertEqual(robot.process.wait(60), 1)
            self.assertIn(f"/{robot.name}/surface_robot: error: the frames", robot.output())


if __name__ == "__main__":
    rospy.init_node("surface_robot_rostest")
    rostest.rosrun("mesh_navigation", "surface_robot", SurfaceRobotTest)
