#!/usr/bin/python3
"""The node hdf5_map_server over ROS: latched topics for a late subscriber, services, errors, its
end.
"""
import os
import signal
import subprocess
import sys
import tempfile
import threading
import time
import unittest
from pathlib import Path

import h5py
import numpy as np
import rospy
import rostest
from mesh_msgs import array_services, arrays, msg as stock
from mesh_msgs.testing import wait_until
from mesh_msgs.srv import GetUUIDs, GetVertexCostLayers, GetVertexCosts
from std_msgs.msg import String

from mesh_msgs_hdf5.map_file import MapFile
from mesh_msgs_hdf5.model.mesh import Mesh
from mesh_msgs_hdf5.ros.loading_signals import ended_by_signals

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "support"))
from holding import held_open  # noqa: E402
from mesh_writers import SQUARE, TWO_FACES, ply, xyz  # noqa: E402

LAYERS = {"layer_%d" % i: np.float32([i, np.inf, np.nan, 0.5]) for i in range(10)}
MESH = Mesh(
    SQUARE,
    TWO_FACES,
    vertex_normals=np.float32([[0, 0, 1]] * 4),
    vertex_colors=np.uint8([[0, 51, 255]] * 4),
    vertex_costs=LAYERS,
    layer_parameters={
        "layer_%d" % i: {"type": "x", "layer_info": {"comparison": "above", "threshold": 0.4 + i}}
        for i in (1, 2)
    },
    frame_id="floor",
)


def node_command(*arguments, name="hdf5_map_server"):
    return ["rosrun", "mesh_msgs_hdf5", "hdf5_map_server", "__name:=" + name, *arguments]


class Server:
    """A running node in a namespace of its own."""

    def __init__(self, namespace, path):
        environment = dict(os.environ, ROS_NAMESPACE=namespace)
        self.process = subprocess.Popen(
            node_command("_inputFile:=" + path), env=environment, stdout=subprocess.DEVNULL
        )
        self.namespace = namespace
        rospy.wait_for_service(namespace + "/get_vertex_cost_layers", 30)

    def call(self, name, kind, *arguments):
        return rospy.ServiceProxy(self.namespace + "/" + name, kind)(*arguments)

    def stop(self):
        self.process.terminate()
        return self.process.wait(20)


class ServeAMap(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.TemporaryDirectory()
        cls.path = os.path.join(cls.folder.name, "a.h5")
        MapFile.write(cls.path, MESH)
        cls.server = Server("/one", cls.path)

    @classmethod
    def tearDownClass(cls):
        cls.server.stop()
        cls.folder.cleanup()

    def received(self, topic, kind, count, queue_size=4):
        """Messages that a subscriber gets which comes after all was published."""
        found, done = [], threading.Event()

        def take(message):
            found.append(message)
            if len(found) >= count:
                done.set()

        subscriber = rospy.Subscriber(
            self.server.namespace + topic, kind, take, queue_size=queue_size
        )
        done.wait(20)
        time.sleep(0.3)  # whether there are more
        subscriber.unregister()
        return found

    def check_header(self, message):
        self.assertEqual(message.header.frame_id, "floor")
        self.assertEqual(message.uuid, MESH.uuid)
        self.assertGreater(message.header.stamp.to_sec(), 0)

    def test_geometry_is_latched(self):
        (message,) = self.received("/mesh/geometry", arrays.MeshGeometryStamped, 1)
        self.check_header(message)
        geometry = message.mesh_geometry
        np.testing.assert_array_equal(geometry.vertices, SQUARE)
        np.testing.assert_array_equal(geometry.faces, TWO_FACES)
        np.testing.assert_array_equal(geometry.vertex_normals, MESH.vertex_normals)

    def test_what_is_served_is_said_on_progress(self):
        (message,) = self.received("/progress", String, 1)
        text = "ready: serving %s: 4 vertices, 2 faces, layers: layer_0, " % self.path
        self.assertTrue(message.data.startswith(text), message.data)

    def test_a_stock_subscriber_gets_it_too(self):
        (message,) = self.received("/mesh/geometry", stock.MeshGeometryStamped, 1)
        found = [(p.x, p.y, p.z) for p in message.mesh_geometry.vertices]
        self.assertEqual(found, [tuple(v) for v in SQUARE.tolist()])

    def test_colors_are_latched(self):
        (message,) = self.received("/mesh/vertex_colors", arrays.MeshVertexColorsStamped, 1)
        self.check_header(message)
        expected = np.float32([[0, 0.2, 1, 1]] * 4)
        np.testing.assert_array_equal(message.mesh_vertex_colors.vertex_colors, expected)

    def test_a_late_subscriber_gets_every_layer(self):
        for _ in range(2):
            messages = self.received("/mesh/vertex_costs", arrays.MeshVertexCostsStamped, 10)
            self.assertEqual(sorted(message.type for message in messages), sorted(LAYERS))
            for message in messages:
                self.check_header(message)
                costs = message.mesh_vertex_costs.costs
                np.testing.assert_array_equal(costs, LAYERS[message.type])

    def test_what_costs_mean_is_latched(self):
        (message,) = self.received("/mesh/layer_info", stock.LayerInfoArray, 1)
        self.assertEqual(message.uuid, MESH.uuid)
        self.assertEqual(message.header.frame_id, "floor")
        self.assertEqual([layer.name for layer in message.layers], ["layer_1", "layer_2"])
        first = message.layers[0]
        self.assertEqual((first.comparison, first.infinity), (stock.LayerInfo.ABOVE, "lethal"))
        self.assertAlmostEqual(first.threshold, 1.4, 6)
        # [1, inf, nan, 0.5]
        self.assertEqual((first.lethal, first.unknown, first.layer_type), (1, 1, "x"))

    def test_services_answer_for_the_uuid_and_its_short_names(self):
        self.assertEqual(self.server.call("get_uuids", GetUUIDs).uuids, [MESH.uuid])
        for uuid in (MESH.uuid, "", "mesh"):
            answer = self.server.call("get_geometry", array_services.GetGeometry, uuid)
            self.check_header(answer.mesh_geometry_stamped)
            geometry = answer.mesh_geometry_stamped.mesh_geometry
            np.testing.assert_array_equal(geometry.faces, TWO_FACES)
            answer = self.server.call("get_vertex_colors", array_services.GetVertexColors, uuid)
            colors = answer.mesh_vertex_colors_stamped
            self.check_header(colors)
            self.assertEqual(colors.mesh_vertex_colors.vertex_colors.shape, (4, 4))
            layers = self.server.call("get_vertex_cost_layers", GetVertexCostLayers, uuid).layers
            self.assertEqual(layers, sorted(LAYERS))
            answer = self.server.call("get_vertex_costs", GetVertexCosts, uuid, "layer_3")
            costs = answer.mesh_vertex_costs_stamped
            self.check_header(costs)
            self.assertEqual(costs.type, "layer_3")
            np.testing.assert_array_equal(costs.mesh_vertex_costs.costs, LAYERS["layer_3"])

    def test_what_is_unknown_is_a_service_error_that_names_the_known(self):
        for name, kind, arguments, words in (
            ("get_geometry", array_services.GetGeometry, ("other",), MESH.uuid),
            ("get_vertex_colors", array_services.GetVertexColors, ("other",), MESH.uuid),
            ("get_vertex_costs", GetVertexCosts, ("other", "layer_1"), MESH.uuid),
            ("get_vertex_cost_layers", GetVertexCostLayers, ("other",), MESH.uuid),
            ("get_vertex_costs", GetVertexCosts, ("", "height"), "layer_0, layer_1, layer_2"),
        ):
            with self.assertRaises(rospy.ServiceException) as refused:
                self.server.call(name, kind, *arguments)
            self.assertIn(words, str(refused.exception))
        self.assertIsNone(self.server.process.poll())

    def test_a_mesh_without_colors_and_layers_from_a_ply_file(self):
        path = os.path.join(self.folder.name, "b.ply")
        with open(path, "wb") as stream:
            stream.write(ply(xyz(SQUARE), TWO_FACES))
        server = Server("/two", path)
        try:
            answer = server.call("get_geometry", array_services.GetGeometry, "")
            message = answer.mesh_geometry_stamped
            self.assertEqual((message.uuid, message.header.frame_id), (MESH.uuid, "map"))
            self.assertEqual(message.mesh_geometry.vertex_normals.shape, (0, 3))
            self.assertEqual(
                server.call("get_vertex_cost_layers", GetVertexCostLayers, "").layers, []
            )
            answer = server.call("get_vertex_colors", array_services.GetVertexColors, "")
            colors = answer.mesh_vertex_colors_stamped.mesh_vertex_colors
            self.assertEqual(colors.vertex_colors.shape, (0, 4))
            with self.assertRaises(rospy.ServiceException) as refused:
                server.call("get_vertex_costs", GetVertexCosts, "", "x")
            self.assertIn("known: none", str(refused.exception))
        finally:
            self.assertEqual(server.stop(), 0)

    def test_a_bad_file_ends_the_node_with_one_line(self):
        result = subprocess.run(
            node_command("_inputFile:=nowhere.h5", name="bad"),
            cwd=self.folder.name,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            timeout=60,
            check=False,
        )
        self.assertEqual(result.returncode, 1)
        line = "hdf5_map_server: error: nowhere.h5: there is no such file (nodes run in %s, where"
        line = (line + " relative paths begin; give an absolute path)\n") % self.folder.name
        self.assertEqual(result.stderr, line.encode())

    def test_a_map_that_another_program_has_open_is_served_afterwards(self):
        with tempfile.TemporaryDirectory() as folder:
            path = os.path.join(folder, "held.h5")
            MapFile.write(path, MESH)
            told = []
            heard = rospy.Subscriber("/held/progress", String, lambda m: told.append(m.data))
            with held_open(path):
                process = subprocess.Popen(
                    node_command("_inputFile:=" + path, name="held_server"),
                    env=dict(os.environ, ROS_NAMESPACE="/held"),
                    stdout=subprocess.PIPE,
                    stderr=subprocess.STDOUT,
                )
                self.assertTrue(wait_until(lambda: "another program has it open" in "".join(told)))
                self.assertIsNone(process.poll())
            rospy.wait_for_service("/held/save_map", 30)
            self.assertTrue(wait_until(lambda: "ready: serving " + path in "".join(told)))
            heard.unregister()
            process.terminate()
            log = process.communicate(timeout=30)[0].decode()
            self.assertEqual(process.returncode, 0)
            self.assertEqual(log.count("close the program that has it open"), 1)

    def test_one_bad_value_is_said_once_and_all_else_is_served(self):
        path = os.path.join(self.folder.name, "one_bad.h5")
        MapFile.write(path, MESH)
        with h5py.File(path, "r+") as file:
            file["mesh/channels/layer_1"][0] = -np.inf
            file["mesh/channels/vertex_normals"][1] = np.nan
        server = Server("/one_bad", path)
        try:
            found = server.call("get_geometry", array_services.GetGeometry, "")
            normals = found.mesh_geometry_stamped.mesh_geometry.vertex_normals
            self.assertTrue(np.isfinite(normals).all() and len(normals) == 4)
            for name in LAYERS:
                answer = server.call("get_vertex_costs", array_services.GetVertexCosts, "", name)
                costs = answer.mesh_vertex_costs_stamped.mesh_vertex_costs.costs
                self.assertFalse((costs == -np.inf).any())
            told = []
            heard = rospy.Subscriber("/one_bad/progress", String, lambda m: told.append(m.data))
            notes = ("note: layer layer_1: 1 values -inf", "note: 1 normals of")
            self.assertTrue(
                wait_until(lambda: told and all(note in told[-1] for note in notes)), told
            )
            self.assertEqual([told[-1].count(note) for note in notes], [1, 1], told[-1])
            heard.unregister()
        finally:
            self.assertEqual(server.stop(), 0)

    def test_signals_end_the_load(self):
        before = [signal.getsignal(number) for number in (signal.SIGINT, signal.SIGTERM)]
        for number in (signal.SIGINT, signal.SIGTERM):
            with self.assertRaises(KeyboardInterrupt), ended_by_signals():
                os.kill(os.getpid(), number)
                time.sleep(20)
        after = [signal.getsignal(number) for number in (signal.SIGINT, signal.SIGTERM)]
        self.assertEqual(after, before)
        self.assertFalse(rospy.is_shutdown())

    def test_without_a_roscore_it_says_so_and_can_be_interrupted(self):
        uri = "http://localhost:1"
        process = subprocess.Popen(
            node_command(name="lonely"),
            env=dict(os.environ, ROS_MASTER_URI=uri),
            stdout=subprocess.DEVNULL,
            stderr=subprocess.PIPE,
        )
        line = process.stderr.readline()
        self.assertEqual(line, b"hdf5_map_server: waiting for roscore at %s\n" % uri.encode())
        process.send_signal(2)
        self.assertEqual(process.stderr.read(), b"")
        self.assertEqual(process.wait(20), 130)
        process.stderr.close()


if __name__ == "__main__":
    rospy.init_node("serve_a_map")
    rostest.rosrun("mesh_msgs_hdf5", "serve_a_map", ServeAMap)
