#!/usr/bin/python3
"""What hdf5_map_server and label_manager say became of messages; kill -9 makes no lie of it.

KILLS in the environment: how often the server is killed.
"""
import os
import random
import shutil
import signal
import sys
import tempfile
import time
import unittest
from pathlib import Path

import numpy as np
import rospy
import rostest
from mesh_msgs import arrays, msg
from mesh_msgs.diagnostics_ros import WARN
from mesh_msgs.msg import StoreResult
from mesh_msgs.testing import wait_until
from mesh_msgs.testing_ros import HeardDiagnostics, connected
from server_process import Publishers, Server

from mesh_msgs_hdf5.labels.map_contents import read_map
from mesh_msgs_hdf5.map_file import MapFile

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "support"))
from holding import held_open  # noqa: E402
from server_samples import everything, layer_message  # noqa: E402

MAP = everything(1)
VERTICES, FACES = len(MAP.vertices), len(MAP.faces)
KILLS = int(os.environ.get("KILLS", "4"))


def labeled(text, faces):
    message = msg.MeshFaceClusterStamped(uuid=MAP.uuid, override=True)
    message.cluster.label, message.cluster.face_indices = text, faces
    return message


def layer(name, value=1.0):
    message = layer_message(name, value)
    message.uuid = MAP.uuid
    return message


def costs_update(name, value):
    message = arrays.MeshVertexCostsSparseStamped(uuid=MAP.uuid, type=name)
    message.mesh_vertex_costs = arrays.MeshVertexCostsSparse([3], [value], 0.0)
    return message


def face_costs(name, value):
    message = arrays.MeshFaceCostsStamped(uuid=MAP.uuid, type=name)
    message.mesh_face_costs.costs = np.full(FACES, value, np.float32)
    return message


def vertex_colors(value):
    message = arrays.MeshVertexColorsStamped(uuid=MAP.uuid)
    message.mesh_vertex_colors.vertex_colors = np.full((VERTICES, 4), 1, np.float32)
    message.mesh_vertex_colors.vertex_colors[:, 0] = value / 255
    return message


def texture(index, value):
    message = msg.MeshTexture(uuid=MAP.uuid, texture_index=index)
    image = message.image
    image.encoding, image.width, image.height, image.step = "rgb8", 1, 1, 3
    image.data = bytes([value, 0, 0])
    return message


class StoreResults(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.mkdtemp()
        self.addCleanup(shutil.rmtree, self.folder)
        self.path = os.path.join(self.folder, "a.h5")
        MapFile.write(self.path, MAP)
        self.space = "/results/" + self._testMethodName
        self.publishers = Publishers()
        self.heard = []
        self.stamp = 0
        self.servers = []

    def tearDown(self):
        for server in self.servers:
            server.stop(signal.SIGKILL)
            for line in server.logged("[ERROR]"):  # says why a test has failed
                sys.stderr.write(line + "\n")

    def serve(self, *arguments, **options):
        server = Server(self.space, "_inputFile:=" + self.path, *arguments, **options)
        self.servers.append(server)
        return server

    def listen(self, topic="store/result"):
        topic = self.space + "/" + topic
        subscriber = rospy.Subscriber(topic, StoreResult, self.heard.append, queue_size=1000)
        wait_until(lambda: connected(subscriber), "a connection to " + topic)
        self.addCleanup(subscriber.unregister)
        return subscriber

    def send(self, topic, message):
        """Returns the stamp that the message has."""
        self.stamp += 1
        header = message.image.header if topic == "store/texture" else message.header
        header.stamp = rospy.Time(self.stamp)
        self.publishers.send("%s/%s" % (self.space, topic), message)
        return self.stamp

    def results(self, stamp):
        return [found for found in self.heard if found.message_stamp.secs == stamp]

    def result(self, stamp, kind):
        """The result of this kind, of the message with this stamp."""
        found = wait_until(
            lambda: [one for one in self.results(stamp) if one.result == kind],
            "result %d of message %d" % (kind, stamp),
        )
        return found[0]

    def test_stored_comes_when_it_is_in_the_file(self):
        self.serve("_save_delay:=0.1")
        self.listen()
        for topic, message, name, is_in_file in (
            ("store/vertex_costs", layer("new"), "new", lambda m: "new" in m.vertex_costs),
            (
                "store/vertex_costs_update",
                costs_update("new", 5),
                "new",
                lambda m: m.vertex_costs["new"][3] == 5,
            ),
            (
                "store/face_costs",
                face_costs("steep", 2),
                "steep",
                lambda m: "steep" in m.face_attributes,
            ),
            (
                "store/vertex_colors",
                vertex_colors(99),
                "",
                lambda m: np.all(m.vertex_colors[:, 0] == 99),
            ),
            ("store/texture", texture(7, 200), "7", lambda m: m.textures[7][0, 0, 0] == 200),
            ("cluster_label", labeled("car_1", [4]), "car_1", lambda m: "car_1" in m.labels),
        ):
            found = self.result(self.send(topic, message), StoreResult.STORED)
            mesh, _ = read_map(self.path)  # labels are in the journal
            self.assertTrue(is_in_file(mesh), topic)
            self.assertEqual((found.uuid, found.topic, found.name), (MAP.uuid, topic, name))
            self.assertEqual(found.text, "")
            self.assertGreater(found.header.stamp, rospy.Time(0))
        self.assertEqual({found.result for found in self.heard}, {StoreResult.STORED})

    def test_refused_with_the_reason_and_on_diagnostics(self):
        server = self.serve("_save_delay:=0.1")
        self.listen()
        diagnostics = HeardDiagnostics()
        short = layer("short")
        short.mesh_vertex_costs.costs = np.zeros(3, np.float32)
        stranger = layer("of_another")
        stranger.uuid = "another"
        for topic, message, words in (
            ("store/vertex_costs", short, "3"),
            ("store/vertex_costs", stranger, "another"),
            ("store/vertex_costs_update", costs_update("a/b", 1), "a/b"),
            ("cluster_label", labeled("tree_1", [FACES]), str(FACES)),
        ):
            for _ in range(2):  # the log says it once, the wire each time
                found = self.result(self.send(topic, message), StoreResult.REFUSED)
                self.assertIn(words, found.text)
                self.assertEqual((found.uuid, found.topic), (message.uuid, topic))
        name = server.namespace.lstrip("/") + "/hdf5_map_server: maps"
        diagnostics.expected(name, WARN, "cluster_label refused: ")
        self.assertEqual({found.result for found in self.heard}, {StoreResult.REFUSED})

    def test_waiting_until_another_program_has_closed_the_file(self):
        self.serve("_save_delay:=0.05")
        self.listen()
        with held_open(self.path):
            stamp = self.send("store/vertex_costs", layer("new"))
            self.assertIn("has it open", self.result(stamp, StoreResult.WAITING).text)
            time.sleep(1.5)  # it is tried again each second, which is not told again
        self.result(stamp, StoreResult.STORED)
        kinds = [found.result for found in self.results(stamp)]
        self.assertEqual(kinds, [StoreResult.WAITING, StoreResult.STORED])
        self.assertIn("new", MapFile(self.path).layer_names())

    def test_label_manager(self):
        self.serve(executable="label_manager", ready="label_manager/save_map")
        self.listen("label_manager/store/result")
        stamp = self.send("label_manager/cluster_label", labeled("car_1", [4]))
        self.result(stamp, StoreResult.STORED)
        self.assertIn("car_1", read_map(self.path)[0].labels)
        stamp = self.send("label_manager/cluster_label", labeled("car_1", [FACES]))
        self.assertIn(str(FACES), self.result(stamp, StoreResult.REFUSED).text)

    def test_what_was_said_to_be_stored_survives_a_kill(self):
        chance = random.Random(3)
        sent, value = {}, 0  # (topic, name) -> stamp -> value
        for _ in range(KILLS):
            server = self.serve("_save_delay:=0.02")
            subscriber = self.listen()
            end = time.monotonic() + chance.uniform(0.1, 1.0)
            while time.monotonic() < end:
                value = value % 250 + 1
                topic, name, message = chance.choice(
                    (
                        ("store/vertex_costs", "a", layer("a", value)),
                        ("store/vertex_costs_update", "b", costs_update("b", value)),
                        ("store/face_costs", "c", face_costs("c", value)),
                        ("store/vertex_colors", "", vertex_colors(value)),
                        ("store/texture", "7", texture(7, value)),
                        ("cluster_label", "car_1", labeled("car_1", [value % FACES])),
                    )
                )
                sent.setdefault((topic, name), {})[self.send(topic, message)] = value
                time.sleep(0.02)
            server.stop(signal.SIGKILL)
            subscriber.unregister()
            self.publishers = Publishers()  # to the next one
            stored = {}
            for found in list(self.heard):
                key = found.topic, found.name
                stored[key] = max(stored.get(key, 0), found.message_stamp.secs)
            mesh, _ = read_map(self.path)
            values = {
                ("store/vertex_costs", "a"): lambda: mesh.vertex_costs["a"][0],
                ("store/vertex_costs_update", "b"): lambda: mesh.vertex_costs["b"][3],
                ("store/face_costs", "c"): lambda: mesh.face_attributes["c"][0],
                ("store/vertex_colors", ""): lambda: mesh.vertex_colors[0, 0],
                ("store/texture", "7"): lambda: mesh.textures[7][0, 0, 0],
                ("cluster_label", "car_1"): lambda: mesh.labels["car_1"].faces[0],
            }
            for key, stamp in stored.items():
                # that message, or a newer one
                allowed = {v for s, v in sent[key].items() if s >= stamp}
                if key[0] == "cluster_label":
                    allowed = {v % FACES for v in allowed}
                self.assertIn(values[key](), allowed, key)
        self.assertEqual({found.result for found in self.heard}, {StoreResult.STORED})
        kinds = {found.topic for found in self.heard}
        self.assertIn("cluster_label", kinds)
        self.assertGreaterEqual(len(kinds), 4)


if __name__ == "__main__":
    rospy.init_node("store_results")
    rostest.rosrun("mesh_msgs_hdf5", "store_results", StoreResults)
