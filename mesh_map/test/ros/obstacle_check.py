#!/usr/bin/python3
"""Clouds on a running ROS: from a topic to lethal vertices, in the node and the adapter alone."""

import contextlib
import os
import shutil
import subprocess
import tempfile
import threading
import time
import unittest
from unittest import mock

import numpy as np
import roslib.packages
import rospy
import rostest
import tf2_ros
from geometry_msgs.msg import TransformStamped
from mesh_map.layers.obstacle import ObstacleLayer
from mesh_map.map.mesh_map import COMBINED_COSTS, MeshMap
from mesh_map.ros.layer_adapters import LayerAdapters
from mesh_map.ros.obstacle_adapter import ObstacleAdapter
from mesh_msgs import arrays
from mesh_msgs.testing import wait_until
from mesh_msgs_hdf5.map_file import MapFile
from mesh_msgs_hdf5.model.mesh import Mesh
from sensor_msgs.msg import LaserScan, PointCloud2, PointField
from std_srvs.srv import Trigger

WAIT = 20.0  # seconds; far more than anything takes
FLOOR = [[-5, -5, 0], [5, -5, 0], [5, 5, 0], [-5, 5, 0]]
WALL = [[-5.5, -1, 0], [-5.5, 1, 0], [-5.5, 0, 3]]
VERTICES = np.array(FLOOR + WALL, np.float32)
FACES = np.array([[0, 1, 2], [0, 2, 3], [4, 5, 6]], np.uint32)
RIGHT, LEFT = [2.0, -2.0, 0.5], [-2.0, 2.0, 0.5]  # over faces 0 and 1
INF = np.inf


def printed(log, text):
    """The lines of a node with a text in them."""
    with open(log) as lines:
        return [line for line in lines.read().splitlines() if text in line]


def complaints(log):
    """The lines in which a node says that clouds cannot be used."""
    return printed(log, "cannot be used")


def cloud(points, frame="laser", stamp=None):
    """A big-endian cloud with z first, as no usual driver sends it."""
    data = np.zeros(len(points), [("z", ">f8"), ("x", ">f4"), ("y", ">f4")])
    for column, name in enumerate("xyz"):
        data[name] = np.asarray(points, float).reshape(-1, 3)[:, column]
    message = PointCloud2(height=1, width=len(points), is_bigendian=True, data=data.tobytes())
    message.fields = [
        PointField("z", 0, PointField.FLOAT64, 1),
        PointField("x", 8, PointField.FLOAT32, 1),
        PointField("y", 12, PointField.FLOAT32, 1),
    ]
    message.point_step, message.row_step = 16, 16 * len(points)
    message.header.frame_id = frame
    message.header.stamp = rospy.Time(0) if stamp is None else stamp
    return message


def transform(child, translation, quaternion=(0, 0, 0, 1)):
    made = TransformStamped()
    made.header.frame_id, made.child_frame_id = "map", child
    made.transform.translation.x, made.transform.translation.y = translation[:2]
    made.transform.translation.z = translation[2]
    rotation = made.transform.rotation
    rotation.x, rotation.y, rotation.z, rotation.w = quaternion
    return made


class Obstacles(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        half = np.sqrt(0.5)
        cls.broadcaster = tf2_ros.StaticTransformBroadcaster()
        cls.broadcaster.sendTransform(
            [
                transform("laser", (1, 1, 1), (0, 0, 1, 0)),  # looks back: x and y are turned
                transform("robot", (2, -2, 0)),
                transform("leaning", (0, 0, 0), (0, half, 0, half)),  # its z is x of the map
            ]
        )

    def to_laser(self, points):
        return (np.asarray(points, float) - 1) * [-1, -1, 1]

    def publisher(self, topic):
        publisher = rospy.Publisher(topic, PointCloud2, queue_size=20)
        self.addCleanup(publisher.unregister)
        return publisher

    def adapter(self, namespace, wait=0.0, **params):
        """An adapter on its own, with a list of what was marked at each refresh."""
        mesh_map, seen = MeshMap(VERTICES, FACES), []
        layer = ObstacleLayer("obstacles", dict({"decay": 0.0, "tf_tolerance": 2.0}, **params))

        def refresh():
            seen.append(layer.marked_faces.tolist())
            time.sleep(wait)

        adapter = ObstacleAdapter(namespace, mesh_map, layer, refresh)
        self.addCleanup(adapter.shutdown)
        return adapter, layer, seen

    def send(self, publisher, message):
        self.assertTrue(wait_until(lambda: publisher.get_num_connections() > 0))
        publisher.publish(message)

    def test_from_a_cloud_to_lethal_vertices_and_back(self):
        folder = tempfile.mkdtemp()
        self.addCleanup(shutil.rmtree, folder)
        path = os.path.join(folder, "map.h5")
        MapFile.write(path, Mesh(VERTICES, FACES))
        rospy.set_param(
            "/node",
            {
                "mesh_file": path,
                "layers": [{"name": "obstacles", "type": "mesh_layers/ObstacleLayer"}],
                "obstacles": {
                    "topic": "cloud",
                    "robot_height": 0.7,
                    "decay": 1.0,
                    "tf_tolerance": 2.0,
                },
            },
        )
        executable = roslib.packages.find_node("mesh_map", "mesh_map")[0]
        with open(os.path.join(folder, "log"), "w") as log:
            node = subprocess.Popen(
                [executable, "__name:=node"], stdout=log, stderr=subprocess.STDOUT
            )
            self.addCleanup(node.wait, WAIT)
            self.addCleanup(node.terminate)
            found = {}
            self.addCleanup(
                rospy.Subscriber(
                    "/node/vertex_costs",
                    arrays.MeshVertexCostsStamped,
                    lambda m: found.update({m.type: list(m.mesh_vertex_costs.costs)}),
                    queue_size=10,
                ).unregister
            )
            free, right = [0.0] * 7, [INF] * 3 + [0.0] * 4

            def both(costs):
                return lambda: [found.get(n) for n in ("obstacles", COMBINED_COSTS)] == [costs] * 2

            self.assertTrue(wait_until(both(free)), found)
            publisher = self.publisher("/cloud")
            nowhere = cloud(self.to_laser([RIGHT]), frame="nowhere")
            self.send(publisher, nowhere)
            self.send(publisher, nowhere)
            # clouds that wait together are one to the node, the newest
            self.assertTrue(wait_until(lambda: complaints(log.name)), found)
            self.send(publisher, cloud(self.to_laser([RIGHT, [np.nan, 0, 0]])))
            self.assertTrue(wait_until(both(right)), found)
            # While no cloud comes, it stays, and that is said.
            silent = "nothing usable came from topic cloud for"
            self.assertTrue(wait_until(lambda: printed(log.name, silent)), found)
            self.assertTrue(both(right)(), found)

            def gone():
                publisher.publish(cloud([[0.0, 0.0, 0.0]], frame="laser"))  # high above the floor
                time.sleep(0.1)
                return both(free)()

            self.assertTrue(wait_until(gone), found)  # it is not seen again
            self.assertIsNone(node.poll())
            lines = complaints(log.name)
            self.assertEqual(len(lines), 1, lines)
            self.assertIn("nowhere", lines[0])
            self.assertIn("/cloud", lines[0])

    def test_clearing_and_the_service(self):
        adapter, layer, seen = self.adapter("/one/obstacles", topic="one")
        publisher = self.publisher("/one")
        self.send(publisher, cloud([RIGHT, LEFT], frame="/map"))
        self.assertTrue(wait_until(lambda: seen == [[0, 1]]), seen)
        self.send(publisher, cloud([RIGHT, LEFT], frame="map"))  # nothing new: no refresh
        beyond = cloud([np.multiply(RIGHT, 10)], frame="map")  # seen from the origin of the map
        self.send(publisher, beyond)
        self.assertTrue(wait_until(lambda: seen == [[0, 1], [1]]), seen)
        clear = rospy.ServiceProxy("/one/obstacles/clear", Trigger)
        self.assertEqual(clear().message, "forgotten: 1 marked face")
        self.assertEqual(seen, [[0, 1], [1], []])
        self.assertEqual(clear().message, "forgotten: 0 marked faces")
        self.assertEqual(len(seen), 3)

    def test_the_newest_cloud_counts(self):
        adapter, layer, seen = self.adapter("/two/obstacles", 0.5, topic="two", decay=-1.0)
        publisher = self.publisher("/two")
        for number in range(20):
            self.send(publisher, cloud([(RIGHT, LEFT)[number % 2]], frame="map"))
            time.sleep(0.02)
        self.assertTrue(wait_until(lambda: seen and seen[-1] == [1]), seen)
        self.assertLess(len(seen), 10)

    def test_down_is_where_the_robot_says(self):
        down = {"topic": "three", "down_axis": [0, 0, -2]}
        rospy.set_param("/three/robot_frame", "leaning")
        adapter, layer, seen = self.adapter("/three/map/obstacles", **down)
        other, plain, straight = self.adapter("/three/map/straight", axis_frame="laser", **down)
        publisher = self.publisher("/three")
        self.assertTrue(wait_until(lambda: publisher.get_num_connections() > 0))
        self.send(publisher, cloud(self.to_laser([RIGHT, [-3.0, 0.3, 1.0]])))
        self.assertTrue(wait_until(lambda: straight == [[0, 1]]), straight)
        self.assertTrue(wait_until(lambda: seen == [[2]]), seen)
        self.assertEqual((layer.last_cloud.elsewhere, layer.last_cloud.obstacles), (1, 1))

    def test_the_topic_may_change(self):
        adapter, layer, seen = self.adapter("/four/obstacles", topic="")
        publisher = self.publisher("/four")
        layer.params["topic"] = "four"
        self.send(publisher, cloud([LEFT], frame="map"))
        self.assertTrue(wait_until(lambda: seen == [[1]]), seen)
        layer.params["topic"] = "/not a name"
        self.assertTrue(wait_until(lambda: publisher.get_num_connections() == 0))
        layer.params["topic"] = "four"
        self.send(publisher, cloud([RIGHT], frame="map"))
        self.assertTrue(wait_until(lambda: len(seen) > 1), seen)

    def test_that_nobody_watches_is_said_once_when_it_is_switched_off(self):
        adapter, layer, seen = self.adapter(
            "/twelve/obstacles",
            observation_sources="watched not_watched",
            watched={"topic": "twelve"},
            not_watched={"expected_update_rate": 0.0},
        )

        def set_source(name, topic="twelve", data_type="PointCloud2", rate=0.0):
            """As by dynamic_reconfigure, until the adapter has looked at it."""
            layer.params[name] = dict(topic=topic, data_type=data_type, expected_update_rate=rate)

            def seen():
                known = adapter._subscribed[name][:2] == (topic, data_type)
                return known and (name in adapter._unwatched) == (rate == 0.0)

            self.assertTrue(wait_until(seen))

        with mock.patch("mesh_map.ros.obstacle_adapter._LOG") as log:
            set_source("not_watched", topic="elsewhere")
            set_source("not_watched", data_type="LaserScan")
            set_source("not_watched", topic="/not a name")
            set_source("not_watched")
            log.warning.assert_not_called()  # it was said at the start
            subscriber = adapter._subscribers["watched"]
            set_source("watched")
            (call,) = log.warning.call_args_list
            self.assertIn("when source watched (twelve) falls", call[0][0] % call[0][1:])
            set_source("watched", rate=3.0)
            self.assertEqual(log.warning.call_count, 1)
            self.assertIs(adapter._subscribers["watched"], subscriber)
            set_source("watched")
            self.assertEqual(log.warning.call_count, 2)  # somebody has done so again

    def test_what_nobody_watches_is_said_at_the_start(self):
        with mock.patch("mesh_map.ros.obstacle_adapter._LOG") as log:
            self.adapter("/thirteen/obstacles", topic="thirteen", expected_update_rate=0.0)
            self.adapter("/thirteen/others", topic="thirteen")
        (call,) = log.warning.call_args_list
        text = "nobody will notice when topic thirteen falls silent (expected_update_rate is 0)"
        self.assertEqual(call[0][0] % call[0][1:], "layer obstacles: " + text)

    def test_bad_clouds_do_no_harm(self):
        adapter, layer, seen = self.adapter("/five/obstacles", topic="five", tf_tolerance=0.0)
        publisher = self.publisher("/five")
        broken = cloud([LEFT], frame="map")
        broken.point_step = 3
        old = cloud([LEFT], stamp=rospy.Time(1))
        for message in (broken, cloud([LEFT], frame=""), cloud([LEFT], frame="?"), old):
            self.send(publisher, message)
            time.sleep(0.05)
        self.send(publisher, cloud([], frame="map"))
        self.send(publisher, cloud([RIGHT], frame="map"))
        self.assertTrue(wait_until(lambda: bool(seen)), seen)
        self.assertEqual(seen[0][0], 0)

    def test_a_bag_that_begins_again(self):
        """rospy ends whoever waits for time to pass when the clock is set back."""
        adapter, layer, seen = self.adapter("/eight/obstacles", topic="eight", tf_tolerance=60.0)
        said = []
        adapter._complaints.add = lambda kind, reason: said.append((kind, str(reason)))
        back = rospy.exceptions.ROSTimeMovedBackwardsException(-3.0)
        with mock.patch.object(adapter._transforms.buffer, "lookup_transform", side_effect=back):
            adapter._on_message(cloud(self.to_laser([LEFT])), "")
        self.assertEqual(said, [("clouds from /eight cannot be used", str(back))])
        self.assertIn("topic eight yet", adapter._silence())
        self.assertIn(str(back), adapter._silence())
        adapter._on_message(cloud([[np.nan] * 3]), "")
        self.assertIn("no point of it is finite", adapter._silence())
        adapter._on_message(cloud([]), "")  # a sensor that sees nothing
        self.assertEqual((layer.marked_faces.tolist(), adapter._silence()), ([], ""))
        adapter._on_message(cloud(self.to_laser([LEFT])), "")
        self.assertEqual((seen, len(said), adapter._silence()), ([[1]], 2, ""))

    def test_clouds_that_are_not_in_the_frame_of_their_sensor(self):
        """Seen from the laser; from the origin of the map, it would be the other way round."""
        at_laser = np.array([1.0, 1.0, 1.0])
        behind = at_laser + 10 * (np.array(LEFT) - at_laser)
        for sensor_frame, marked in (("laser", []), ("", [1])):
            layer_name = "/nine%s/obstacles" % sensor_frame
            adapter, layer, seen = self.adapter(layer_name, topic="", sensor_frame=sensor_frame)
            said = []
            adapter._complaints.add = lambda kind, reason, said=said: said.append(str(reason))
            adapter._on_message(cloud([LEFT], frame="map"), "")
            adapter._on_message(cloud([behind], frame="map"), "")
            self.assertEqual(layer.marked_faces.tolist(), marked)
            self.assertEqual(said, [] if sensor_frame else ["set sensor_frame"] * 2)

    def test_several_sources_around_a_robot(self):
        rospy.set_param("/ten", {"robot_radius": 0.5, "robot_frame": "robot"})
        adapter, layer, seen = self.adapter(
            "/ten/map/obstacles",
            observation_sources="scan points",
            scan={
                "topic": "ten_scan",
                "data_type": "LaserScan",
                "clearing": True,
                "inf_is_valid": True,
                "sensor_frame": "laser",
            },
            points={
                "topic": "ten_points",
                "observation_persistence": 0.0,
                "expected_update_rate": 5.0,
            },
        )
        scans = rospy.Publisher("/ten_scan", LaserScan, queue_size=20)
        self.addCleanup(scans.unregister)
        points = self.publisher("/ten_points")
        self.assertIn("source scan (ten_scan) yet", adapter._silence())
        ahead = [2.5, 1.0, 1.0]  # of the laser, in the map; the robot is at RIGHT
        self.send(points, cloud(self.to_laser([ahead, LEFT, RIGHT])))
        self.assertTrue(wait_until(lambda: layer.marked_faces.tolist() == [0, 1]), seen)
        self.assertEqual(len(layer._marks["points"].times), 2)
        self.assertNotIn("ten_points", adapter._silence())
        back = LaserScan(angle_min=np.pi, angle_increment=0.1, range_min=0.1, range_max=30.0)
        back.header.frame_id, back.ranges = "laser", [np.nan]
        self.send(scans, back)
        self.assertTrue(wait_until(lambda: "none of the 1 ranges" in adapter._silence()))
        back.ranges = [np.inf]  # nothing in that direction
        self.send(scans, back)
        self.assertTrue(wait_until(lambda: layer.marked_faces.tolist() == [1]), seen)
        self.assertTrue(wait_until(lambda: "ten_points" in adapter._silence()))  # for a second

    def test_clouds_do_not_wait_for_who_reads_them(self):
        """An inflation over the first one hangs: others come, and the sensor is not silent."""
        mesh_map = MeshMap(VERTICES, FACES)
        obstacles = {"topic": "eleven", "decay": -1.0, "sensor_frame": "laser"}
        mesh_map.compute_layers(
            [
                {"name": "seen", "type": "mesh_layers/ObstacleLayer", "params": obstacles},
                {"name": "inflation", "type": "mesh_layers/InflationLayer"},
            ]
        )
        begun, go_on = threading.Event(), threading.Event()
        inflation = mesh_map.layers["inflation"]
        update = inflation.update

        def hang(*arguments):
            begun.set()
            self.assertTrue(go_on.wait(10 * WAIT))
            return update(*arguments)

        def lethal():
            return np.flatnonzero(np.isinf(mesh_map.costs)).tolist()

        inflation.update = hang
        in_use = contextlib.ExitStack()
        self.addCleanup(in_use.close)
        self.addCleanup(go_on.set)
        LayerAdapters("/eleven", mesh_map, in_use).start()
        publisher = self.publisher("/eleven")
        self.send(publisher, cloud([RIGHT], frame="map"))
        self.assertTrue(begun.wait(WAIT))
        self.assertEqual(lethal(), [0, 1, 2])
        for point, expected in ((LEFT, [0, 2, 3]), (RIGHT, [0, 1, 2]), (LEFT, [0, 2, 3])):

            def come(point=point, expected=expected):
                publisher.publish(cloud([point], frame="map"))
                return lethal() == expected and not mesh_map.gap

            self.assertTrue(wait_until(come), (lethal(), mesh_map.gap))
        self.assertEqual(mesh_map.stale_layers, ("inflation",))
        clear = rospy.ServiceProxy("/eleven/seen/clear", Trigger)
        thread = threading.Thread(target=clear)
        thread.start()
        self.assertTrue(wait_until(lambda: lethal() == []))
        self.assertEqual(mesh_map.stale_layers, ("inflation",))
        go_on.set()
        thread.join(WAIT)
        self.assertFalse(thread.is_alive())
        self.assertEqual((mesh_map.stale_layers, mesh_map.costs.tolist()), ((), [0.0] * 7))

    def test_nothing_comes_after_shutdown(self):
        adapter, layer, seen = self.adapter("/six/obstacles", 0.3, topic="six", decay=0.5)
        publisher = self.publisher("/six")
        self.send(publisher, cloud([LEFT], frame="map"))
        self.assertTrue(wait_until(lambda: bool(seen)))
        adapter.shutdown()
        adapter.shutdown()
        count = len(seen)
        publisher.publish(cloud([RIGHT], frame="map"))
        time.sleep(1.0)  # longer than decay
        self.assertEqual(len(seen), count)
        with self.assertRaises(rospy.ROSException):
            rospy.wait_for_service("/six/obstacles/clear", 0.2)
        self.assertFalse([t.name for t in threading.enumerate() if t is adapter._thread])

    def test_a_map_that_fails_does_not_end_the_adapter(self):
        adapter, layer, seen = self.adapter("/seven/obstacles", topic="seven")
        failures = [0, 0, 0, 1]
        adapter.refresh = lambda refresh=adapter.refresh: (refresh(), 1 / failures.pop(0))
        publisher = self.publisher("/seven")
        self.send(publisher, cloud([LEFT], frame="map"))
        self.assertTrue(wait_until(lambda: not failures), failures)  # it is tried again
        self.assertEqual(seen, [[1]] * 4)
        time.sleep(0.5)  # longer than until the next try
        self.assertEqual(len(seen), 4)
        failures.append(1)
        self.send(publisher, cloud([RIGHT], frame="map"))
        self.assertTrue(wait_until(lambda: len(seen) == 5), seen)


if __name__ == "__main__":
    rospy.init_node("obstacle_check")
    rostest.rosrun("mesh_map", "obstacle_check", Obstacles)
