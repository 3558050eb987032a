#!/usr/bin/python3
"""Messages sent as fast as they go: each is stored, none vanishes."""
import os
import shutil
import signal
import tempfile
import unittest

import numpy as np
import rospy
import rostest
from mesh_msgs import arrays, msg
from mesh_msgs.msg import StoreResult
from mesh_msgs.testing import wait_until
from mesh_msgs.testing_ros import connected
from server_process import Server

from mesh_msgs_hdf5.labels.map_contents import read_map
from mesh_msgs_hdf5.map_file import MapFile
from mesh_msgs_hdf5.model.mesh import Mesh

COUNT = 300
VERTICES = np.random.default_rng(1).random((COUNT + 2, 3), np.float32)
MAP = Mesh(VERTICES, np.arange(COUNT, dtype=np.uint32)[:, None] + np.arange(3, dtype=np.uint32))


def label(number):
    message = msg.MeshFaceClusterStamped(uuid=MAP.uuid, override=False)
    message.cluster.label, message.cluster.face_indices = "many_1", [number]
    return message


def update(number):
    message = arrays.MeshVertexCostsSparseStamped(uuid=MAP.uuid, type="updated")
    message.mesh_vertex_costs = arrays.MeshVertexCostsSparse([number], [number], 0.0)
    return message


def layer(number):
    message = arrays.MeshVertexCostsStamped(uuid=MAP.uuid, type="layer_%d" % number)
    message.mesh_vertex_costs.costs = np.full(len(VERTICES), number, np.float32)
    return message


class StoreBursts(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.mkdtemp()
        self.addCleanup(shutil.rmtree, self.folder)
        self.path = os.path.join(self.folder, "a.h5")
        MapFile.write(self.path, MAP)
        self.space = "/bursts/" + self._testMethodName
        self.heard = []

    def serve(self, name="first", **options):
        space = "%s/%s" % (self.space, name)
        server = Server(space, "_inputFile:=" + self.path, "_save_delay:=1", **options)
        self.addCleanup(server.stop, signal.SIGKILL)
        return server

    def listen(self, server, topic="store/result"):
        topic = server.namespace + "/" + topic
        subscriber = rospy.Subscriber(topic, StoreResult, self.heard.append)
        self.addCleanup(subscriber.unregister)
        wait_until(lambda: connected(subscriber), "a connection to " + topic)

    def burst(self, topic, messages, subscribers=1):
        # on this side none is dropped
        publisher = rospy.Publisher(topic, type(messages[0]), queue_size=0)
        self.addCleanup(publisher.unregister)
        wait_until(lambda: publisher.get_num_connections() >= subscribers, "server on " + topic)
        for number, message in enumerate(messages):
            message.header.stamp = rospy.Time(1 + number)
            publisher.publish(message)

    def expect_stored(self, count):
        """Each of so many messages has its own result."""
        stamps = set(range(1, count + 1))
        wait_until(
            lambda: {one.message_stamp.secs for one in list(self.heard)} >= stamps,
            "a result of each of %d messages" % count,
        )
        self.assertEqual({one.result for one in self.heard}, {StoreResult.STORED})

    def label_faces(self):
        return read_map(self.path)[0].labels["many_1"].faces.tolist()

    def test_labels(self):
        server = self.serve()
        self.listen(server)
        self.burst(server.namespace + "/cluster_label", [label(n) for n in range(COUNT)])
        self.expect_stored(COUNT)
        self.assertEqual(self.label_faces(), list(range(COUNT)))

    def test_labels_of_label_manager(self):
        name = "label_manager"
        server = self.serve(executable=name, ready=name + "/save_map")
        self.listen(server, name + "/store/result")
        topic = "%s/%s/cluster_label" % (server.namespace, name)
        self.burst(topic, [label(n) for n in range(COUNT)])
        self.expect_stored(COUNT)
        self.assertEqual(self.label_faces(), list(range(COUNT)))

    def test_labels_that_go_to_another_server(self):
        self.serve()
        second = self.serve("second")
        self.listen(second)
        count = 60
        self.burst(second.namespace + "/cluster_label", [label(n) for n in range(count)])
        self.expect_stored(count)
        self.assertEqual(self.label_faces(), list(range(count)))

    def test_updates(self):
        server = self.serve()
        self.listen(server)
        self.burst(
            server.namespace + "/store/vertex_costs_update", [update(n) for n in range(COUNT)]
        )
        self.expect_last()
        costs = MapFile(self.path).vertex_costs("updated")
        np.testing.assert_array_equal(costs[:COUNT], np.arange(COUNT))

    def expect_last(self):
        """What is said of the last message holds for those before it."""
        wait_until(
            lambda: COUNT in {one.message_stamp.secs for one in list(self.heard)},
            "the result of the last message",
        )
        self.assertEqual({one.result for one in self.heard}, {StoreResult.STORED})

    def test_layers(self):
        server = self.serve()
        self.listen(server)
        self.burst(server.namespace + "/store/vertex_costs", [layer(n) for n in range(COUNT)])
        self.expect_stored(COUNT)
        file = MapFile(self.path)
        self.assertEqual(set(file.layer_names()), {"layer_%d" % n for n in range(COUNT)})
        self.assertEqual(file.vertex_costs("layer_7").tolist(), [7] * len(VERTICES))


if __name__ == "__main__":
    rospy.init_node("store_bursts")
    rostest.rosrun("mesh_msgs_hdf5", "store_bursts", StoreBursts)
