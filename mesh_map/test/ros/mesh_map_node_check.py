#!/usr/bin/python3
"""The node mesh_map and the class that it shares with the navigation server, on a running ROS."""

import itertools
import os
import shutil
import signal
import subprocess
import sys
import tempfile
import threading
import time
import unittest
from subprocess import PIPE
from unittest import mock

import numpy as np
import rospy
import rostest
from dynamic_reconfigure.client import Client
from geometry_msgs.msg import Point
from map_node import WAIT, Subscriber, costs_of, end_node, start_node
from mesh_map.base.errors import MeshMapError
from mesh_map.costs.combination import COMBINED_COSTS
from mesh_map.io.map_source import MapSource
from mesh_map.ros import MeshMapServer
from mesh_msgs import arrays
from mesh_msgs.diagnostics_ros import ERROR, WARN
from mesh_msgs.testing import wait_until
from mesh_msgs.testing_ros import HeardDiagnostics
from mesh_msgs.identity import geometry_uuid
from mesh_msgs.zoo import two_components
from mesh_msgs_hdf5.map_file import MapFile
from mesh_msgs_hdf5.model.mesh import Mesh
from std_msgs.msg import String
from std_srvs.srv import Trigger

TYPE = "mesh_layers/HeightDiffLayer"
NAMES = ["layer_%d" % i for i in range(10)]


class MeshMapNode(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.mkdtemp()
        self.addCleanup(shutil.rmtree, self.folder)
        self.mesh = two_components()
        vertices = self.mesh.vertices
        self.colors = (np.arange(3 * len(vertices)) % 256).astype(np.uint8).reshape(-1, 3)
        self.path = os.path.join(self.folder, "map.h5")
        MapFile.write(self.path, Mesh(vertices, self.mesh.faces, vertex_colors=self.colors))

    def test_a_map_that_another_program_has_open_is_waited_for(self):
        code = "import sys, h5py; file = h5py.File(sys.argv[1], 'r+')\n"
        code += "print(flush=True); sys.stdin.read()"
        command = [sys.executable, "-c", code, self.path]
        with subprocess.Popen(command, stdin=PIPE, stdout=PIPE) as holder:
            holder.stdout.readline()
            node = start_node(self, "held", mesh_file=self.path, layers=[])
            progress = Subscriber("/held/progress", String)
            self.assertTrue(wait_until(lambda: "waiting" in str(progress.messages[-1:])))
            self.assertIn("close the program that has it open", progress.messages[-1].data)
            self.assertIsNone(node.poll())
            holder.stdin.close()
        self.assertTrue(wait_until(lambda: "ready" in str(progress.messages[-1:])))
        waits = [message for message in progress.messages if "waiting" in message.data]
        self.assertEqual(len(waits), 1)

    def test_late_subscribers_get_everything(self):
        layers = [{"name": name, "type": TYPE} for name in NAMES]
        params = {name: {"radius": 0.1 * i + 0.1} for i, name in enumerate(NAMES)}
        start_node(self, "late", mesh_file=self.path, global_frame="hall", layers=layers, **params)
        progress = Subscriber("/late/progress", String)
        self.assertTrue(wait_until(lambda: "ready" in str(progress.messages[-1:])))
        geometry = rospy.wait_for_message("/late/mesh", arrays.MeshGeometryStamped, WAIT)
        costs = costs_of("/late/vertex_costs")
        expected = set(NAMES) | {COMBINED_COSTS}
        self.assertTrue(wait_until(lambda: set(costs.newest) == expected), costs.newest.keys())
        colors = rospy.wait_for_message("/late/vertex_colors", arrays.MeshVertexColorsStamped, WAIT)

        mesh = self.mesh
        uuid = geometry_uuid(mesh.vertices, mesh.faces)
        self.assertEqual(geometry.uuid, uuid)
        self.assertEqual(colors.uuid, uuid)
        self.assertEqual({message.uuid for message in costs.newest.values()}, {uuid})
        messages = [geometry, colors] + list(costs.newest.values())
        self.assertEqual({message.header.frame_id for message in messages}, {"hall"})
        np.testing.assert_array_equal(geometry.mesh_geometry.vertices, mesh.vertices)
        np.testing.assert_array_equal(geometry.mesh_geometry.faces, mesh.faces)
        lengths = np.linalg.norm(geometry.mesh_geometry.vertex_normals, axis=1)
        np.testing.assert_allclose(lengths, np.ones(len(mesh.vertices)), atol=1e-6)
        rgba = colors.mesh_vertex_colors.vertex_colors
        np.testing.assert_allclose(rgba[:, :3], self.colors / 255.0, atol=1e-6)
        self.assertTrue((rgba[:, 3] == 1).all())
        for message in costs.newest.values():
            self.assertEqual(message.mesh_vertex_costs.costs.shape, (len(mesh.vertices),))
            self.assertFalse(np.isnan(message.mesh_vertex_costs.costs).any())

    def test_a_bad_layer_does_not_harm_the_others(self):
        diagnostics = HeardDiagnostics()
        layers = [{"name": "inflation", "type": "mesh_layers/NoLayer"}, "nonsense"]
        layers += [{"name": "height_diff", "type": TYPE}]
        layers += [{"name": "endless", "type": "strange/EndlessLayer"}]
        timeout = {"layer_timeout": 10.0}
        node = start_node(self, "partly", mesh_file=self.path, layers=layers, **timeout)
        costs = costs_of("/partly/vertex_costs")
        self.assertTrue(wait_until(lambda: COMBINED_COSTS in costs.newest))
        self.assertEqual(set(costs.newest), {"height_diff", COMBINED_COSTS})
        progress = Subscriber("/partly/progress", String)
        self.assertTrue(
            wait_until(lambda: "failed: layer inflation: there is no" in str(progress.messages))
        )
        words = "layer inflation: there is no mesh_map::Layer of the type"
        status = diagnostics.expected("partly: map", ERROR, words)
        values = {one.key: one.value for one in status.values}
        self.assertIn("mesh_layers/NoLayer", values["layer inflation"])
        self.assertEqual(values["layer height_diff"], "stands")
        self.assertRegex(values["layer endless"], "it hangs: no answer within 10 s")
        Client("partly/height_diff", WAIT).update_configuration({"radius": 0.5})
        self.assertEqual((values["file"], values["faces"]), (self.path, str(len(self.mesh.faces))))
        output = end_node(node)
        self.assertEqual(output.count("layer inflation is left out"), 1, output)
        self.assertRegex(output, "known: .*mesh_layers/HeightDiffLayer")
        self.assertIn("2 components", output)

    def test_a_layer_that_is_mended(self):
        """What was left out is served, gets data, and the map is ready, as soon as it can be."""
        diagnostics = HeardDiagnostics()
        layers = [{"name": "flag", "type": "strange/FlagLayer"}]
        layers += [{"name": "deaf", "type": "strange/DeafLayer", "required": False}]
        start_node(self, "mended", mesh_file=self.path, layers=layers, flag={"height": 13.0})
        diagnostics.expected("mended: map", ERROR, "layer flag: no flag is 13 m high")
        costs, flag = costs_of("/mended/vertex_costs"), rospy.Publisher("/mended/flag/flag", Point)
        Client("mended/flag", WAIT).update_configuration({"height": 2.0})
        words = "deaf: it gets no data from topics: OSError: no sensor"
        diagnostics.expected("mended: map", WARN, words)
        self.assertTrue(wait_until(flag.get_num_connections))
        flag.publish(Point(x=3, y=2))
        self.assertTrue(wait_until(lambda: "flag" in costs.newest))
        self.assertTrue(wait_until(lambda: costs.newest["flag"].mesh_vertex_costs.costs[3] == 4))

    def test_saved_layers_are_reused(self):
        layers = [{"name": "height_diff", "type": TYPE}]
        server = self.serve("saving", mesh_file=self.path, layers=layers)
        self.assertEqual(MapFile(self.path).layer_names(), [])
        save = rospy.ServiceProxy(server.namespace + "/save_map", Trigger)
        answer = save()
        self.assertTrue(answer.success, answer.message)
        saved = MapFile(self.path)
        self.assertEqual(saved.layer_names(), ["height_diff"])
        marked = saved.vertex_costs("height_diff") + np.float32(0.01)
        saved.write_layers({"height_diff": (marked, saved.layer_parameters("height_diff"))})
        again = server.load()
        np.testing.assert_array_equal(again.layers["height_diff"].result.costs, marked)

    def test_released_layers_are_used_unless_provenance_is_required(self):
        layers = [{"name": "height_diff", "type": TYPE}]
        fresh = self.serve("fresh", mesh_file=self.path, layers=layers).map
        fresh = fresh.layers["height_diff"].result.costs
        marked = np.linspace(0, 0.01, len(fresh)).astype(np.float32)
        MapFile(self.path).write_layers({"height_diff": (marked, None)})
        for name, required, expected in (("trusting", False, marked), ("strict", True, fresh)):
            given = dict(mesh_file=self.path, layers=layers, require_provenance=required)
            found = self.serve(name, **given).map.layers["height_diff"].result.costs
            np.testing.assert_array_equal(found, expected)

    def serve(self, name, **parameters):
        """A server in this very node, as the navigation server embeds it."""
        rospy.set_param("~" + name, parameters)
        server = MeshMapServer("~" + name)
        self.addCleanup(server.shutdown)
        server.load()
        return server

    def test_changes_do_not_wait_for_saving(self):
        layers = [{"name": "border", "type": "mesh_layers/BorderLayer"}]
        server = self.serve("busy", mesh_file=self.path, layers=layers)
        before = server.map.layers["border"].result.costs
        started, changed, save_layers = threading.Event(), threading.Event(), MapSource.save_layers

        def slow_save(source, layers):
            started.set()
            self.assertTrue(changed.wait(WAIT))
            return save_layers(source, layers)

        def change():
            started.wait(WAIT)
            server.map.set_layer_parameters("border", {"border_cost": 0.25})
            changed.set()

        thread = threading.Thread(target=change)
        thread.start()
        with mock.patch.object(MapSource, "save_layers", slow_save):
            answer = rospy.ServiceProxy(server.namespace + "/save_map", Trigger)()
        thread.join(WAIT)
        self.assertTrue(answer.success, answer.message)
        saved = MapFile(self.path)
        self.assertEqual(saved.layer_parameters("border")["border_cost"], 1.0)
        np.testing.assert_array_equal(saved.vertex_costs("border"), before)
        self.assertFalse(np.array_equal(server.map.layers["border"].result.costs, before))

    def test_saving_asks_layers_that_exit_or_hang(self):
        """Whoever saves gets an answer, the other layers are stored, and the map can be loaded."""
        names = ["border", "exit", "deep"]
        layers = [{"name": name, "type": "mesh_layers/BorderLayer"} for name in names]
        server = self.serve("asked", mesh_file=self.path, layers=layers)
        server.map.layer_set.workers["deep"]._seconds = 1.0
        end = threading.Event()
        self.addCleanup(end.set)

        def leave(*_):
            raise SystemExit("enough")

        for name, fingerprint in (("exit", leave), ("deep", lambda *_: end.wait(10 * WAIT))):
            server.map.set_layer_parameters(name, {"border_cost": 0.5})
            server.map.layers[name].fingerprint = fingerprint
        answers = []
        save = rospy.ServiceProxy(server.namespace + "/save_map", Trigger)
        thread = threading.Thread(target=lambda: answers.append(save()), daemon=True)
        thread.start()
        thread.join(WAIT)
        self.assertFalse(thread.is_alive(), "nobody answers")
        (answer,) = answers
        self.assertTrue(answer.success)
        told = "border; not stored: exit: SystemExit: enough, deep: it hangs"
        self.assertIn(told, answer.message)
        self.assertEqual(MapFile(self.path).layer_names(), ["border"])
        self.assertIn("layer deep: it hangs", server.map.fault)
        self.assertEqual(server.load().fault, "")

    def test_embedded_server(self):
        path = os.path.join(self.folder, "mesh.obj")
        with open(path, "w") as file:
            file.write("v 0 0 0\nv 1 0 0\nv 0 1 0.5\nf 1 2 3\n")
        server = self.serve("mesh_map", mesh_file=path)
        self.assertEqual(server.namespace, rospy.get_name() + "/mesh_map")
        server.publish_costs("Potential", np.array([0.0, 1.0, np.inf]))
        costs = costs_of(server.namespace + "/vertex_costs")
        self.assertTrue(wait_until(lambda: len(costs.newest) == 2))
        potential = costs.newest["Potential"]
        self.assertEqual(potential.mesh_vertex_costs.costs.tolist(), [0, 1, np.inf])
        self.assertEqual(potential.uuid, server.map.uuid)
        self.assertEqual(costs.newest[COMBINED_COSTS].mesh_vertex_costs.costs.tolist(), [0] * 3)
        with self.assertRaisesRegex(MeshMapError, r"Potential has \(2,\) costs for 3 vertices"):
            server.publish_costs("Potential", np.zeros(2))
        answer = rospy.ServiceProxy(server.namespace + "/save_map", Trigger)()
        self.assertFalse(answer.success)
        self.assertIn("is no map file", answer.message)

    def test_a_failed_reload_keeps_the_map(self):
        server = self.serve("reload", mesh_file=self.path)
        before = server.map
        rospy.set_param("~reload", {"mesh_file": os.path.join(self.folder, "none.h5")})
        with self.assertRaisesRegex(MeshMapError, "none.h5"):
            server.load()
        self.assertIs(server.map, before)

    def test_shutdown_ends_loading(self):
        layers = [{"name": "height_diff", "type": TYPE}]
        server = self.serve("ending", mesh_file=self.path, layers=layers)
        before = server.map
        for stage in range(4):  # before the file, after it, before the layer, before publishing
            answers = itertools.chain([False] * stage, itertools.repeat(True))
            fake = mock.Mock(wraps=rospy)
            fake.is_shutdown.side_effect = answers
            with mock.patch("mesh_map.ros.mesh_map_server.rospy", fake):
                with self.assertRaisesRegex(MeshMapError, "the node is shut down"):
                    server.load()
            self.assertIs(server.map, before)

    def test_shutdown_of_a_server_ends_loading(self):
        rospy.set_param("~ended", {"mesh_file": self.path})
        server = MeshMapServer("~ended")
        ready, go_on, errors = threading.Event(), threading.Event(), []

        def slow_source(*args):
            ready.set()
            go_on.wait(WAIT)
            return MapSource(*args)

        def load():
            try:
                server.load()
            except Exception as error:
                errors.append(error)

        with mock.patch("mesh_map.ros.mesh_map_server.MapSource", slow_source):
            loading = threading.Thread(target=load)
            loading.start()
            self.assertTrue(ready.wait(WAIT))
            ending = threading.Thread(target=server.shutdown)
            ending.start()
            time.sleep(0.1)
            go_on.set()
            loading.join(WAIT)
            ending.join(WAIT)
        load()
        self.assertEqual([type(error) for error in errors], [MeshMapError] * 2, errors)
        self.assertIn("is shut down", str(errors[0]))
        self.assertNotIn(server.namespace + "/mesh", dict(rospy.get_published_topics()))

    def test_interrupted_loading_is_no_error(self):
        layers = [{"name": "endless", "type": "strange/EndlessLayer"}]
        node = start_node(self, "interrupted", mesh_file=self.path, layers=layers)
        progress = []
        listening = rospy.Subscriber(
            "/interrupted/progress", String, lambda message: progress.append(message.data)
        )
        self.addCleanup(listening.unregister)
        self.assertTrue(wait_until(lambda: "layer endless" in str(progress)))
        node.send_signal(signal.SIGINT)
        output = node.communicate(timeout=WAIT)[0]
        self.assertEqual(node.returncode, 0, output)
        self.assertNotIn("cannot be loaded", output)

    def test_a_layer_that_never_ends_does_not_keep_the_node(self):
        for kind, number in (("Endless", signal.SIGINT), ("Native", signal.SIGTERM)):
            node = start_node(
                self,
                "kept_by_" + kind,
                mesh_file=self.path,
                layers=[{"name": "endless", "type": "strange/%sLayer" % kind}],
                endless={"deaf": True},
                shutdown_timeout=0.5,
            )
            self.assertTrue(any("computing" in line for line in node.stdout))
            node.send_signal(number)
            output = node.communicate(timeout=WAIT)[0]
            self.assertEqual(node.returncode, 128 + number, output)
            self.assertIn("from its end on signal %d" % number, output)

    def test_an_unexpected_error_is_told_by_services(self):
        rospy.set_param("~unexpected", {"mesh_file": self.path})
        server = MeshMapServer("~unexpected")
        self.addCleanup(server.shutdown)
        with mock.patch(
            "mesh_map.ros.mesh_map_server.MapSource", side_effect=MemoryError("too\nlarge")
        ):
            with self.assertRaises(MemoryError):
                server.load()
        with self.assertRaisesRegex(MeshMapError, "there is no map: MemoryError: too large"):
            server.publish_costs("Potential", np.zeros(3))

    def test_colors_of_another_map_do_not_stay(self):
        server = self.serve("colors", mesh_file=self.path)
        topic = server.namespace + "/vertex_colors"
        self.assertIn(topic, dict(rospy.get_published_topics()))
        MapFile.write(self.path, Mesh(self.mesh.vertices, self.mesh.faces))
        server.load()
        self.assertNotIn(topic, dict(rospy.get_published_topics()))

    def test_a_map_that_cannot_be_loaded(self):
        missing = os.path.join(self.folder, "missing.h5")
        cases = (
            ("missing", {"mesh_file": missing}, missing),
            ("directory", {"mesh_file": self.folder}, self.folder),
            ("unset", {"global_frame": "map"}, "mesh_file is not set"),
            ("no_part", {"mesh_file": self.path, "mesh_part": "cellar"}, "cellar"),
        )
        nodes = [start_node(self, name, **parameters) for name, parameters, _ in cases]
        for node, (_, _, message) in zip(nodes, cases):
            output = node.communicate(timeout=WAIT)[0]
            self.assertEqual(node.returncode, 1, output)
            lines = [line for line in output.splitlines() if line.strip()]
            self.assertEqual(len(lines), 1, output)
            self.assertIn("the map cannot be loaded: ", lines[0])
            self.assertIn(message, lines[0])

    def test_before_load(self):
        server = MeshMapServer("~unloaded")
        self.addCleanup(server.shutdown)
        with self.assertRaisesRegex(MeshMapError, "no map is loaded"):
            server.publish_costs("Potential", np.zeros(3))
        answer = rospy.ServiceProxy(server.namespace + "/save_map", Trigger)()
        self.assertEqual((answer.success, answer.message), (False, "no map is loaded"))


if __name__ == "__main__":
    rospy.init_node("mesh_map_node_check")
    rostest.rosrun("mesh_map", "mesh_map_node_check", MeshMapNode)
