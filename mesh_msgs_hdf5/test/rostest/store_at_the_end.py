#!/usr/bin/python3
"""What cannot be saved: the way out is said, and a node that ends without it says what is lost."""
import os
import shutil
import signal
import tempfile
import unittest

import numpy as np
import rospy
import rostest
from mesh_msgs import msg
from mesh_msgs.msg import StoreResult
from mesh_msgs.testing import wait_until
from mesh_msgs.testing_ros import connected
from server_process import Publishers, Server
from std_srvs.srv import Trigger

from mesh_msgs_hdf5.labels.map_contents import read_map
from mesh_msgs_hdf5.map_file import MapFile
from mesh_msgs_hdf5.model.mesh import Mesh

VERTICES = np.random.default_rng(1).random((12, 3), np.float32)
MAP = Mesh(VERTICES, np.arange(12, dtype=np.uint32).reshape(4, 3))
OTHER = Mesh(VERTICES + 1, MAP.faces)


class StoreAtTheEnd(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.mkdtemp()
        self.addCleanup(shutil.rmtree, self.folder)
        self.path = os.path.join(self.folder, "a.h5")
        MapFile.write(self.path, MAP)
        space = "/at_the_end/" + self._testMethodName
        self.server = Server(space, "_inputFile:=" + self.path, "_save_delay:=0.2")
        self.addCleanup(self.server.stop, signal.SIGKILL)
        self.publishers = Publishers()
        self.heard = []
        subscriber = rospy.Subscriber(space + "/store/result", StoreResult, self.heard.append)
        self.addCleanup(subscriber.unregister)
        wait_until(lambda: connected(subscriber), "a connection to store/result")

    def send(self, topic, message):
        message.uuid = MAP.uuid
        self.publishers.send("%s/%s" % (self.server.namespace, topic), message)

    def send_layer(self, name):
        message = msg.MeshVertexCostsStamped(type=name)
        message.mesh_vertex_costs.costs = [1.0] * len(VERTICES)
        self.send("store/vertex_costs", message)

    def result(self, kind, topic="store/vertex_costs"):
        return wait_until(
            lambda: [one for one in self.heard if (one.result, one.topic) == (kind, topic)],
            "result %d of a message on %s" % (kind, topic),
        )[0]

    def expect_lost(self, *words):
        self.assertEqual(self.server.stop(), 1)
        (line,) = self.server.logged("lost with the end of the node")
        self.assertIn("[ERROR]", line)
        for word in (self.path, *words):
            self.assertIn(word, line)

    def test_nothing_is_lost(self):
        self.send_layer("a")
        self.result(StoreResult.STORED)
        self.send_layer("b")  # is saved at the end
        self.assertEqual(self.server.stop(), 0)
        self.assertEqual(MapFile(self.path).layer_names(), ["a", "b"])

    def test_a_map_that_was_deleted_and_comes_back(self):
        kept = self.path + ".kept"
        os.rename(self.path, kept)
        self.send_layer("a")
        waits = self.result(StoreResult.WAITING).text
        self.assertIn("no such file (put the old file back, then it is saved)", waits)
        os.rename(kept, self.path)
        self.result(StoreResult.STORED)  # without another message
        self.assertEqual(MapFile(self.path).layer_names(), ["a"])

    def test_a_map_that_was_deleted(self):
        os.remove(self.path)
        for name in ("a", "b"):
            self.send_layer(name)
        self.result(StoreResult.WAITING)
        self.expect_lost("2 received changes", "store/vertex_costs a, store/vertex_costs b")

    def test_a_map_that_was_replaced(self):
        kept = self.path + ".kept"
        os.rename(self.path, kept)
        MapFile.write(self.path, OTHER)
        self.send_layer("a")
        self.assertIn(
            "(put the old file back, then it is saved)", self.result(StoreResult.WAITING).text
        )
        os.replace(kept, self.path)
        self.result(StoreResult.STORED)
        MapFile.write(self.path, OTHER)
        self.send_layer("b")
        self.expect_lost("1 received change (store/vertex_costs b)", "replaced the mesh")
        self.assertEqual(MapFile(self.path).uuid, OTHER.uuid)

    def test_a_read_only_map(self):
        os.chmod(self.path, 0o444)
        self.send_layer("a")
        label = msg.MeshFaceClusterStamped()
        label.cluster.label, label.cluster.face_indices = "tree_1", [1]
        self.send("cluster_label", label)
        self.assertIn("read-only (chmod u+w", self.result(StoreResult.WAITING).text)
        self.result(StoreResult.STORED, "cluster_label")
        answer = self.server.call("save_map", Trigger)
        self.assertFalse(answer.success)
        self.assertEqual(answer.message.count("read-only"), 1)  # of the layer and of the label
        self.expect_lost("1 received change (store/vertex_costs a)", "read-only")
        self.assertIn("tree_1", read_map(self.path)[0].labels)  # safe in the journal

    def test_only_labels_that_wait_in_the_journal(self):
        label = msg.MeshFaceClusterStamped()
        label.cluster.label, label.cluster.face_indices = "tree_1", [1]
        self.send("cluster_label", label)
        self.result(StoreResult.STORED, "cluster_label")
        os.chmod(self.path, 0o444)
        self.assertEqual(self.server.stop(), 0)
        self.assertIn("tree_1", read_map(self.path)[0].labels)

    def test_materials_without_their_textures(self):
        message = msg.MeshMaterialsStamped()
        parts = message.mesh_materials
        parts.materials = [msg.MeshMaterial(texture_index=7, has_texture=True)]
        parts.clusters = [msg.MeshFaceCluster(face_indices=list(range(4)))]
        parts.cluster_materials = [0]
        parts.vertex_tex_coords = [msg.MeshVertexTexCoords(0.5, 0.5)] * len(VERTICES)
        self.send("store/materials", message)
        self.result(StoreResult.WAITING, "store/materials")
        self.expect_lost("1 received change (store/materials)", "textures 7", "store/texture")


if __name__ == "__main__":
    rospy.init_node("store_at_the_end")
    rostest.rosrun("mesh_msgs_hdf5", "store_at_the_end", StoreAtTheEnd)
